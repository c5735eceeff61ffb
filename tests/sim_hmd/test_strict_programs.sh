#!/bin/sh
# Programs that are right have no errors in the lint's report: our own client, named by the first
# argument, and Debian's hello_xr, which quits when its standard input ends.
own=${1:?}
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
failed=0

# judge NAME PROGRAM…
judge() {
    name=$1
    shift
    tiny='{"name": "tiny", "refresh_hz": 60, "ipd_m": 0.06, "eyes": {
 "left": {"resolution_px": [96, 96], "fov_rad": {"left": -0.8, "right": 0.8, "up": 0.8, "down": -0.8}, "yaw_rad": 0},
 "right": {"resolution_px": [96, 96], "fov_rad": {"left": -0.8, "right": 0.8, "up": 0.8, "down": -0.8}, "yaw_rad": 0}}}'
    printf '{"headset": %s, "clock": "virtual", "frames": 60, "strict": true,
 "strict_report": "%s.jsonl", "capture": {"dir": "eyes", "frames": "::10"}}' "$tiny" "$name" \
        >"$dir/settings.json"
    sleep 3 | ANTIPODE_SIM=$dir/settings.json timeout 60 "$@" >"$dir/$name.log" 2>&1
    last=$(tail -n 1 "$dir/$name.jsonl")
    case $last in
    '{"errors":0,"warnings":0,'*) echo "$name: $last" ;;
    *)
        echo "$name: expected no errors and no warnings, got: $last"
        cat "$dir/$name.jsonl"
        tail -n 5 "$dir/$name.log"
        failed=1
        ;;
    esac
}

judge own "$own"
if ! command -v hello_xr >/dev/null; then
    echo "hello_xr: skipped, not installed"
elif [ "${ANTIPODE_SANITIZE:-}" = thread ]; then
    echo "hello_xr: skipped, not built for ThreadSanitizer"
else
    # A sanitized runtime in a host that is not: the sanitizer's library goes first.
    case ${ANTIPODE_SANITIZE:-} in
    *address*)
        LD_PRELOAD=$(${CC:-cc} -print-file-name=libasan.so)
        ASAN_OPTIONS=detect_leaks=0
        export LD_PRELOAD ASAN_OPTIONS
        ;;
    esac
    judge hello1 hello_xr -g Vulkan
    judge hello2 hello_xr -g Vulkan2
fi
exit $failed
