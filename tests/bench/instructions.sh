#!/bin/sh
# Instructions of whole runs of `antipode replay`, with what no eye can see left out and with
# --no-cull: instructions.sh PROGRAM [SCENE…]. Needs valgrind; three minutes of processor time a scene.
#
# Each run is counted twice, with one picture drawn of a walk and with two: the difference is one frame
# more, without starting, compiling shaders and stepping through the walk. A software device is
# counted with the program, so that it says what the pictures cost, too. What makes counts differ is
# held: no shader cache (a second run would compile less), no threads of the device's (they spin
# while they wait).
#
# A line per scene and way: millions of instructions a frame (two eyes), by whose they are; the
# last column is all of a run with one picture. HEADSET: a profile (ci.json, 360×400 an eye).
set -eu
program=${1:?"instructions.sh PROGRAM [SCENE…]"}
shift
[ $# -gt 0 ] || set -- honeycomb:5,3,4 honeycomb:5,3,4,struts seifert-weber honeycomb:4,3,4,struts \
	honeycomb:5,3,3,struts room:h3 room:e3 room:s3
command -v valgrind >/dev/null || { echo "skipped: no valgrind"; exit 77; }
headset=${HEADSET:-$(dirname "$0")/../../src/device/headsets/ci.json}
work=$(mktemp -d "${TMPDIR:-/tmp}/antipode-instructions.XXXXXX")
trap 'rm -rf "$work"' EXIT
export MESA_SHADER_CACHE_DISABLE=true LP_NUM_THREADS=0
"$program" walk --seconds 1 >"$work/walk.csv"

# Self costs by whose code it is. Inlined code counts where its source is; what has no name is code
# that the device made for the shaders.
sum() {
	awk '
	function name(text, names,    at) {
		at = text; sub(/\).*/, ")", at)
		if (length(text) > length(at)) names[at] = substr(text, length(at) + 2)
		return names[at]
	}
	function whose(object, file) {
		if (object ~ /libLLVM/) return "compiling"
		if (object ~ /libvulkan_|^\?\?\?$/) return "device"
		if (object ~ /libz\.|libpng/ || file ~ /src\/image\/|src\/app\/(html|page|pictures|contact)/)
			return "files"
		if (object ~ /libm\./ || file ~ /src\/(render|view|geom|scene)\//) return "placing"
		return "other"
	}
	/^ob=/ { object = name(substr($0, 4), objects); next }
	/^cob=/ { name(substr($0, 5), objects); next }
	/^f[lie]=/ { file = name(substr($0, 4), files); next }
	/^cf[il]=/ { name(substr($0, 5), files); next }
	/^calls=/ { skip = 1; next }
	/^[0-9+*-]/ {
		if (skip) skip = 0
		else { k = object SUBSEP file; if (!(k in of)) of[k] = whose(object, file); cost[of[k]] += $2 }
	}
	# Not %d, which mawk stops at 2^31.
	END { printf "%.0f %.0f %.0f %.0f %.0f\n", cost["placing"], cost["device"], cost["compiling"],
		cost["files"], cost["other"] }' "$1"
}

run() { # FRAMES options…
	frames=$1
	shift
	valgrind --tool=callgrind --callgrind-out-file="$work/counts" "$program" replay "$@" \
		--headset "$headset" --frames "$frames" --force --out "$work/out" "$work/walk.csv" \
		>"$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }
	sum "$work/counts"
}

echo "| millions of instructions a frame | | in all | program | device | compiling | files | other | a whole run |"
echo "|---|---|---|---|---|---|---|---|---|"
for scene in "$@"; do
	case $scene in
	room:*) option="--space ${scene#room:}" ;;
	*) option="--scene $scene" ;;
	esac
	for how in "" --no-cull; do
		# shellcheck disable=SC2086
		echo "$(run 30:31 $option $how) $(run 30:61:30 $option $how)" |
			awk -v scene="$scene" -v how="$how" '{
			for (i = 1; i <= 5; i++) { d[i] = ($(i + 5) - $i) / 1e6; all += d[i]; run += $i / 1e6 }
			printf "| %s | %s | %.0f | %.1f | %.0f | %.0f | %.0f | %.1f | %.0f |\n", scene,
				how ? how : "skips", all, d[1], d[2], d[3], d[4], d[5], run }'
	done
done
