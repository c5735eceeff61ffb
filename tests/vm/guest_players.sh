# The players and the machine themselves, by way of hidapi and libusb alone.
. /data/guest.sh
make_recording numbered 2000 1000 >/tmp/n.hid

name='uhid, hidapi'
plug play_uhid /tmp/device --wait --count 0 --rate 1000 --serial A1 --sent /tmp/sent /tmp/n.hid
read_hid_hidraw 1209:0001 A1 2000 /tmp/n.hid /tmp/sent 3 >/tmp/out 2>&1
unplug $player
cat /tmp/out
check "$name: latency" at_most /tmp/out p99 200
check "$name: nothing lost, in order" has /tmp/out '^read 2000 lost 0 strange 0'
check "$name: feature report read" has /tmp/out 'got feature 3: 03 01 02 03 04 05 06 07'
check "$name: feature report set" has /tmp/device 'feature 3: 03 5a 02 03'

# The libusb backend knows no serial before a device is open.
for backend in hidraw libusb; do
	serial=B2
	[ $backend = hidraw ] || serial=-
	name="USB, hidapi-$backend"
	plug play_usb /tmp/device --count 0 --rate 1000 --serial B2 --sent /tmp/sent /tmp/n.hid
	read_hid_$backend 1209:0001 $serial 1500 /tmp/n.hid /tmp/sent 3 >/tmp/out 2>&1
	unplug $player
	cat /tmp/out
	check "$name: latency" at_most /tmp/out p99 2000
	check "$name: nothing lost, in order" has /tmp/out '^read 1500 lost 0 strange 0'
	check "$name: feature report read" has /tmp/out 'got feature 3: 03 01 02 03 04 05 06 07'
	check "$name: feature report set" has /tmp/device 'feature 3: 03 5a 02 03'
done

name='USB, libusb'
plug play_usb /tmp/device --bare --wait --count 1200 --rate 1000 --hold 0.2 --sent /tmp/sent /tmp/n.hid
read_usb 1209:0001 2000 /tmp/n.hid /tmp/sent >/tmp/out 2>&1
wait $player
cat /tmp/out
check "$name: unplugged in the middle of a read" has /tmp/out '^gone read 1200 lost 0 strange 0 first 0'

name='a transfer that fails'
plug play_usb /tmp/device --wait --count 0 --rate 1000 --fail 300 /tmp/n.hid
read_hid_hidraw 1209:0001 - 1000 /tmp/n.hid >/tmp/out 2>&1
unplug $player
cat /tmp/out
check "$name: costs reports, and the reader goes on" has /tmp/out '^read 1000 lost [1-9][0-9]? strange 0'

name='a reader that stops for 0.3 s'
plug play_uhid /tmp/device --wait --count 0 --rate 1000 /tmp/n.hid
read_hid_hidraw 1209:0001 - 1000 /tmp/n.hid - 3 0.3 >/tmp/out 2>&1
unplug $player
cat /tmp/out
check "$name: the kernel drops reports" has /tmp/out '^read 1000 lost 2[0-9][0-9] strange 0'

name='two equal devices'
plug play_uhid /tmp/device1 --wait --count 0 --rate 100 --serial one /tmp/n.hid
first=$player
plug play_uhid /tmp/device2 --count 1 --hold 60 --serial two /tmp/n.hid
read_hid_hidraw 1209:0001 one 50 /tmp/n.hid >/tmp/out 2>&1
check "$name: told apart by serial" has /tmp/out '^read 50 lost 0'
unplug $player
unplug $first
finish
