#!/bin/sh
# Somebody else's program under `antipode sim`: it is asked to end, and what it drew repeats.
command -v hello_xr >/dev/null || { echo "skipped: hello_xr is not installed"; exit 77; }
# A sanitized runtime in a host that is not: the sanitizer's library goes first.
case ${ANTIPODE_SANITIZE:-} in
*address*)
	LD_PRELOAD=$(${CC:-cc} -print-file-name=libasan.so)
	ASAN_OPTIONS=detect_leaks=0
	export LD_PRELOAD ASAN_OPTIONS
	;;
thread) echo "skipped: hello_xr is not built for ThreadSanitizer"; exit 77 ;;
esac
. "$ANTIPODE_SOURCE/tests/app/lib.sh"
cat >"$work/tiny.json" <<END
{"name": "tiny", "refresh_hz": 60, "ipd_m": 0.06, "eyes": {
 "left": {"resolution_px": [96, 96], "fov_rad": {"left": -0.8, "right": 0.8, "up": 0.8, "down": -0.8}, "yaw_rad": 0},
 "right": {"resolution_px": [96, 96], "fov_rad": {"left": -0.8, "right": 0.8, "up": 0.8, "down": -0.8}, "yaw_rad": 0}}}
END
sim="$antipode sim --headset $work/tiny.json --clock virtual --timeout 60 --hold-stdin"

for run in a b; do
	expect 0 '' $sim --frames 40 --capture "$work/$run" --capture-frames ::20 -- hello_xr -g Vulkan2
	grep -q 'STATE_IDLE->XR_SESSION_STATE_EXITING' "$work/stdout" "$work/stderr" ||
		fail "hello_xr was not asked to end"
done
for f in 000000-left 000000-right 000020-left 000020-right; do
	[ -s "$work/a/$f.png" ] || fail "no $f.png"
	cmp "$work/a/$f.png" "$work/b/$f.png" || fail "$f.png differs from run to run"
done
[ ! -e "$work/a/000040-left.png" ] || fail "a frame after the last was captured"

# It would go on for ever.
expect 4 'hello_xr had not ended after 2 s and was stopped' \
	"$antipode" sim --headset "$work/tiny.json" --timeout 2 --hold-stdin -- hello_xr -g Vulkan2
finish
