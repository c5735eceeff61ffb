#!/bin/sh
# What antipode calibrate finds is what live devices are read with: a Rift DK2 and an XREAL Air,
# worn upside down and with biases, end to end.
. "$(dirname "$0")/lib.sh"
export XDG_CONFIG_HOME="$work/config" HOME="$work/home"
mkdir -p "$work/home"

# motion SECONDS NODS LAST: both devices at 250 Hz on one head, which lies still for 1.3 s, nods by
# NODS degrees, down first, for 1.6 s, and then in 1 s goes down by LAST. The trackers are turned by
# half a turn about the view: (x, y, z) of the head are (-x, -y, z) of a tracker. Their gyroscopes are
# off by (0.5, 3, -0.8) and (-0.7, 0.4, 2.5) degrees a second.
motion() {
	awk -v seconds="$1" -v nods="$2" -v last="$3" '
	function le(v, n,  s, i) {
		v = int(v + (v < 0 ? -0.5 : 0.5))
		if (v < 0) v += 2 ^ (8 * n)
		for (i = 0; i < n; i++) { s = s sprintf(" %02x", v % 256); v = int(v / 256) }
		return s
	}
	function part(v) { v = int(v * 1e4 + (v < 0 ? -0.5 : 0.5)); return v < 0 ? v + 2097152 : v }
	function triple(x, y, z) { # three times 21 bits, big endian
		x = part(x); y = part(y); z = part(z)
		return sprintf(" %02x %02x %02x %02x %02x %02x %02x %02x", int(x / 8192), int(x / 32) % 256,
			x % 32 * 8 + int(y / 262144), int(y / 1024) % 256, int(y / 4) % 256,
			y % 4 * 64 + int(z / 32768), int(z / 128) % 256, z % 128 * 2)
	}
	function fill(r) { while (length(r) < 3 * 64) r = r " 00"; return r }
	function angle(t) { # degrees up
		if (t > 1.3 && t < 2.9) return -nods * sin((t - 1.3) / 1.6 * 2 * pi)
		return t < 3 ? 0 : t < 4 ? -last * (1 - cos(pi * (t - 3))) / 2 : -last
	}
	BEGIN {
		pi = atan2(0, -1); g = 9.80665
		descriptor = "R: 27 06 00 ff 09 01 a1 01 15 00 26 ff 00 75 08 95 40 09 01 81 02 95 40 09 02 91 02 c0"
		print "D: 0\n" descriptor "\nN: Rift DK2\nI: 3 2833 0021"
		print "D: 1\n" descriptor "\nN: Air\nI: 3 3318 0424"
		for (i = 0; i < seconds * 250; i++) {
			t = i / 250; a = angle(t) * pi / 180
			rate = (angle(t + 1e-4) - angle(t - 1e-4)) / 2e-4 # degrees a second about the head'"'"'s x
			fy = -g * cos(a); fz = -g * sin(a)                # what the trackers feel
			time = sprintf("E: %06d.%06d 64", int(t), i % 250 * 4000)
			r = " 0b 00 00 01" le(i % 65536, 2) " 00 00" le(i * 4000 + 1000, 4)
			r = r triple(0, fy, fz) triple((-rate + 0.5) * pi / 180, 3 * pi / 180, -0.8 * pi / 180)
			print "D: 0\n" time fill(r)
			# The Air: device axes (-x, z, y), thousandths of a degree a second, ten-thousandths of g.
			r = " 01 02" le(0, 2) le(i * 4000000 + 1000000000, 8) le(1, 2) le(1000, 4)
			r = r le(1000 * (rate + 0.7), 3) le(1000 * 2.5, 3) le(1000 * 0.4, 3)
			r = r le(1, 2) le(10000, 4) le(0, 3) le(1e4 * fz / g, 3) le(1e4 * fy / g, 3)
			print "D: 1\n" time fill(r)
		}
	}'
}

# The last pose of a role in what --watch says: yaw, pitch, roll.
last_pose() { awk -v role="$1" '$1 == role && $2 != "lost" {y = $3; p = $4; r = $5} END {print y, p, r}' "$2"; }
# By how much its heading went away from the first one.
drift() {
	awk -v role="$1" '$1 == role && $2 != "lost" {if (!n++) first = $3; d = $3 - first}
		END {if (n) print (d > 180 ? d - 360 : d < -180 ? d + 360 : d)}' "$2"
}
near() {
	awk -v a="$2" -v b="$3" -v t="$4" 'BEGIN { d = a - b; exit !(a != "" && d <= t && -d <= t) }' ||
		fail "$1: '$2', not $3 within $4"
}
far() {
	awk -v a="$2" -v b="$3" -v t="$4" 'BEGIN { d = a - b; exit !(a != "" && (d > t || -d > t)) }' ||
		fail "$1: '$2' is within $4 of $3 also without calibration: this test shows nothing"
}
# look NAME RECORDING: the poses of the first 6 s, into $work/NAME.
look() {
	"$antipode" devices --watch --seconds 6.2 --device head=rift --device hand=xreal \
		--replay "$2" >"$work/$1" 2>"$work/$1.err" || fail "$1: $(cat "$work/$1.err")"
}

motion 4.4 0 0 >"$work/rest.hid"
motion 3.4 30 0 >"$work/nod.hid"
motion 8 30 20 >"$work/worn.hid"

XDG_CONFIG_HOME="$work/none" look without "$work/worn.hid" &
without=$!
expect 0 '' "$antipode" calibrate rest --replay "$work/rest.hid"
cp "$work/stdout" "$work/rest.out"
grep -q '^2833:0021.*gyroscope 0.4[89][0-9]* \|^2833:0021.*gyroscope 0.50' "$work/rest.out" ||
	fail "rest of the Rift: $(cat "$work/rest.out")"
grep -q '^3318:0424.*gyroscope -0.7000 0.4000 2.5000' "$work/rest.out" ||
	fail "rest of the Air: $(cat "$work/rest.out")"
# How it is mounted is measured with the biases taken off: they would turn a head that holds still.
for device in 2833:0021 3318:0424; do
	expect 0 '' "$antipode" calibrate mount --only $device --replay "$work/nod.hid"
	grep -Eq "^$device: .*axes -?0\.00[0-9]* -?0\.00[0-9]* -?(1\.0|0\.9999)[0-9]* -?0\.00[0-9]*," \
		"$work/stdout" || fail "mount of $device: $(cat "$work/stdout")"
done
wait $without
look with "$work/worn.hid"

# On the way down by 20 degrees: level by the calibration, and heading where it began.
for role in head hand; do
	set -- $(last_pose $role "$work/with")
	near "$role: pitch" "${2:-}" -20 0.3
	near "$role: roll" "${3:-}" 0 0.3
	near "$role: heading" "$(drift $role "$work/with")" 0 0.5
	set -- $(last_pose $role "$work/without")
	echo "$role without: ${*:-}, drift $(drift $role "$work/without"); with: drift $(drift $role "$work/with")"
	far "$role: roll" "${3:-}" 0 90
	far "$role: heading" "$(drift $role "$work/without")" 0 0.8
done
finish
