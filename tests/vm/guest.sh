# Sourced by the scripts that run in the virtual machine.
set -u
failures=0

fail() {
	echo "FAIL: $*"
	failures=$((failures + 1))
}

# check 'NAME' command…: the command must succeed.
check() {
	check_name=$1
	shift
	if "$@"; then
		echo "ok: $check_name"
	else
		fail "$check_name ($*)"
	fi
}

# has FILE PATTERN: else shows the file.
has() {
	grep -Eq -- "$2" "$1" && return 0
	echo "no /$2/ in $1:"
	tail -n 15 "$1"
	return 1
}

# at_most FILE WORD LIMIT: the number behind the word in the file.
at_most() {
	value=$(sed -n "s/.*$2 \([0-9.e+-]*\).*/\1/p" "$1" | tail -n 1)
	[ -n "$value" ] && awk -v v="$value" -v m="$3" 'BEGIN { exit !(v <= m) }' && return 0
	echo "$2 is '$value', at most $3 is right: $(tail -n 1 "$1")"
	return 1
}

# until_true SECONDS command…
until_true() {
	tries=$(($1 * 50))
	shift
	while [ $tries -gt 0 ]; do
		"$@" && return 0
		usleep 20000
		tries=$((tries - 1))
	done
	return 1
}

# plug PLAYER OUTPUT options…: in the background; its number in $player.
plug() {
	plug_program=$1 plug_output=$2
	shift 2
	: >"$plug_output"
	$plug_program "$@" >"$plug_output" 2>&1 &
	player=$!
	until_true 5 grep -q plugged "$plug_output" || fail "$plug_program $*: $(cat "$plug_output")"
}

# within OUTPUT 'STATE' PLAYER-OUTPUT MS: the role got into the state within so long of unplugging.
within() {
	when=$(sed -n "s/^state [a-z]* $2 at \([0-9]*\)/\1/p" "$1" | tail -n 1)
	unplugged=$(sed -n 's/^unplugged at \([0-9]*\)/\1/p' "$3" | tail -n 1)
	[ -n "$when" ] && [ -n "$unplugged" ] || { echo "$2 at '$when', unplugged at '$unplugged'"; return 1; }
	awk -v w="$when" -v u="$unplugged" -v m="$4" 'BEGIN { printf "%s %.1f ms after unplugging\n", "'"$2"'", (w - u) / 1e6; exit !(w >= u && w - u < m * 1e6) }'
}

# test_count N PATTERN: of lines in /tmp/out.
test_count() {
	[ "$(grep -c "$2" /tmp/out)" -ge "$1" ]
}

unplug() {
	kill "$1" 2>/dev/null
	wait "$1" 2>/dev/null
}

finish() {
	[ $failures -eq 0 ] || exit 1
	echo 'all as expected'
	exit 0
}
