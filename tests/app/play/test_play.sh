#!/bin/sh
# `play` without a window: an input log walks through the menu and takes a picture; the settings are
# kept and come back; what is wrong is said.
. "$(dirname "$0")/../lib.sh"
# Few and small pictures on the virtual clock.
ci="$work/small.json"
sed 's/\[360, 400\]/[120, 132]/; s/"refresh_hz": 90/"refresh_hz": 10/' "$source_dir/src/device/headsets/ci.json" >"$ci"
export XDG_CONFIG_HOME="$work/config"
s=1000000000
# The left stick pressed: a picture. Then the menu, up to the last row, right; up, right.
{
	# The scripted walk pulls triggers of its own.
	echo "0,left,/input/trigger/value,0"
	echo "0,right,/input/trigger/value,0"
	at=10
	for what in thumbstick/click,1: menu/click,1: thumbstick,0,1:,0 thumbstick,1,0:,0 \
		thumbstick,0,1:,0 thumbstick,1,0:,0; do
		input=${what%:*}
		echo "$((s / 10 * at)),left,/input/$input"
		echo "$((s / 10 * (at + 8))),left,/input/${input%%,*},0${what#*:}"
		at=$((at + 14))
	done
} >"$work/keys.csv"
mkdir "$work/pictures"
"$antipode" play --simulated --no-window --clock virtual --headset "$ci" --input "$work/keys.csv" --seconds 11 --stats \
	--pictures "$work/pictures" >"$work/log" 2>&1 || fail "play: $(tail -n 3 "$work/log")"
grep -q 'frames in' "$work/log" || fail "no --stats: $(cat "$work/log")"
kept="$XDG_CONFIG_HOME/antipode/play.json"
grep -q '"lines": "on"' "$kept" || fail "the menu kept: $(cat "$kept")"
grep -q '"game": "eight-ball"' "$kept" || fail "the menu kept: $(cat "$kept")"
for eye in left right sbs; do
	[ -s "$work/pictures/antipode-001-$eye.png" ] || fail "no picture of $eye: $(ls "$work/pictures")"
done
# Both eyes see a room, and not the same.
cmp -s "$work/pictures/antipode-001-left.png" "$work/pictures/antipode-001-right.png" &&
	fail "both eyes have the same picture"
colors=$(identify -format %k "$work/pictures/antipode-001-left.png" 2>/dev/null || echo 1000)
[ "$colors" -ge 200 ] || fail "the picture has $colors colours"
sed -i 's/"h3"/"q3"/' "$kept"
expect 3 '/space' "$antipode" play --simulated --no-window --seconds 1
expect 0 '' "$antipode" play --simulated --no-window --no-settings --headset "$ci" --seconds 1
finish
