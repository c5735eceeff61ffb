# Unplugged at random places, with random pauses; the same ones each time. An OpenXR program runs
# its frames meanwhile.
. /data/guest.sh
make_recording slimevr 4000 1000 >/tmp/s.hid
name='unplugged at random'
live_watch --for $((${VM_UNPLUG_SECONDS:-6} + 60)) >/tmp/out 2>&1 &
watcher=$!
until_true 5 grep -q ready /tmp/out
export XR_RUNTIME_JSON=/data/openxr_antipode.json ANTIPODE_SIM=/tmp/sim.json
echo '{"poses": {"devices": []}, "clock": "real"}' >/tmp/sim.json
headset_client $((${VM_UNPLUG_SECONDS:-6} + 60)) - frames >/tmp/frames 2>&1 &
program=$!
end=$(($(date +%s) + ${VM_UNPLUG_SECONDS:-6}))
seed=1 times=0 worst_lost=0 worst_back=0
# draw LIMIT: a number below it, in $drawn.
draw() {
	seed=$(((seed * 1103515245 + 12345) % 2147483648))
	drawn=$((seed / 65536 % $1))
}
# held: how many files and how much memory (kB) the program has.
held() {
	files=$(ls /proc/$program/fd | wc -l)
	memory=$(awk '/^VmRSS/ { print $2 }' /proc/$program/status)
}
while [ "$(date +%s)" -lt $end ]; do
	draw 2
	kind=play_uhid
	[ $drawn = 0 ] || kind=play_usb
	plug $kind /tmp/device --count 0 --rate 250 --serial R1 /tmp/s.hid
	plugged=$(awk '{printf "%d", $1 * 1000}' /proc/uptime)
	times=$((times + 1))
	until_true 5 test_count $times '^state head tracked' || { fail "$name: not back, $times"; break; }
	back=$(sed -n 's/^state head tracked at \([0-9]*\)[0-9]\{6\}$/\1/p' /tmp/out | tail -n 1)
	draw 400
	usleep $((1000 * drawn))
	unplug $player
	until_true 2 test_count $times '^state head lost' || { fail "$name: not lost, $times"; break; }
	lost=$(sed -n 's/^state head lost at \([0-9]*\)[0-9]\{3\}$/\1/p' /tmp/out | tail -n 1)
	gone=$(sed -n 's/^unplugged at \([0-9]*\)[0-9]\{3\}$/\1/p' /tmp/device)
	[ $((lost - gone)) -le $worst_lost ] || worst_lost=$((lost - gone))
	[ $((back - plugged)) -le $worst_back ] || worst_back=$((back - plugged))
	if [ $times = 4 ]; then # every way there is has been taken
		held
		files_before=$files memory_before=$memory
	fi
	draw 300
	usleep $((1000 * drawn))
done
until_true 2 test "$(tail -n 1 /tmp/frames | cut -d' ' -f3)" = lost
held
unplug $watcher
grep '^device' /tmp/out
unplug $program
echo "files $files_before, then $files; memory $memory_before kB, then $memory kB; $(tail -n 1 /tmp/frames)"
echo "$name: $times times, lost within $worst_lost us, back within $worst_back ms"
check "$name: often" test $times -gt 3
check "$name: lost within 100 ms" test $worst_lost -lt 100000
check "$name: back within 2 s" test $worst_back -lt 2000
check "$name: one device" has /tmp/out "^device R1 unplugged slimevr .*bad 0 gone $times role head"
check "$name: one device" test "$(grep -c '^device' /tmp/out)" = 1
check "$name: no file is left open" test "$files" = "$files_before"
check "$name: no memory is lost" test "$memory" -lt $((memory_before + 512))
check "$name: no frame waits for a device" at_most /tmp/frames longest 20000
# Not what comes and goes between two frames.
check "$name: the program saw it, too" test "$(grep -c '^state head lost' /tmp/frames)" -gt $((times * 9 / 10))
finish
