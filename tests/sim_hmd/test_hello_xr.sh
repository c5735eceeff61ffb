#!/bin/sh
# Somebody else's program, unchanged: Debian's hello_xr, by both Vulkan extensions and under the
# Khronos core validation layer. It quits when its standard input ends.
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
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
failed=0

# run NAME SETTINGS EXPECTED ARGUMENTS…: hello_xr ends by itself or with its input, says what is
# expected, and no error. Its input ends when it has said so, or after 20 s.
input() {
    for _ in $(seq 100); do
        grep -q -- "$2" "$1" && break
        sleep 0.2
    done
}
run() {
    name=$1 settings=$2 expected=$3
    shift 3
    printf '%s' "$settings" >"$dir/settings.json"
    : >"$dir/$name.log"
    input "$dir/$name.log" "$expected" |
        ANTIPODE_SIM=$dir/settings.json timeout 60 stdbuf -oL hello_xr "$@" >"$dir/$name.log" 2>&1
    status=$?
    if [ $status -ne 0 ] || ! grep -q -- "$expected" "$dir/$name.log" ||
        grep -E '^\[[^]]*\[Error|antipode-sim: error|VALID|Error  *\]' "$dir/$name.log"; then
        echo "$name: status $status, expected '$expected' in:"
        tail -n 20 "$dir/$name.log"
        failed=1
    else
        echo "$name: ok"
    fi
}

tiny='"headset": {"name": "tiny", "refresh_hz": 60, "ipd_m": 0.06, "eyes": {
 "left": {"resolution_px": [96, 96], "fov_rad": {"left": -0.8, "right": 0.8, "up": 0.8, "down": -0.8}, "yaw_rad": 0},
 "right": {"resolution_px": [96, 96], "fov_rad": {"left": -0.8, "right": 0.8, "up": 0.8, "down": -0.8}, "yaw_rad": 0}}}'
focused='XR_SESSION_STATE_VISIBLE->XR_SESSION_STATE_FOCUSED'

run real2 "{$tiny}" "$focused" -g Vulkan2
run real1 "{$tiny}" "$focused" -g Vulkan
run virtual "{$tiny, \"clock\": \"virtual\", \"frames\": 20, \"capture\": {\"dir\": \"cap\", \"frames\": \"::10\"}}" \
    'XR_SESSION_STATE_IDLE->XR_SESSION_STATE_EXITING' -g Vulkan2
for f in 000000-left 000000-right 000010-left 000010-right; do
    [ -s "$dir/cap/$f.png" ] || { echo "virtual: no $f.png"; failed=1; }
done
[ "$(ls "$dir/cap" | grep -cv '^frames.jsonl$')" -eq 4 ] || { echo "virtual: other files too: $(ls "$dir/cap")"; failed=1; }
if [ -e /usr/share/openxr/1/api_layers/explicit.d/XrApiLayer_core_validation.x86_64-linux-gnu.json ]; then
    export XR_ENABLE_API_LAYERS=XR_APILAYER_LUNARG_core_validation
    run validated "{$tiny, \"clock\": \"virtual\", \"frames\": 20}" \
        'XR_SESSION_STATE_IDLE->XR_SESSION_STATE_EXITING' -g Vulkan2
else
    echo "validated: skipped, the core validation layer is not installed"
fi
exit $failed
