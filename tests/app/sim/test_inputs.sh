#!/bin/sh
# Input logs through the loader: what a program's actions say, frame by frame, at 10 frames a second.
. "$ANTIPODE_SOURCE/tests/app/lib.sh"
inputs=${ANTIPODE_SIM_INPUTS:?}
cat >"$work/keys.csv" <<END
# log time: the first head sample, at 5 s, is frame 0
5000000000,left,/input/trigger/value,0.25
5200000000,left,/input/trigger/value,0.75
5200000000,right,/input/a/click,1
5250000000,right,/input/thumbstick,0.5,-0.25
5300000000,right,/input/a/click,0
END
printf '5300000000,left,/input/trigger/value,0\n5000000000,right,/input/b/touch,1\n' |
	sort -n >"$work/more.csv"
cat >"$work/head.csv" <<END
t_ns,device,px,py,pz,qx,qy,qz,qw,trigger,squeeze,select
5000000000,head,0,1.6,0,0,0,0,1,,,
5000000000,left,0,1,0,0,0,0,1,1,0.5,0
5100000000,head,0,1.6,0,0,0,0,1,,,
5200000000,head,0,1.6,0,0,0,0,1,,,
5300000000,head,0,1.6,0,0,0,0,1,,,
5400000000,head,0,1.6,0,0,0,0,1,,,
END

# states NAME PROFILE "OPTIONS" PATHS…: into $work/states
states() {
	profile=/interaction_profiles/$1 options=$2
	shift 2
	"$antipode" sim --clock virtual --refresh 10 --timeout 60 $options -- "$inputs" "$profile" "$@" \
		>"$work/states" 2>"$work/stderr" </dev/null ||
		fail "$profile: status $?: $(tail -n 3 "$work/stderr")"
}

# is PATH "FRAME 0;FRAME 1;…": active and value
is() {
	got=$(awk -v path="$1" '$2 == path { printf "%s %s%s;", $3, $4, (NF > 4 ? " " $5 : "") }' \
		"$work/states")
	[ "$got" = "$2" ] || fail "$1: $got, expected $2"
}

logs="--poses $work/head.csv --input $work/keys.csv --input $work/more.csv"
states oculus/touch_controller "$logs" f:/user/hand/left/input/trigger/value \
	f:/user/hand/left/input/squeeze/value b:/user/hand/right/input/a/click \
	v:/user/hand/right/input/thumbstick b:/user/hand/right/input/b/touch
is /user/hand/left/input/trigger/value '1 0.25;1 0.25;1 0.75;1 0;1 0;'
is /user/hand/left/input/squeeze/value '1 0.5;1 0.5;1 0.5;1 0.5;1 0.5;' # the pose log's
is /user/hand/right/input/thumbstick '0 0 0;0 0 0;0 0 0;1 0.5 -0.25;1 0.5 -0.25;'
is /user/hand/right/input/a/click '0 0;0 0;1 1;1 0;1 0;'
is /user/hand/right/input/b/touch '1 1;1 1;1 1;1 1;1 1;'
[ ! -s "$work/stderr" ] || fail "unasked words: $(cat "$work/stderr")"

# Another kind of controller: what it has not is said once, the rest is translated.
states khr/simple_controller "$logs" b:/user/hand/left/input/select/click
is /user/hand/left/input/select/click '1 0;1 0;1 1;1 0;1 0;'
[ "$(grep -c 'right /input/thumbstick is no input of the Simple controller' "$work/stderr")" = 1 ] ||
	fail "no warning about the thumbstick: $(cat "$work/stderr")"

# Without pose logs the first frame is at 0; a log before the first pose is a warning.
printf '0,left,/input/trigger/value,1\n100000000,left,/input/trigger/value,0.5\n' >"$work/zero.csv"
states oculus/touch_controller "--frames 3 --input $work/zero.csv" \
	f:/user/hand/left/input/trigger/value
is /user/hand/left/input/trigger/value '1 1;1 0.5;1 0.5;'
states oculus/touch_controller "--poses $work/head.csv --input $work/zero.csv" \
	f:/user/hand/left/input/trigger/value
grep -q 'zero.csv: all of it lies before the first head pose' "$work/stderr" ||
	fail "no warning about the clock: $(cat "$work/stderr")"

# A gamepad is there where a log names it.
printf '0,gamepad,/input/b/click,1\n100000000,gamepad,/input/thumbstick_left,0.5,0.25\n' \
	>"$work/pad.csv"
states microsoft/xbox_controller "--frames 2 --input $work/pad.csv" b:/user/gamepad/input/b/click \
	v:/user/gamepad/input/thumbstick_left
is /user/gamepad/input/b/click '1 1;1 1;'
is /user/gamepad/input/thumbstick_left '1 0 0;1 0.5 0.25;'
states microsoft/xbox_controller "--frames 1" b:/user/gamepad/input/b/click
is /user/gamepad/input/b/click '0 0;'

# --strict: what breaks the specification makes 1 of 0, and no report is no praise.
strict="$antipode sim --clock virtual --frames 5 --timeout 60 --strict"
profile=/interaction_profiles/khr/simple_controller
path=b:/user/hand/left/input/select/click
expect 0 '' $strict -- "$inputs" $profile $path
expect 1 'broke the specification in 1 call' $strict -- "$inputs" !$profile $path
grep -q 'xrEndSession.*XR_ERROR_SESSION_NOT_RUNNING' "$work/stderr" ||
	fail "--strict: no word of xrEndSession: $(cat "$work/stderr")"
expect 0 '' "$antipode" sim --clock virtual --frames 5 --timeout 60 -- "$inputs" !$profile $path
expect 1 'true made no OpenXR instance' $strict -- true
expect 7 '' $strict -- sh -c 'exit 7'
expect 1 'broke the specification' $strict --capture "$work/c" -- "$inputs" !$profile $path
tail -n 1 "$work/c/strict.jsonl" | grep -q '"errors": *1' ||
	fail "DIR/strict.jsonl: $(cat "$work/c/strict.jsonl")"
finish
