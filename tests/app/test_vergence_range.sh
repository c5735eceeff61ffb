#!/bin/sh
# Vergence over the range that is promised: targets at 0.2 to 3 rho, in s3 past a quarter turn, and past
# the antipode the long way round, each before a clutter of lit balls that its rim cuts. None is off by
# more than 0.02 px, and no more than one in twenty is left out as if something hid part of it.
. "$ANTIPODE_SOURCE/tests/app/lib.sh"
ci=$source_dir/src/device/headsets/ci.json
if ! "$antipode" doctor 2>/dev/null | grep -q '^ok *Vulkan device'; then
	echo "skipped: no Vulkan device"
	exit 77
fi

# One head, three poses, turned a little.
cat >"$work/head.csv" <<'EOF'
t_ns,device,px,py,pz,qx,qy,qz,qw
0,head,0,0,0,0,0,0,1
1000000000,head,0.003,-0.002,0.001,0,0.02,0,0.99979998
2000000000,head,-0.004,0.001,0.002,0.015,-0.01,0.005,0.999825
EOF

scene() { # geometry, rho, distances over rho…: a scene on standard output
	geometry=$1 rho=$2
	shift 2
	echo "$*" | awk -v geometry="$geometry" -v rho="$rho" '
	function S(t) { return geometry == "s3" ? sin(t) : geometry == "h3" ? (exp(t) - exp(-t)) / 2 : t }
	function inverse(s) {
		return geometry == "s3" ? atan2(s, sqrt(1 - s * s)) : geometry == "h3" ? log(s + sqrt(s * s + 1)) : s
	}
	# A ball in the direction (a, b, -1), d from the nose, alpha in half-angle.
	function ball(d, a, b, alpha, rest,  n, r, l, sine) {
		sine = S(d); if (sine < 0) sine = -sine
		r = rho * inverse(sin(alpha) * sine)
		l = sqrt(a * a + b * b + 1)
		n = (d > pi && geometry == "s3" ? d - 2 * pi : d) * rho / l
		printf "%s{\"ball\": {\"at_m\": [%.9g, %.9g, %.9g], \"radius_m\": %.9g, %s}}", comma,
			a * n, b * n, -n, r, rest
		comma = ",\n"
	}
	BEGIN { pi = atan2(0, -1) }
	{
		printf "{\"space\": {\"geometry\": \"%s\", \"radius_m\": %s}, \"background\": \"#203040\", \"objects\": [\n",
			geometry, rho
		for (k = 1; k <= NF; k++) {
			# Directions 0.2 apart, the near ones in the middle, where the eyes differ most.
			split("0 0 0.24 0.1 -0.22 0.14 0.02 -0.26 0.27 -0.21 -0.26 -0.2 0.03 0.27 0.36 0.33 -0.33 0.36 0.5 0.02 -0.5 -0.03 0.46 -0.4 -0.48 -0.38", at, " ")
			a = at[2 * k - 1]; b = at[2 * k]
			alpha = 0.024 + 0.004 * (k * 7 % 5)
			ball($k, a, b, alpha, sprintf("\"color\": \"#%02x%02x%02x\", \"lit\": false, \"target\": \"%s\"",
				k % 3 == 0 ? 255 : 40 + 11 * k, k % 3 == 1 ? 255 : 30 + 12 * k, k % 3 == 2 ? 255 : 35 + 10 * k, $k "rho"))
			past = $k * (geometry == "h3" ? 1.25 : 1.08); if (geometry == "s3") past = $k < pi ? (past > 3.06 ? 3.06 : past) : (past > 6.1 ? 6.1 : past)
			for (j = 0; j < 6; j++)
				ball(past, a + 1.25 * alpha * cos(j * 1.1 + k), b + 1.25 * alpha * sin(j * 1.1 + k),
					alpha * (0.35 + 0.05 * j), sprintf("\"color\": \"#%02x%02x%02x\", \"lit\": true",
					(60 + 90 * j) % 256, (200 + 70 * j) % 256, (90 + 110 * j) % 256))
		}
		print "\n]}"
	}'
}

near='0.2 0.35 0.6 1 1.4 1.8 2.2 2.6 3'
run() { # geometry, rho, view, distances…
	space=$1 rho=$2 view=$3
	shift 3
	scene "$space" "$rho" "$@" >"$work/scene.json"
	expect 0 '' "$antipode" replay --space "$space" --view "$view" --scene "$work/scene.json" \
		--headset "$ci" --frames "0:181:90" --force --out "$work/out" "$work/head.csv"
	expect 0 '' "$antipode" vergence "$work/out"
	told=$(awk -F, -v targets=$# 'NR > 1 {
			rows++; off = $6 < 0 ? -$6 : $6
			if ($6 == "") left++
			else if (off > 0.02) print "frame", $1, $2, "is off by", $6, "px, tolerance 0.02"
			if (off > worst) worst = off
		}
		END {
			if (rows != 3 * targets) print rows, "rows, not", 3 * targets
			if (left > rows / 20) print left, "of", rows, "are not measured, more than one in twenty"
			printf "worst %.4f px, %d of %d left out\n", worst, left, rows
		}' "$work/out/vergence.csv")
	echo "$space, rho $rho m, $view: $(echo "$told" | tail -n 1)"
	case $told in worst*) ;; *) fail "$space $rho $view: $told" ;; esac
}

# shellcheck disable=SC2086
for view in native tourist; do
	run h3 0.85 $view $near
	run e3 0.85 $view $near
	run s3 0.85 $view $near 3.6 4.2 4.9 5.6
	run s3 5 $view $near 3.4 4 4.6 5.9
	run h3 5 $view $near
done
finish
