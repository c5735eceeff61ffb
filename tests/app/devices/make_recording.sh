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

# make_head_tracker: 40 reports of an Android head tracker in pairs of equal times, with the fields in
# another order than the protocol's example, 12 and 24 bits wide, and a reset counter of 4 bits that
# goes from 15 over 0 to 1.
make_head_tracker() {
	echo "# F: 24 06 23 41 6e 64 72 6f 69 64 48 65 61 64 54 72 61 63 6b 65 72 23 32 2e 30"
	echo "D: 0"
	printf "R: 92 05 20 09 e1 a1 01 85 06 15 00 26 ff 00 75 08 0a 08 03 95 17 b1 03"
	printf " 85 07 16 01 f8 26 ff 07 35 e0 45 20 0a 45 05 75 0c 95 03 81 02"
	printf " 15 00 25 0f 35 00 45 00 0a 46 05 75 04 95 01 81 02"
	printf " 17 01 00 80 ff 27 ff ff 7f 00 37 8a a1 20 fe 47 76 5e df 01 55 09"
	printf " 0a 44 05 75 18 95 03 81 02 c0\n"
	echo "N: Head tracker"
	echo "P: "
	echo "I: 5 1234 5678"
	awk 'BEGIN {
		for (i = 0; i < 40; i++) printf "E: 000000.%06d 15 07 00 00 00 00 %x0 %02x 00 00 00 00 00 00 00 00\n",
			int(i / 2) * 20000, (15 + int(i / 15)) % 16, i
	}'
}
