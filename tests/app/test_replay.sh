#!/bin/sh
# A walk becomes pictures: what is written, that it repeats byte for byte, that it is no black frame,
# and that faults leave nothing half-written.
. "$ANTIPODE_SOURCE/tests/app/lib.sh"
ci=$source_dir/src/device/headsets/ci.json
if ! "$antipode" doctor 2>/dev/null | grep -q '^ok *Vulkan device'; then
	echo "skipped: no Vulkan device"
	exit 77
fi
"$antipode" walk --seconds 4 >"$work/walk.csv" || fail "antipode walk"

for space in h3 s3 e3; do
	for run in 1 2; do
		"$antipode" replay --space $space --headset "$ci" --pictures 3 --out "$work/$space$run" \
			"$work/walk.csv" >"$work/log" 2>&1 || fail "replay $space: $(tail -n 2 "$work/log")"
	done
	rm -f "$work/$space"[12]/timing.csv
	diff -r "$work/${space}1" "$work/${space}2" >"$work/diff" || fail "$space differs: $(head -n 3 "$work/diff")"
	for f in frames.csv views.csv contact.png index.html vergence.csv capture.json 000000-left.png \
		000000-right.png 000000-sbs.png 000000-anaglyph.png; do
		[ -s "$work/${space}1/$f" ] || fail "$space: $f was not written"
	done
	cmp -s "$work/${space}1/000000-left.png" "$work/${space}1/000000-right.png" &&
		fail "$space: both eyes see the same picture"
	[ "$(stat -c %s "$work/${space}1/000000-left.png")" -gt 8000 ] || fail "$space: an empty picture"
	rows=$(awk -F, '$3 == "head"' "$work/${space}1/frames.csv" | wc -l)
	[ "$rows" -ge 355 ] || fail "$space: $rows head rows for 4 s at 90 Hz"
	# Vergence: what is measured is what is there.
	awk -F, 'NR > 1 && $5 != "" {n++; e = $6 < 0 ? -$6 : $6; if (e > worst) worst = e}
		END {print n + 0, worst + 0; exit !(n > 0 && worst < 0.15)}' "$work/${space}1/vergence.csv" \
		>"$work/worst" || fail "$space: vergence (rows, worst error in px): $(cat "$work/worst")"
	echo "$space: vergence rows and worst error in px: $(cat "$work/worst")"
done
no_parts "$work"

expect 2 'holds a capture already' "$antipode" replay --out "$work/h31" "$work/walk.csv"
expect 0 '' "$antipode" replay --headset "$ci" --frames 5:9:2 --force --stats --out "$work/h31" "$work/walk.csv"
grep -q 'vertices mapped' "$work/stdout" || fail "--stats says nothing"
[ -f "$work/h31/000007-left.png" ] || fail "--frames 5:9:2 did not draw frame 7"
expect 0 '' "$antipode" replay --view tourist --tracker naive --radius 1.5 --headset "$ci" \
	--frames 0:1 --out "$work/tourist" "$work/walk.csv"
# Somebody born elsewhere: measured as exactly as the others, against what is exact for her.
for who in s3:1.5 h3 e3; do
	expect 0 '' "$antipode" replay --space h3 --native-of $who --headset "$ci" --pictures 3 \
		--out "$work/of-$who" "$work/walk.csv"
	awk -F, 'NR > 1 && $5 != "" {n++; e = $6 < 0 ? -$6 : $6; if (e > worst) worst = e}
		END {print n + 0, worst + 0; exit !(n > 0 && worst < 0.15)}' "$work/of-$who/vergence.csv" \
		>"$work/worst" || fail "native-of $who: vergence (rows, worst error in px): $(cat "$work/worst")"
	echo "native-of $who: vergence rows and worst error in px: $(cat "$work/worst")"
done
cmp -s "$work/of-e3/000000-left.png" "$work/h32/000000-left.png" || fail "native-of e3 is not native"
cmp -s "$work/of-s3:1.5/000000-left.png" "$work/h32/000000-left.png" && fail "native-of s3 is native"
"$antipode" replay --space h3 --view tourist --headset "$ci" --pictures 3 --out "$work/as-tourist" \
	"$work/walk.csv" || fail "replay --view tourist"
cmp -s "$work/of-h3/000000-left.png" "$work/as-tourist/000000-left.png" ||
	fail "native-of the own space is not tourist"
