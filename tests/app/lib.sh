# Sourced by the shell tests of the program: where it is, and how to say what was wrong.
set -u
antipode=${ANTIPODE_PROGRAM:?}
source_dir=${ANTIPODE_SOURCE:?}
work=$(mktemp -d "${TMPDIR:-/tmp}/antipode-app.XXXXXX")
trap 'rm -rf "$work"' EXIT
failures=0

fail() {
	echo "FAIL: $*" >&2
	failures=$((failures + 1))
}

# expect STATUS 'PATTERN' command…: exit status, and one line on standard error that matches.
expect() {
	want=$1 pattern=$2
	shift 2
	status=0
	"$@" >"$work/stdout" 2>"$work/stderr" </dev/null || status=$?
	[ "$status" = "$want" ] || fail "$*: exit status $status, not $want: $(head -n 3 "$work/stderr")"
	if [ -n "$pattern" ]; then
		grep -Eq -- "$pattern" "$work/stderr" ||
			fail "$*: standard error has no /$pattern/: $(head -n 3 "$work/stderr")"
	fi
}

# A file may not be left half-written under any name.
no_parts() {
	parts=$(find "$1" -name '*.part')
	[ -z "$parts" ] || fail "half-written files were left: $parts"
}

finish() {
	[ "$failures" -eq 0 ] || exit 1
	echo "all as expected"
}
