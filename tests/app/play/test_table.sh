#!/bin/sh
# A game in `play`, through the simulated headset: hands strike, the menu racks, the session is
# recorded and replayed to the same bytes, and whatever ends it, the game is kept.
. "$(dirname "$0")/../lib.sh"
if ! "$antipode" doctor 2>/dev/null | grep -q '^ok *Vulkan device'; then
	echo "skipped: no Vulkan device"
	exit 77
fi
ci="$work/small.json"
sed 's/\[360, 400\]/[96, 96]/; s/"refresh_hz": 90/"refresh_hz": 30/' "$source_dir/src/device/headsets/ci.json" >"$ci"
export XDG_CONFIG_HOME="$work/config" XDG_STATE_HOME="$work/state"

# stroke V SECONDS [EVERY]: both hands drive the cue along −z at V m/s through the cue ball on e3's
# head spot, again every so many seconds.
stroke() {
	awk -v V="$1" -v S="$2" -v EVERY="${3:-$2}" 'BEGIN {
		print "t_ns,device,px,py,pz,qx,qy,qz,qw"
		for (k = 0; k <= S * 90; k++) {
			t = k / 90; ns = sprintf("%.0f", k * 1e9 / 90)
			while (t > EVERY)
				t -= EVERY
			s = t < 0.4 ? 0.2 : t < 0.4 + 0.25 / V ? 0.2 - V * (t - 0.4) : -0.05
			printf "%s,head,0.1,1.5,1.3,-0.2,0,0,0.98\n", ns
			printf "%s,left,0,0.778575,%.9f,0,0,0,1\n", ns, 0.27 + s + 0.2
			printf "%s,right,0,0.778575,%.9f,0,0,0,1\n", ns, 0.27 + s + 0.75
		}
	}'
}
play="$antipode play --simulated --no-window --clock virtual --headset $ci --space e3"
stroke 1.2 4 >"$work/stroke.csv"

# A strike, recorded; then the menu: New rack, and a strike more is not there.
{
	echo "0,right,/input/trigger/value,0"
	echo "3000000000,left,/input/menu/click,1"
	echo "3100000000,left,/input/menu/click,0"
	echo "3200000000,left,/input/thumbstick,0,-1"
	echo "3300000000,left,/input/thumbstick,0,0"
	echo "3500000000,right,/input/trigger/value,1"
	echo "3600000000,right,/input/trigger/value,0"
} >"$work/keys.csv"
for run in 1 2; do
	$play --game eight-ball --new-game --stats --record "$work/rec$run" --input "$work/keys.csv" \
		"$work/stroke.csv" >"$work/log" 2>&1 || fail "play: $(tail -n 3 "$work/log")"
	grep -q '^1 strikes' "$work/log" || fail "strikes: $(grep strikes "$work/log")"
done
diff -r "$work/rec1" "$work/rec2" >"$work/diff" || fail "two plays differ: $(head -n 3 "$work/diff")"
awk '/^shot/ {
	for (i = 2; i <= NF; i++) {
		split($i, p, "="); v[p[1]] = p[2]
	}
	shots++
}
/^rack/ {racks++}
END {
	print "shots", shots, "racks", racks, "speed", v["speed"], "angle", v["angle"], "right", v["right"], "above", v["above"]
	ok = shots == 1 && racks == 1 && (v["speed"] - 1.2) ^ 2 < 1e-6 && v["angle"] ^ 2 < 1e-8
	exit !(ok && v["right"] ^ 2 < 1e-8 && v["above"] ^ 2 < 1e-8)
}' "$work/rec1/shots.txt" >"$work/said" || fail "the strike is not the hands': $(cat "$work/said")"

# Mid-shot at the end of the log: the runtime asks to end; the game is kept as it was, and again.
stroke 1.2 1 >"$work/short.csv"
$play --game nine-ball --record "$work/cut" "$work/short.csv" >"$work/log" 2>&1 || fail "play: $(cat "$work/log")"
kept="$XDG_STATE_HOME/antipode/game-e3-nine-ball.json"
grep -q '"shot": null' "$kept" && fail "the shot was over, or not begun"
cmp -s "$kept" "$work/cut/game.json" || fail "what is kept is not what was recorded"
for rec in rec1 cut; do
	expect 0 '' "$antipode" replay --headset "$ci" --space e3 --saved "$work/$rec/start.json" \
		--shots "$work/$rec/shots.txt" --pictures 1 --out "$work/out-$rec" "$work/$rec/poses.csv"
	cmp "$work/out-$rec/game.json" "$work/$rec/game.json" || fail "$rec: replayed to another game"
done
expect 2 'holds a recording' $play --record "$work/cut" "$work/short.csv"
expect 2 'no game' $play --game none --record "$work/none" "$work/short.csv"

# It goes on where it was: the same game, one shot more or the same, not a new rack.
expect 0 'goes on' $play --game nine-ball --record "$work/on" "$work/short.csv"
cmp -s "$work/on/start.json" "$work/cut/game.json" || fail "it does not go on where it was"
grep -q '"shots": 0' "$work/on/start.json" && fail "a new rack"

# Ctrl-C in the middle of a shot. By the real clock a busy machine may show too few frames of a
# stroke to strike, so there are more.
stroke 1.2 60 2 >"$work/strokes.csv"
rm -r "$XDG_STATE_HOME"
"$antipode" play --simulated --no-window --headset "$ci" --space e3 --game free --stats \
	"$work/strokes.csv" >"$work/log" 2>&1 &
pid=$!
kept="$XDG_STATE_HOME/antipode/game-e3-free.json"
n=0
while [ ! -e "$kept" ] && [ $n -lt 600 ]; do
	sleep 0.1
	n=$((n + 1))
done
kill -INT $pid
wait $pid || fail "Ctrl-C: status $?: $(tail -n 3 "$work/log")"
grep -q '"shots": [1-9]' "$kept" || fail "Ctrl-C: the shot is not kept"
no_parts "$work"

# A game of another version, or of another table, is told and kept.
sed 's/"antipode_game": 1/"antipode_game": 7/' "$kept" >"$kept.new"
mv "$kept.new" "$kept"
cp "$kept" "$work/seven.json"
expect 0 'version 7.*kept as' $play --game free "$work/short.csv"
cmp -s "$kept.1" "$work/seven.json" || fail "the file of another version is gone"
expect 0 'a table of 0.9 m.*kept as' $play --game free --table-edge 1 "$work/short.csv"
expect 0 'a table of 1 m.*kept as' $play --game free "$work/short.csv"
expect 0 '' $play --game free --new-game "$work/short.csv"
[ -e "$kept.4" ] && fail "--new-game made a copy"
expect 3 'of free' "$antipode" replay --headset "$ci" --space e3 --game nine-ball --saved "$kept" \
	--out "$work/x" "$work/short.csv"
expect 3 'a table of' "$antipode" replay --headset "$ci" --space h3 --saved "$kept" --out "$work/x" "$work/short.csv"
finish
