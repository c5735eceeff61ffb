# make_slimevr N HZ: a SlimeVR receiver whose tracker turns about the vertical, and its buttons, as
# hid-recorder's text.
make_slimevr() {
	echo "D: 0"
	echo "R: 15 05 01 09 00 a1 01 09 00 75 08 95 40 81 02 c0"
	echo "N: SlimeVR receiver"
	echo "P: usb-test-1/input0"
	echo "I: 3 1209 7690"
	awk -v n="$1" -v hz="$2" '
		function word(x, v) { v = int(x * 32767 + (x < 0 ? -0.5 : 0.5)); if (v < 0) v += 65536
			return sprintf(" %02x %02x", v % 256, int(v / 256)) }
		BEGIN { r = sqrt(0.5)
			for (i = 0; i < n; i++) {
				us = int(i * 1e6 / hz); h = i * 0.002
				q = word(r * cos(h)) word(r * sin(h)) word(r * sin(h)) word(r * cos(h))
				p = " 01 05" q " 00 00 00 00 00 00"
				printf "E: %06d.%06d 64", int(us / 1e6), us % 1000000
				printf " ff 05 11 00 00 00 00 00 00 00 00 00 00 00 00 00"
				printf " 06 05 %02x 00 00 00 00 00 00 00 00 00 00 00 00 00", (i / 10) % 2
				print p p
			}
		}'
}
