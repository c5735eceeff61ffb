# As many devices as the kernel has hidraw nodes for: 64 at once, 32 of them unplugged and plugged.
. /data/guest.sh
name='64 devices'
make_recording slimevr 100 25 >/tmp/s.hid
mkdir -p /tmp/players

# plug_many N…: numbers' players into /tmp/players. They start behind
# everybody else: so many keep the only processor busy.
plug_many() {
	for number; do
		polite=--polite
		[ "$number" != 10 ] || polite=
		play_uhid $polite --count 0 --rate 25 --serial "S$number" /tmp/s.hid >"/tmp/players/$number" 2>&1 &
		echo $! >"/tmp/players/$number.pid"
	done
}

# lines N PATTERN
lines() {
	[ "$(grep -Ec "$2" /tmp/out)" = "$1" ] && return 0
	echo "$(grep -Ec "$2" /tmp/out) lines of /$2/, $1 is right"
	return 1
}

nodes() {
	wanted=$1
	set -- /dev/hidraw*
	[ $# = "$wanted" ] || { usleep 100000; return 1; }
}

first=$(seq 10 41) second=$(seq 42 73)
plug_many $first $second
until_true 20 nodes 64 || fail "$name: $(ls /dev | grep -c hidraw) nodes"
antipode devices --seconds 0.3 >/tmp/out 2>&1
check "$name: all are listed" lines 64 'SlimeVR Receiver +usb +S[0-9]+ +slimevr '
check "$name: each role once" lines 3 ' (head|left|right) +/dev/hidraw'

live_watch --for 60 --assign head=S10 --assign foot=S40 --assign knee=S73 >/tmp/out 2>&1 &
watcher=$!
check "$name: tracked" until_true 5 test_count 1 '^state head tracked'
usleep 2000000
kill $(cat $(printf '/tmp/players/%s.pid ' $second))
until_true 5 nodes 32 || fail "$name: $(ls /dev | grep -c hidraw) nodes are left"
usleep 300000
plug_many $second
until_true 20 nodes 64 || fail "$name: $(ls /dev | grep -c hidraw) nodes again"
usleep 1200000
unplug $watcher
grep -v '^device' /tmp/out
check "$name: all of them, no others" lines 64 '^device S[0-9]+ running slimevr reports [0-9]{2,} bad 0 '
grep -E '^device S(4[2-9]|[5-7][0-9]) ' /tmp/out | grep -v ' gone 1 '
check "$name: half of them was gone" lines 32 '^device S[0-9]+ .* gone 1 '
check "$name: head" lines 1 '^device S10 .* gone 0 role head$'
check "$name: foot" lines 1 '^device S40 .* gone 0 role foot$'
check "$name: a role that was away" lines 1 '^device S73 .* gone 1 role knee$'
check "$name: all have a role" lines 64 '^device .* role [a-z]+[0-9]*$'
check "$name: each one once" test "$(sed -n 's/^device .* role //p' /tmp/out | sort -u | wc -l)" = 64
# In between the only processor is too busy with starting players to send each report in time.
check "$name: who stays is tracked" test "$(grep '^state' /tmp/out | tail -n 1 | cut -d' ' -f3)" = tracked
kill $(cat $(printf '/tmp/players/%s.pid ' $first $second))
finish
