#!/bin/sh
# `antipode sim` as the one who starts: statuses, signals, time, standard input, settings.
. "$ANTIPODE_SOURCE/tests/app/lib.sh"
sim="$antipode sim"

# What is wrong is said before the program starts.
expect 2 'PROGRAM .* is missing' $sim
expect 2 'unknown option --nonsense' $sim --nonsense -- true
expect 2 '--frames: expected a whole number' $sim --frames 0.5 -- true
expect 2 '--refresh: expected a rate' $sim --refresh 0 -- true
expect 2 '--timeout: expected seconds > 0' $sim --timeout -1 -- true
expect 2 '--recentre: expected rising seconds' $sim --recentre 2 --recentre 1 -- true
expect 3 'no/such/hands' $sim --hands no/such/hands -- true
expect 2 'need --capture DIR' $sim --layers -- true
expect 2 "'7' is no range" $sim --capture "$work/c" --capture-frames 7 -- true
expect 2 'standard input is the program' $sim --poses head=- -- true
expect 3 'no/such/headset' $sim --headset no/such/headset -- true
expect 3 'no/such/log' $sim --poses no/such/log -- true
expect 3 'no/such/input' $sim --input no/such/input -- true
printf '0,left,/input/x/click,2\n' >"$work/bad.csv"
expect 3 'bad.csv:1:23: expected 0 or 1' $sim --input "$work/bad.csv" -- true
[ ! -e "$work/c" ] || fail "a capture's folder was made for nothing"

# The program's status is ours, its options are its own.
expect 0 '' $sim -- true
expect 7 '' $sim -- sh -c 'exit 7'
expect 0 '' $sim sh -c 'exit 0' --frames -- x
expect 143 'ended by signal 15' $sim -- sh -c 'kill -TERM $$'
expect 4 'no-such-program cannot be started' $sim -- no-such-program
expect 4 'cannot be started' $sim -- "$work"

# Time: asked to end; then made to, with what it has started.
began=$(date +%s)
expect 4 'sleep had not ended after 0.3 s and was stopped' $sim --timeout 0.3 -- sleep 60
expect 4 'was stopped' $sim --timeout 0.3 -- \
	sh -c 'trap "" TERM; sleep 61 & echo $! >"$0"; sleep 61; sleep 61' "$work/pid"
took=$(($(date +%s) - began))
[ "$took" -lt 30 ] || fail "two time-outs took $took s"
# (Where nobody collects the dead it is a zombie.)
case $(sed 's/.*) //' "/proc/$(cat "$work/pid")/stat" 2>/dev/null) in
'' | Z* | X*) ;;
*) fail "what the stopped program had started still runs" ;;
esac
expect 0 '' $sim --timeout 60 -- true

# Signals go on to the program.
$sim -- sh -c 'trap "exit 33" TERM; echo ready >"$0"; while :; do sleep 0.1; done' "$work/ready" \
	</dev/null 2>"$work/stderr" &
pid=$!
for i in 1 2 3 4 5 6 7 8 9 10; do [ -s "$work/ready" ] || sleep 0.3; done
kill -TERM $pid
wait $pid
status=$?
[ $status = 33 ] || fail "SIGTERM to sim gave $status, not the program's 33"

# Standard input: ours, or one that is silent.
[ "$(echo hello | $sim -- cat)" = hello ] || fail "standard input does not reach the program"
expect 4 'cat had not ended' $sim --timeout 0.3 --hold-stdin -- cat

# The environment and the settings, whose paths do not depend on the folder.
printf 't_ns,device,px,py,pz,qx,qy,qz,qw\n0,head,0,1.6,0,0,0,0,1\n' >"$work/head.csv"
printf '0,left,/input/x/click,1\n' >"$work/keys.csv"
cat >"$work/show" <<'END'
cd / && cat "$ANTIPODE_SIM" && ls "$XR_RUNTIME_JSON" && echo "$ANTIPODE_SIM"
END
(cd "$work" && $sim --poses head=head.csv --input keys.csv --clock virtual --refresh 50 --frames 9 \
	--up z --skip-bad --table-at 1,2,0.5 --window --headset ci --hands head.csv \
	--recentre 1 --recentre 2.5 --draw-all --controllers htc/vive_controller -- sh "$work/show" >shown)
for word in '"clock": "virtual"' "\"head=$work/head.csv\"" "\"$work/keys.csv\"" '"refresh_hz": 50.0' \
	'"frames": 9' '"up": "z"' '"skip_bad": true' '"window": true' 'headsets/ci.json"' \
	'openxr_antipode.json' "\"hands\": \"$work/head.csv\"" '2.5' '"draw": "all"' \
	'"/interaction_profiles/htc/vive_controller"'; do
	grep -qF -- "$word" "$work/shown" || fail "the settings lack $word: $(cat "$work/shown")"
done
[ ! -e "$(tail -n 1 "$work/shown")" ] || fail "the temporary settings were left behind"

# A capture's settings stay; a second capture is not written into it unasked.
expect 0 'nothing was captured' $sim --capture "$work/c" --capture-frames ::5 -- true
grep -q '"frames": "::5"' "$work/c/sim.json" || fail "DIR/sim.json: $(cat "$work/c/sim.json")"
expect 2 'holds a capture already' $sim --capture "$work/c" -- true
touch "$work/c/000001-left.png" "$work/c/notes.txt"
expect 0 '' $sim --capture "$work/c" --force -- true
[ ! -e "$work/c/000001-left.png" ] || fail "--force left an old picture"
[ -e "$work/c/notes.txt" ] || fail "--force took somebody's notes away"
no_parts "$work/c"
finish
