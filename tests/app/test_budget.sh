#!/bin/sh
# A budget that is used up costs detail and one line, in every kind of scene: never the picture.
. "$ANTIPODE_SOURCE/tests/app/lib.sh"
ci=$source_dir/src/device/headsets/ci.json
if ! "$antipode" doctor 2>/dev/null | grep -q '^ok *Vulkan device'; then
	echo "skipped: no Vulkan device"
	exit 77
fi
"$antipode" walk --seconds 0.2 >"$work/walk.csv" || fail "antipode walk"

# A ball of 180,000 triangles as a model, and two of them.
awk 'BEGIN {
	n = 300; pi = atan2(0, -1)
	for (j = 0; j <= n; j++) for (i = 0; i < n; i++) {
		lat = pi * (j / n - 0.5); lon = 2 * pi * i / n
		printf "v %.6f %.6f %.6f\n", cos(lat) * sin(lon), sin(lat), cos(lat) * cos(lon) }
	for (j = 0; j < n; j++) for (i = 0; i < n; i++) {
		a = j * n + i + 1; b = j * n + (i + 1) % n + 1
		printf "f %d %d %d\nf %d %d %d\n", a, b, b + n, a, b + n, a + n }
}' >"$work/ball.obj"
cat >"$work/one.json" <<'END'
{"objects": [{"model": {"at_m": [0, 0.2, -1.2], "file": "ball.obj", "scale": 0.5, "color": "#e0c040"}}]}
END
cat >"$work/two.json" <<'END'
{"space": {"geometry": "e3"}, "objects": [
 {"model": {"at_m": [0.7, 0.2, -1.5], "file": "ball.obj", "scale": 0.5, "color": "#e0c040"}},
 {"model": {"at_m": [-0.7, 0.2, -1.5], "file": "ball.obj", "scale": 0.5, "color": "#40c0e0"}}]}
END
cat >"$work/many.json" <<'END'
{"space": {"geometry": "s3", "radius_m": 1}, "objects": [
 {"polygon": {"at_m": [0, -0.5, 0], "sides": 4, "edge_m": 1.5, "color": "#80a080"}},
 {"stick": {"from_m": [-0.5, 0, -0.6], "to_m": [0.5, 0.4, -0.6], "radius_m": 0.1}},
 {"ball": {"at_m": [0.3, 0.2, -0.9], "radius_m": 0.3, "color": "#ff2020", "lit": true}}]}
END

held() { # MiB, of --stats
	sed -n 's/^memory: at most \([0-9.]*\) MiB.*/\1/p' "$work/stdout"
}
run() { # BUDGET options…; the lines that speak of a budget in $work/told
	mib=$1
	shift
	# shellcheck disable=SC2086
	expect 0 '' "$antipode" replay "$@" ${mib:+--budget $mib} --headset "$ci" --frames 0:9:8 \
		--force --stats --out "$work/out$mib" "$work/walk.csv"
	grep budget "$work/stderr" >"$work/told"
}
# NAME BUDGET LINES options…: with that budget LINES lines, a picture like that of the default, no
# more memory held; with the default none.
scene() {
	name=$1 tiny=$2 lines=$3
	shift 3
	run '' "$@"
	[ -s "$work/told" ] && fail "$name: the default budget is told: $(cat "$work/told")"
	whole=$(held)
	run "$tiny" "$@"
	[ "$(wc -l <"$work/told")" = "$lines" ] ||
		fail "$name: with $tiny MiB $(wc -l <"$work/told") lines, not $lines: $(cat "$work/told")"
	held=$(held)
	awk -v held="$held" -v whole="$whole" -v most="$tiny" 'BEGIN {
		exit !(held > 0 && held <= most + 0.005 && held < whole) }' ||
		fail "$name: holds $held MiB of $tiny, $whole with the default"
	size=$(stat -c %s "$work/out$tiny/000000-left.png") full=$(stat -c %s "$work/out/000000-left.png")
	[ "$size" -gt $((full / 5)) ] || fail "$name: a picture of $size bytes, $full with the default"
	echo "$name: $held MiB of $tiny, $whole with the default; $size bytes of $full"
	cat "$work/told"
}
scene 'one model, h3' 2 1 --scene "$work/one.json"
scene 'two models, e3' 4 2 --scene "$work/two.json"
scene 'a model, a tenth of a MiB' 0.1 1 --scene "$work/one.json"
scene 'sheet, stick and ball of s3' 0.1 1 --scene "$work/many.json"
scene 'billiards, s3' 4 1 --space s3 --max-error 0.05
scene 'billiards, e3' 2 1 --space e3 --max-error 0.05
scene 'billiards, h3' 1 1 --space h3 --max-error 0.05
scene '{5,3,4}' 1 1 --scene honeycomb:5,3,4
scene 'struts' 0.6 1 --scene honeycomb:4,3,4,struts
scene 'the torus' 1 1 --scene torus,struts
scene 'the Poincaré space' 0.6 1 --scene poincare-dodecahedral
scene '{5,3,3} struts' 1 1 --scene honeycomb:5,3,3,struts
scene '{3,3,5}' 0.4 1 --scene honeycomb:3,3,5

# What has no room for the coarsest meshes and a list of its parts says so, and how much it needs.
refused() { # BUDGET options…
	mib=$1
	shift
	expect 2 "the budget of $mib MiB is too small.*give a --budget of" "$antipode" replay "$@" \
		--budget "$mib" --headset "$ci" --frames 0:1 --force --out "$work/bad" "$work/walk.csv"
	[ "$(grep -c budget "$work/stderr")" = 1 ] || fail "not one line: $(cat "$work/stderr")"
	[ -e "$work/bad/000000-left.png" ] && fail "a picture all the same"
}
refused 0.1 --scene honeycomb:5,3,4
refused 0.4 --scene seifert-weber
refused 0.2 --space h3

expect 2 'budget: expected 0.1 to' "$antipode" replay --budget 0 --out "$work/bad" "$work/walk.csv"
finish
