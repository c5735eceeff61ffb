#!/bin/sh
# The recipe of docs/ci.md as it is, with hello_xr in the place of somebody's program.
command -v hello_xr >/dev/null || { echo "skipped: hello_xr is not installed"; exit 77; }
[ -z "${ANTIPODE_SANITIZE:-}" ] || { echo "skipped: the recipe is for a plain build"; exit 77; }
. "$ANTIPODE_SOURCE/tests/app/lib.sh"
PATH=$(dirname "$antipode"):$PATH
OUT=$work/out
export PATH OUT
job=$source_dir/docs/examples/ci-job.sh

expect 0 '' "$job" "$work/reference" hello_xr -g Vulkan2
grep -q 'is new' "$work/stdout" || fail "the first run did not make a reference"
[ "$(ls "$work/reference" | grep -c png)" = 20 ] || fail "reference: $(ls "$work/reference")"
ANTIPODE_LIMITS='' expect 0 '' "$job" "$work/reference" hello_xr -g Vulkan
cp "$work/reference/000030-left.png" "$work/reference/000030-right.png"
expect 1 '' "$job" "$work/reference" hello_xr -g Vulkan2
grep -q '000030-right.png: differs' "$work/stdout" || fail "no word of the difference"
[ -s "$work/out/diff/000030-right-diff.png" ] || fail "diff: $(ls "$work/out/diff")"
finish
