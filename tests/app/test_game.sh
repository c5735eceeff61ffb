#!/bin/sh
# Scripted play: the table of events against the closed forms, faults in a script, and a replay whose
# balls move, the same bytes twice.
. "$ANTIPODE_SOURCE/tests/app/lib.sh"

cat >"$work/one.txt" <<END
clear
ball n=0 x=0 z=0.1
shot angle=0 speed=0.2
END
for space in h3 s3 e3; do
	"$antipode" simulate --space $space --no-pockets "$work/one.txt" >"$work/one.csv" ||
		fail "simulate $space"
	# Slides until 2v/(7 mu g) at 5/7 of v, rolls for that over mu_r·g.
	awk -F, '
		$2 == "shot" {v = sqrt($10 ^ 2 + $11 ^ 2 - 0); t0 = $1
			v = 1.75 * 0.2 / (0.17 / 0.54 + 1)}
		$2 == "roll" {roll = $1 - t0}
		$2 == "stop" {stop = $1 - t0}
		END {
			want = 2 * v / (7 * 0.2 * 9.81); rest = want + 5 / 7 * v / (0.01 * 9.81)
			print "roll", roll, want, "stop", stop, rest
			exit !((roll - want) ^ 2 < 1e-20 && (stop - rest) ^ 2 < 1e-16 && v > 0.2)
		}' "$work/one.csv" >"$work/closed" || fail "$space: $(cat "$work/closed")"
done

cat >"$work/shots.txt" <<END
shot at=1 speed=4.5 right=0.1 above=0.2
place
shot at=3 speed=2
END
for space in h3 s3 e3; do
	"$antipode" simulate --space $space --game eight-ball --step 0.1 "$work/shots.txt" \
		>"$work/$space.csv" || fail "simulate $space"
	"$antipode" simulate --space $space --game eight-ball --step 0.1 "$work/shots.txt" | cmp -s - "$work/$space.csv" ||
		fail "simulate $space: two runs differ"
	[ "$(grep -c ',balls,' "$work/$space.csv")" -gt 20 ] || fail "$space: no break"
	grep -q '^# eight-ball: player' "$work/$space.csv" || fail "$space: no judgement"
done
# A whole frame of eight-ball in each space is won.
for space in h3 s3 e3; do
	"$antipode" simulate --space $space --game eight-ball "$source_dir/docs/examples/frame-$space.txt" |
		grep '^#' | tail -n 1 >"$work/won"
	grep -q 'has won (the eight fell in its turn)' "$work/won" || fail "$space: $(cat "$work/won")"
done
printf 'shot at=1 speed=4\nshot at=99 speed=1\n' >"$work/bad.txt"
expect 3 'bad.txt:2: at: expected a ball' "$antipode" simulate "$work/bad.txt"
printf 'shot at=1 speed=400\n' >"$work/bad.txt"
expect 3 "bad.txt:1: the cue's speed is 400" "$antipode" simulate "$work/bad.txt"
expect 3 'none.txt' "$antipode" simulate "$work/none.txt"
expect 2 'side pockets' "$antipode" simulate --space h3 --side-pockets "$work/shots.txt"
expect 2 'contradict|fit|differ' "$antipode" simulate --space s3 --radius 1 --table-edge 0.9 "$work/shots.txt"

if ! "$antipode" doctor 2>/dev/null | grep -q '^ok *Vulkan device'; then
	echo "no Vulkan device: the replays are left out"
	finish
	exit
fi
ci=$source_dir/src/device/headsets/ci.json
"$antipode" walk --seconds 3 >"$work/walk.csv" || fail "antipode walk"
# Six pockets are a table of e3's, in the room as in the physics; a game on it is no game on another.
expect 2 'six pockets' "$antipode" replay --space h3 --side-pockets --out "$work/six" "$work/walk.csv"
expect 0 '' "$antipode" replay --space e3 --side-pockets --game free --shots "$work/shots.txt" \
	--headset "$ci" --frames 0:1 --out "$work/six" "$work/walk.csv"
grep -q '"side_pockets": true' "$work/six/game.json" || fail "the game has no side pockets"
expect 3 'six|four' "$antipode" replay --space e3 --game free --saved "$work/six/game.json" \
	--headset "$ci" --frames 0:1 --out "$work/four" "$work/walk.csv"
for run in 1 2; do
	expect 0 '' "$antipode" replay --space s3 --headset "$ci" --pictures 3 --game eight-ball \
		--shots "$work/shots.txt" --out "$work/r$run" "$work/walk.csv"
done
rm -f "$work"/r[12]/timing.csv
diff -r "$work/r1" "$work/r2" >"$work/diff" || fail "two replays differ: $(head -n 3 "$work/diff")"
grep -q '"game": "eight-ball"' "$work/r1/game.json" || fail "no game.json"
expect 0 '' "$antipode" replay --space s3 --headset "$ci" --pictures 3 --out "$work/still" "$work/walk.csv"
last=$(cd "$work/r1" && ls | grep -- '-left.png$' | tail -n 1)
cmp -s "$work/r1/$last" "$work/still/$last" && fail "$last: no ball has moved"
printf 'shot at=1 speed=400\n' >"$work/bad.txt"
expect 3 'bad.txt:1' "$antipode" replay --headset "$ci" --pictures 1 --shots "$work/bad.txt" --out "$work/bad" "$work/walk.csv"
finish
