# The live layer by way of hidapi, on the same kernel.
. /data/guest.sh
make_recording slimevr 4000 1000 >/tmp/s.hid

for player_kind in play_uhid play_usb; do
	name="hidapi, $player_kind at 1 kHz"
	plug $player_kind /tmp/device --count 0 --rate 1000 --serial K1 --sent /tmp/sent /tmp/s.hid
	live_watch --bus hidapi --for 2 --recording /tmp/s.hid --sent /tmp/sent >/tmp/out 2>&1
	unplug $player
	cat /tmp/out
	check "$name: nothing lost, in order" has /tmp/out '^read [0-9]{3,} lost 0 strange 0'
	check "$name: the poses are the recording's" at_most /tmp/out 'poses [0-9]* worst' 4e-16
	check "$name: age" at_most /tmp/out 'age .* p99' 2000
	check "$name: the head" has /tmp/out '^device K1 running slimevr .*role head'

	name="hidapi, $player_kind, plugged again"
	live_watch --bus hidapi --for 20 >/tmp/out 2>&1 &
	watcher=$!
	for times in 1 2; do
		plug $player_kind /tmp/device --count 0 --rate 1000 --serial P1 /tmp/s.hid
		check "$name: comes by itself" until_true 3 test_count $times '^state head tracked'
		unplug $player
		check "$name: lost" until_true 1 test_count $times '^state head lost'
		check "$name: within 100 ms" within /tmp/out lost /tmp/device 100
	done
	unplug $watcher
	check "$name: the same device" has /tmp/out '^device P1 unplugged slimevr .*gone 2 role head'
done
# Forty reports while the reader is elsewhere, and gone: hidapi fails before it has given them all.
name='hidapi, unplugged behind a burst'
live_watch --bus hidapi --for 20 --recording /tmp/s.hid >/tmp/out 2>&1 &
watcher=$!
until_true 5 grep -q ready /tmp/out
plug play_uhid /tmp/device --count 1040 --rate 1000 --late 1000 --late-for 0.4 --serial P1 /tmp/s.hid
check "$name: silent" until_true 5 test_count 1 '^state head lost'
kill -STOP $watcher
wait $player
kill -CONT $watcher
usleep 200000
unplug $watcher
cat /tmp/out
check "$name: all of it was read" awk '/^read/ { read = $2; lost = $4; first = $8 }
	END { exit !(read + first == 1040 && lost == 0) }' /tmp/out
check "$name: gone" has /tmp/out '^device P1 unplugged .*gone 1'
finish