expect 0 '' "$antipode" vergence "$work/of-s3:1.5"
expect 2 'as h3:0.85' "$antipode" replay --native-of h4 --out "$work/x" "$work/walk.csv"
expect 2 'as h3:0.85' "$antipode" replay --native-of s3:-1 --out "$work/x" "$work/walk.csv"
expect 2 'contradict' "$antipode" replay --native-of s3 --view native --out "$work/x" "$work/walk.csv"

# One eye shut: its picture is one colour, the other's is as it was.
expect 0 '' "$antipode" replay --space h3 --eye left --headset "$ci" --pictures 3 --out "$work/shut" \
	"$work/walk.csv"
cmp -s "$work/shut/000000-left.png" "$work/h32/000000-left.png" || fail "--eye left changes the left eye's picture"
[ "$(stat -c %s "$work/shut/000000-right.png")" -lt 4000 ] || fail "--eye left: the right eye still sees"

"$antipode" replay --headset "$ci" --frames 0:1 --out "$work/stdin" - <"$work/walk.csv" ||
	fail "replay from standard input"
expect 2 'contradict' "$antipode" replay --frames 0:1 --pictures 2 --out "$work/x" "$work/walk.csv"
expect 2 'no range of frames' "$antipode" replay --frames 7 --out "$work/x" "$work/walk.csv"
expect 2 'table-edge' "$antipode" replay --radius 1 --table-edge 0.9 --out "$work/x" "$work/walk.csv"

# Faults: no device, a wide fov, a ball too big for s3, a full disk, Ctrl-C.
expect 4 'Vulkan' env VK_ICD_FILENAMES=/nowhere.json VK_DRIVER_FILES=/nowhere.json \
	"$antipode" replay --headset "$ci" --out "$work/nodev" "$work/walk.csv"
sed 's/"left": -[0-9.]*/"left": -1.6/' "$ci" >"$work/wide.json"
expect 3 'wide.json: /eyes/left/fov_rad' "$antipode" replay --headset "$work/wide.json" --out "$work/x" "$work/walk.csv"
echo '{"space": {"geometry": "s3", "radius_m": 0.5}, "objects": [{"ball": {"at_m": [0,0,-1], "radius_m": 0.8}}]}' \
	>"$work/big.json"
expect 3 'big.json: /objects/0/ball/radius_m' "$antipode" replay --scene "$work/big.json" --out "$work/x" "$work/walk.csv"
expect 4 'cannot be written|cannot be made' "$antipode" replay --out /proc/nowhere/out "$work/walk.csv"
mkdir "$work/noloader" && : >"$work/noloader/libopenxr_loader.so.1"
expect 4 'install libopenxr-loader1' env LD_LIBRARY_PATH="$work/noloader" \
	"$antipode" replay --headset "$ci" --out "$work/x" "$work/walk.csv"
expect 4 'XR_RUNTIME_JSON' env XR_RUNTIME_JSON=/nowhere.json "$antipode" play --seconds 1

"$antipode" walk --seconds 0.5 >"$work/short.csv"
# Room for the tables (a limit of 60 blocks), not for a picture.
full() { (ulimit -f 60; trap '' XFSZ; exec "$antipode" replay --frames 0:20 --out "$work/full" "$work/short.csv"); }
expect 4 '000000-(left|right).png: cannot be written: File too large' full
[ -z "$(find "$work/full" -name '*.png' -size -2)" ] || fail "a full disk left a stump of a picture"
no_parts "$work/full"

"$antipode" replay --headset "$ci" --out "$work/cut" "$work/walk.csv" >"$work/log" 2>&1 &
pid=$!
i=0
while [ ! -f "$work/cut/000003-left.png" ] && [ $i -lt 300 ]; do
	sleep 0.1
	i=$((i + 1))
done
kill -INT $pid
status=0
wait $pid || status=$?
[ $status = 1 ] || fail "Ctrl-C: exit status $status, not 1: $(tail -n 2 "$work/log")"
grep -qi 'interrupted' "$work/cut/index.html" || fail "the page does not say that it was interrupted"
no_parts "$work/cut"
for f in "$work"/cut/*.png; do
	tail -c 8 "$f" | od -An -c | grep -q 'I   E   N   D' || fail "$f is not whole"
done
finish
