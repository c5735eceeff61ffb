# From the kernel's devices through the simulated headset to an OpenXR program.
. /data/guest.sh
seconds=${VM_SECONDS:-20}
export XR_RUNTIME_JSON=/data/openxr_antipode.json ANTIPODE_SIM=/tmp/sim.json
echo '{"poses": {"devices": ["head=slimevr"], "stats": true}, "clock": "real"}' >/tmp/sim.json
make_recording slimevr 6283 1000 >/tmp/s.hid

name="1 kHz for $seconds s"
plug play_uhid /tmp/device --wait --rate 1000 --count 0 --serial K1 --sent /tmp/sent /tmp/s.hid
headset_client "$seconds" /tmp/sent >/tmp/out 2>&1
unplug $player
cat /tmp/out
check "$name: in order, as the recording turns" has /tmp/out '^located [0-9]+ backwards 0 aside 0'
check "$name: most of the time" test "$(sed -n 's/^located \([0-9]*\).*/\1/p' /tmp/out)" -gt $((seconds * 990))
check "$name: tracked all the time" test "$(grep -c '^state' /tmp/out)" = 1
check "$name: nothing lost, and where it was sent" at_most /tmp/out 'behind .* max' 8000
check "$name: behind" at_most /tmp/out 'behind .* p99' 2000
check "$name: age" at_most /tmp/out '99 of 100:' 2

name='unplugged in the middle of a frame, and plugged again'
make_recording slimevr 2000 1000 >/tmp/s.hid
plug play_usb /tmp/device --count 0 --rate 1000 --serial F1 /tmp/s.hid
until_true 3 test -e /dev/hidraw0
headset_client 30 - frames >/tmp/out 2>&1 &
client=$!
for times in 1 2 3; do
	[ $times = 1 ] || plug play_usb /tmp/device --count 0 --rate 1000 --serial F1 /tmp/s.hid
	check "$name: tracked" until_true 5 test_count $times '^state head tracked'
	usleep $((100000 + 3700 * times)) # at another place of a frame each time
	unplug $player
	check "$name: lost" until_true 1 test_count $times '^state head lost'
	check "$name: within 100 ms" within /tmp/out lost /tmp/device 100
done
unplug $client
cat /tmp/out
check "$name: no frame waits for a device" at_most /tmp/out longest 20000
finish
