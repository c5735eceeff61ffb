# Recordings, played once each through the kernel to an OpenXR program: what it is told of head and
# hands is what the recording says, by uhid, by USB and hidraw, and by USB alone. By uhid they are
# whole, by USB their first seconds (ANTIPODE_VM_SECONDS).
. /data/guest.sh
export XR_RUNTIME_JSON=/data/openxr_antipode.json ANTIPODE_SIM=/tmp/sim.json
echo '{"poses": {"devices": []}, "clock": "real"}' >/tmp/sim.json

# begin FILE: what of it is played by USB; its name.
begin() {
	awk -v most="${VM_SECONDS:-5}" '/^E:/ { if (!n++) t = $2; if ($2 - t > most) exit } { print }' "$1" >/tmp/begin.hid
	echo /tmp/begin.hid
}

# step FILE: ms; three of them for each of its reports.
step() {
	awk '/^E:/ { t[n++] = $2 } END { print 1000 * (t[n - 1] - t[0]) / (n - 1) / 3 }' "$1"
}

# near NAME: how far from its sending a pose may be dated, in ms. The Joy-Con's capture is 0.7 %
# slower than its timer, which is more than clocks differ: it is dated by its timer all the same.
near() {
	case $1 in *joycon*) echo 60 ;; *) echo 6 ;; esac
}

# aside NAME: what flies is integrated over times of arrival.
aside() {
	case $1 in *spacemouse*) echo 1e-3 ;; *) echo 1e-6 ;; esac
}

# arrives NAME PLAYER FILE
arrives() {
	: >/tmp/poses
	headset_poses "$(step "$3")" "$3" /tmp/sent "$(near "$1")" >/tmp/poses 2>&1 &
	client=$!
	until_true 5 grep -q ready /tmp/poses || fail "$1: headset_poses: $(cat /tmp/poses)"
	plug "timeout 60 $2" /tmp/device --wait --after 1.5 --hold 0.3 --sent /tmp/sent "$3"
	wait $player
	unplug $client
	grep -v ready /tmp/poses >/tmp/out
	sed "s|^|$1: |" /tmp/out
	check "$1: somebody" has /tmp/out '^(head|left) replayed [0-9]{3,}'
	while read -r line; do
		echo "$line" >/tmp/line
		check "$1: every pose" has /tmp/line ' missed 0 seen [1-9]'
		check "$1: as replayed" at_most /tmp/line aside "$(aside "$1")"
		check "$1: at its time" at_most /tmp/line p99 "$(near "$1")000"
	done </tmp/out
}

[ -z "${VM_FILES:-}" ] || for f in /data/*.hid; do case $f in *$VM_FILES*) ;; *) rm $f ;; esac; done
for file in /data/*.hid; do
	arrives "$(basename "$file" .hid), uhid" play_uhid "$file"
	arrives "$(basename "$file" .hid), USB and hidraw" play_usb "$(begin "$file")"
done
rmmod usbhid || fail 'usbhid does not go'
for file in /data/*.hid; do
	arrives "$(basename "$file" .hid), libusb" play_usb "$(begin "$file")"
done
finish
