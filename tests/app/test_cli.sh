#!/bin/sh
# The command line: help, statuses, one-line errors, the man page and the completion.
. "$ANTIPODE_SOURCE/tests/app/lib.sh"

expect 2 'usage: antipode' "$antipode"
expect 0 '' "$antipode" --help
expect 0 '' "$antipode" --version
expect 2 "no command 'fly'" "$antipode" fly
commands=$("$antipode" --help | sed -n 's/^  \([a-z]*\) .*/\1/p')
[ "$(echo "$commands" | wc -w)" -ge 8 ] || fail "--help lists only: $commands"
for c in $commands; do
	expect 0 '' "$antipode" "$c" --help
	grep -q "usage: antipode $c" "$work/stdout" || fail "$c --help does not show its usage"
	grep -q "B $c\$" "$source_dir/docs/antipode.1" || fail "the man page does not tell of $c"
	sed -n 's/^  \(--[a-z-]*\) .*/\1/p' "$work/stdout" | grep -v -- '^--help$' | while read -r o; do
		escaped=$(printf '%s' "$o" | sed 's/-/\\\\-/g')
		sed -n "/B $c\$/,/^\.TP/p" "$source_dir/docs/antipode.1" | grep -q -- "$escaped" ||
			echo "$c $o"
	done >"$work/missing"
	[ ! -s "$work/missing" ] || fail "the man page misses: $(tr '\n' ';' <"$work/missing")"
	expect 2 'unknown option --nonsense' "$antipode" "$c" --nonsense
done
# What cannot be printed is not silently lost.
if [ -c /dev/full ]; then
	for c in --help --version 'track --help' walk; do
		status=0
		# shellcheck disable=SC2086
		"$antipode" $c >/dev/full 2>"$work/stderr" || status=$?
		[ "$status" = 4 ] || fail "$c on a full disk: status $status, expected 4"
		[ "$(grep -c 'cannot write to standard output' "$work/stderr")" = 1 ] ||
			fail "$c on a full disk says: $(cat "$work/stderr")"
	done
fi
expect 2 '--space: expected one of h3.s3.e3' "$antipode" track --space x9 log
expect 2 '--radius: expected a number' "$antipode" track --radius nan log
expect 2 'a value is missing' "$antipode" track --space
expect 2 'is missing' "$antipode" track
expect 2 'is missing' "$antipode" replay
expect 3 'no/such/log' "$antipode" track no/such/log
expect 3 'no/such/log' "$antipode" replay --out "$work/o" no/such/log
expect 3 'no/such' "$antipode" vergence "$work/no/such"

# A bad line in the middle: file, line, column; status 3; --skip-bad goes on.
cat >"$work/bad.csv" <<END
t_ns,device,px,py,pz,qx,qy,qz,qw
0,head,0,1.6,1,0,0,0,1
10000000,head,0,1.6,oops,0,0,0,1
20000000,head,0,1.6,1,0,0,0,1
END
expect 3 'bad.csv:3:' "$antipode" track "$work/bad.csv"
expect 0 '1 bad line' "$antipode" track --skip-bad "$work/bad.csv"
[ "$(wc -l <"$work/stdout")" = 3 ] || fail "--skip-bad: $(wc -l <"$work/stdout") lines, not 3"

# Completion, as bash runs it.
completed=$(PATH="$(dirname "$antipode"):$PATH" bash -c '
	. "$1"; COMP_WORDS=(antipode track --sp); COMP_CWORD=2; _antipode; echo "${COMPREPLY[*]}"
	COMP_WORDS=(antipode track --space ""); COMP_CWORD=3; _antipode; echo "${COMPREPLY[*]}"
	COMP_WORDS=(antipode rep); COMP_CWORD=1; _antipode; echo "${COMPREPLY[*]}"' \
	- "$source_dir/docs/antipode.bash" 2>&1 | tr '\n' ';')
[ "$completed" = '--space;h3 s3 e3;replay;' ] || fail "completion gave: $completed"

completed=$(PATH="$(dirname "$antipode"):$PATH" bash -c '
	. "$1"; COMP_WORDS=(antipode replay --scene ""); COMP_CWORD=3; cd /var/empty 2>/dev/null || cd /
	COMP_WORDS[3]=se; _antipode; echo "${COMPREPLY[*]}"
	COMP_WORDS[3]=honey; _antipode; echo "${COMPREPLY[*]}"
	COMP_WORDS[3]=torus,struts,wi; _antipode; echo "${COMPREPLY[*]}"
	COMP_WORDS=(antipode replay --scene honeycomb : 5,3); COMP_CWORD=5; _antipode; echo "${COMPREPLY[*]}"
	COMP_WORDS=(antipode play --scene honeycomb :); COMP_CWORD=4; _antipode; echo "${#COMPREPLY[*]}"
	COMP_WORDS=(antipode replay --scene honeycomb : 5,3,4,b); COMP_CWORD=5; _antipode; echo "${COMPREPLY[*]}"' \
	- "$source_dir/docs/antipode.bash" 2>&1 | tr '\n' ';')
[ "$completed" = 'seifert-weber;honeycomb:;torus,struts,width=;5,3,3 5,3,4 5,3,5;11;5,3,4,balls 5,3,4,budget=;' ] ||
	fail "completion of scenes gave: $completed"

# Scenes that are not there: the names that are, in one line; what is wrong in the words that were given.
expect 3 'the name of a scene: these are torus .*5,3,5' "$antipode" replay --scene tours "$work/bad.csv"
expect 2 'honeycomb: and one of 3,3,3 ' "$antipode" replay --scene honeycomb:5,3 "$work/bad.csv"
expect 2 "'wals' is not understood: expected after the name ,walls" \
	"$antipode" replay --scene torus,wals "$work/bad.csv"
expect 3 'budget=0: budget: expected a number from' "$antipode" replay --scene torus,budget=0 "$work/bad.csv"
expect 3 'honeycomb:6,3,3: .6,3,3. is a tiling of h3, but' \
	"$antipode" replay --scene honeycomb:6,3,3 "$work/bad.csv"

# A reader that goes away is a write error, not a signal.
"$antipode" walk 2>"$work/pipe" | head -n 1 >/dev/null
finish
