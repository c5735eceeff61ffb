#!/bin/sh
# The real recordings, where they are at hand (ANTIPODE_SHARED): a walk round a desk in s3 with a
# table edge of 2 m, gaps and all, and a room-scale session with head and both hands.
. "$ANTIPODE_SOURCE/tests/app/lib.sh"
poses=${ANTIPODE_SHARED:-}/data/poses
if [ -z "${ANTIPODE_SHARED:-}" ] || [ ! -d "$poses" ]; then
	echo "skipped: ANTIPODE_SHARED does not name a folder with data/poses"
	exit 77
fi
ci=$source_dir/src/device/headsets/ci.json
"$antipode" replay --space s3 --table-edge 2 --headset "$ci" --pictures 4 --out "$work/desk" \
	"$poses/desk_walk_head.csv" >"$work/log" 2>&1 || fail "desk walk: $(tail -n 2 "$work/log")"
awk -F, 'NR > 1 {n[$4]++} END {print n["exact"] + 0, n["interpolated"] + 0, n["lost"] + 0;
	exit !(n["interpolated"] > 1000 && n["lost"] > 1000)}' "$work/desk/frames.csv" >"$work/states" ||
	fail "desk walk: exact, interpolated, lost: $(cat "$work/states")"
echo "desk walk: exact, interpolated, lost: $(cat "$work/states")"
for space in h3 s3 e3; do
	"$antipode" replay --space $space --tracker anchor --headset "$ci" --pictures 3 --out "$work/v$space" \
		"head=$poses/vive_room_head.tum" "left=$poses/vive_room_left.tum" \
		"right=$poses/vive_room_right.tum" >"$work/log" 2>&1 || fail "vive $space: $(tail -n 2 "$work/log")"
	for d in head left right; do
		rows=$(awk -F, -v d=$d '$3 == d' "$work/v$space/frames.csv" | wc -l)
		[ "$rows" -gt 2500 ] || fail "vive $space: $rows rows of $d"
	done
done
hid=$ANTIPODE_SHARED/data/hid/android_head_tracker_vive_head.hid
"$antipode" replay --space e3 --table-at 0,-1,0 --headset "$ci" --pictures 3 --out "$work/hid" "$hid" \
	>"$work/log" 2>&1 || fail "raw HID recording: $(tail -n 2 "$work/log")"
rows=$(awk -F, '$3 == "head"' "$work/hid/frames.csv" | wc -l)
[ "$rows" -gt 2500 ] || fail "raw HID recording: $rows rows of the head"
# A replay of a game, as it is and packed, a second later with a joystick's bytes as the left hand.
gzip -c "$poses/quest2_beatsaber_60s.bsor" >"$work/game"
for log in "$poses/quest2_beatsaber_60s.bsor" "$work/game" "$work/game,offset=1"; do
	n=$((${n:-0} + 1))
	"$antipode" replay --headset "$ci" --frames 0:21:20 --out "$work/game$n" "$log" \
		"pen=$ANTIPODE_SHARED/data/hid/joycon_left_grey_real.hid,offset=0.01,invert=yes" \
		>"$work/log" 2>&1 || fail "$log: $(tail -n 2 "$work/log")"
done
for f in frames.csv views.csv 000020-left.png; do
	cmp "$work/game1/$f" "$work/game2/$f" || fail "the packed game's $f is another"
done
cmp -s "$work/game1/frames.csv" "$work/game3/frames.csv" && fail "offset=1 changes nothing"
first=$(awk -F, 'NR == 2 {print $2}' "$work/game1/frames.csv")
later=$(awk -F, 'NR == 2 {print $2}' "$work/game3/frames.csv")
[ $((first + 1000000000)) = "$later" ] || fail "offset=1: the first frame is at $later, not a second after $first"
# Arguments go into the simulated headset's settings with their roles and options, paths made absolute.
cp "$poses/vive_room_head.tum" "$work/h.tum"
(cd "$work" && "$antipode" sim --poses head=h.tum,offset=1,up=y --timeout 30 \
	-- sh -c 'cat "$ANTIPODE_SIM"') >"$work/settings" 2>"$work/log" || fail "sim: $(cat "$work/log")"
grep -q "\"head=/.*/h.tum,offset=1,up=y\"" "$work/settings" || fail "sim's settings: $(cat "$work/settings")"
expect 3 'options are offset, ' "$antipode" sim --poses "head=$work/h.tum,ofset=1" -- true
expect 2 'standard input is the program' "$antipode" sim --poses head=-,up=z -- true
finish
