# The live layer (src/device/live) and the kernel's real HID and USB stack.
. /data/guest.sh
seconds=${VM_SECONDS:-3}
make_recording slimevr 4000 1000 >/tmp/s.hid
make_recording android 300 100 0.3 >/tmp/a.hid

# watch OUTPUT options…: in the background; its number in $watcher.
watch() {
	watch_output=$1
	shift
	live_watch "$@" >"$watch_output" 2>&1 &
	watcher=$!
	until_true 5 grep -q ready "$watch_output" || fail "live_watch $*: $(cat "$watch_output")"
}

for player_kind in play_uhid play_usb; do
	name="$player_kind at 1 kHz for $seconds s"
	plug $player_kind /tmp/device --count 0 --rate 1000 --serial K1 --sent /tmp/sent /tmp/s.hid
	watch /tmp/out --for "$seconds" --recording /tmp/s.hid --sent /tmp/sent
	wait $watcher
	unplug $player
	cat /tmp/out
	check "$name: nothing lost, in order" has /tmp/out '^read [0-9]{4,} lost 0 strange 0'
	check "$name: the poses are the recording's" at_most /tmp/out 'poses [0-9]* worst' 4e-16
	check "$name: age" at_most /tmp/out 'age .* p99' 2000
	check "$name: dates" at_most /tmp/out 'dated .* p99' 2000
	check "$name: the head" has /tmp/out '^device K1 running slimevr .*role head'
done

# In the middle of a read: the reader waits for the next report all the time.
for player_kind in play_uhid play_usb; do
	name="$player_kind, unplugged and plugged again"
	watch /tmp/out --for 20 --recording /tmp/s.hid
	for times in 1 2; do
		plug $player_kind /tmp/device --count 0 --rate 1000 --serial P1 /tmp/s.hid
		check "$name: tracked by itself" until_true 3 test_count $times '^state head tracked'
		usleep 200000
		unplug $player
		check "$name: lost" until_true 1 test_count $times '^state head lost'
		check "$name: within 100 ms" within /tmp/out lost /tmp/device 100
	done
	unplug $watcher
	check "$name: in order" has /tmp/out '^read [0-9]{3,} .*strange 0'
	check "$name: the same device" has /tmp/out '^device P1 unplugged slimevr .*gone 2 role head'
done

name='two equal devices'
make_recording slimevr 4000 1000 1.5 >/tmp/s2.hid
plug play_uhid /tmp/device1 --count 0 --rate 500 --serial one /tmp/s.hid
first=$player
plug play_uhid /tmp/device2 --count 0 --rate 500 --serial two /tmp/s2.hid
watch /tmp/out --for 2 --assign head=two --assign left=one --serial two --recording /tmp/s2.hid
wait $watcher
check "$name: told apart by serial" has /tmp/out '^device one running .*role left'
check "$name: told apart by serial" has /tmp/out '^device two running .*role head'
check "$name: each its own poses" at_most /tmp/out 'poses [0-9]* worst' 4e-16
unplug $first

name='a stall of 300 ms'
watch /tmp/out --for 3 --serial two --recording /tmp/s2.hid
usleep 700000
kill -STOP $watcher
usleep 300000
kill -CONT $watcher
wait $watcher
check "$name: age afterwards" at_most /tmp/out 'age median' 4000
check "$name: goes on in order" has /tmp/out '^read [0-9]{3,} lost [0-9]+ strange 0'
cat /tmp/out
unplug $player

name='a device that sends garbage'
make_recording garbage 500 1000 >/tmp/g.hid
plug play_uhid /tmp/device1 --count 0 --rate 500 --serial noisy /tmp/g.hid
first=$player
plug play_uhid /tmp/device2 --count 0 --rate 500 --serial good /tmp/s.hid
watch /tmp/out --for 2 --assign head=good --serial good --recording /tmp/s.hid
wait $watcher
unplug $player
unplug $first
cat /tmp/out
check "$name: is counted" has /tmp/out '^device noisy running slimevr .* bad [1-9][0-9]'
check "$name: the other goes on" has /tmp/out '^read [0-9]{3,} lost 0 strange 0'

name='a missing permission'
plug play_uhid /tmp/device --count 0 --rate 100 --serial shut /tmp/s.hid
chmod 600 /dev/hidraw*
su user -c 'antipode devices --seconds 0.1; echo status $?' >/tmp/out 2>&1
cat /tmp/out
check "$name: told" has /tmp/out 'shut .*slimevr .*denied +/dev/hidraw0'
check "$name: the rule" has /tmp/out 'put 70-antipode.rules'
check "$name: where it belongs" has /tmp/out '/etc/udev/rules.d'
check "$name: status" has /tmp/out '^status 1$'
chmod 666 /dev/hidraw*
su user -c 'antipode devices --seconds 0.3; echo status $?' >/tmp/out 2>&1
unplug $player
check "$name: given" has /tmp/out 'shut .*slimevr .*head +/dev/hidraw0'
check "$name: given, status" has /tmp/out '^status 0$'

name="a sensor that the kernel's sensor hub takes"
plug play_uhid /tmp/device --count 0 --rate 100 --serial ear /tmp/a.hid
watch /tmp/out --for 2 --recording /tmp/a.hid
wait $watcher
unplug $player
cat /tmp/out /tmp/device
check "$name: is read" has /tmp/out '^device ear running android-head-tracker .* role head'
check "$name: is switched on" has /tmp/device '^feature 1: 01 '
finish
