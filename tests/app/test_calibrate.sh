#!/bin/sh
# antipode calibrate: from logs and recordings to what is kept, and what is kept at work.
. "$(dirname "$0")/lib.sh"
export XDG_CONFIG_HOME="$work/config" HOME="$work/home"
mkdir -p "$work/home"

# A table of 0.8 m at (0.5, -1.2), turned by 0.3, 0.7 m high; its corners are touched with a tip 0.1 m
# before the controller, which is held level and looks along -z; a jitter of 0.5 mm. $1 corners in
# this order; $2: noise in metres.
touches() {
	awk -v corners="$1" -v noise="$2" 'BEGIN {
		srand(1)
		print "t_ns,device,px,py,pz,qx,qy,qz,qw,trigger"
		n = split(corners, c, " ")
		for (i = 0; i < 400; i++) {
			k = int(i / 100); in_press = i % 100 >= 60 && i % 100 < 90
			if (k >= n) break
			u = c[k + 1] % 2 ? -0.4 : 0.4; v = c[k + 1] >= 2 ? -0.4 : 0.4
			x = 0.5 + u * cos(0.3) + v * sin(0.3); z = -1.2 - u * sin(0.3) + v * cos(0.3)
			if (!in_press) x += 0.3
			printf "%.0f,head,0,1.6,0,0,0,0,1,1\n", i * 10000000
			printf "%.0f,right,%.9f,%.9f,%.9f,0,0,0,1,%d\n", i * 10000000, x + noise * (rand() - 0.5),
				0.7 + noise * (rand() - 0.5), z + 0.1 + noise * (rand() - 0.5), in_press
		}
	}'
}
# value KEY FILE: of a JSON number.
value() { sed -n "s/.*\"$1\": \([-0-9.e]*\).*/\1/p" "$2"; }
near() {
	awk -v a="$2" -v b="$3" -v t="$4" 'BEGIN { d = a - b; exit !(a != "" && d <= t && -d <= t) }' ||
		fail "$1: '$2', not $3 within $4"
}

touches '0 1 3' 0 >"$work/three.csv"
expect 0 '' "$antipode" calibrate table --tip 0,0,-0.1 "$work/three.csv"
room="$XDG_CONFIG_HOME/antipode/room.json"
near x "$(value x_m "$room")" 0.5 1e-8
near z "$(value z_m "$room")" -1.2 1e-8
near yaw "$(value yaw_rad "$room")" 0.3 1e-8
near height "$(value height_m "$room")" 0.7 1e-8
near edge "$(value edge_m "$room")" 0.8 1e-8
expect 0 '' "$antipode" calibrate show
grep -q 'table at 0.5000, -1.2000 m.*0.7000 m high' "$work/stdout" || fail "show: $(cat "$work/stdout")"
touches '2 0 3 1' 0.001 >"$work/four.csv"
expect 0 '' "$antipode" calibrate table --corners 4 --tip 0,0,-0.1 --out "$work/four.json" "$work/four.csv"
near 'x of four' "$(value x_m "$work/four.json")" 0.5 0.001
near 'yaw of four' "$(value yaw_rad "$work/four.json")" 0.3 0.002

# --room FILE is --table-at, --table-height and --table-edge.
"$antipode" walk >"$work/whole.csv" && head -n 200 "$work/whole.csv" >"$work/walk.csv"
at=$(sed -n 's/.*"x_m": \([^,]*\),.*/\1/p' "$room"),$(value z_m "$room"),$(value yaw_rad "$room")
"$antipode" track --table-at "$at" --table-height "$(value height_m "$room")" \
	--table-edge "$(value edge_m "$room")" "$work/walk.csv" >"$work/by-hand.csv" || fail 'track by hand'
"$antipode" track --room "$room" "$work/walk.csv" >"$work/by-room.csv" || fail 'track --room'
cmp -s "$work/by-hand.csv" "$work/by-room.csv" || fail 'track --room is another than the options it stands for'
"$antipode" track --room "$room" --table-height 0.9 "$work/walk.csv" >"$work/higher.csv" || fail 'track --room'
cmp -s "$work/higher.csv" "$work/by-room.csv" && fail 'an option does not go before the room'

# What is of no use is refused, and what is kept stays.
cp "$room" "$work/kept.json"
touches '0 1' 0 >"$work/two.csv"
expect 3 '2 of 3 corners' "$antipode" calibrate table "$work/two.csv"
touches '0 1 1' 0 >"$work/same.csv"
expect 3 'apart|square' "$antipode" calibrate table "$work/same.csv"
touches '0 1 3' 0.2 >"$work/shaky.csv"
expect 3 'hold still' "$antipode" calibrate table "$work/shaky.csv"
expect 2 'expected X,Y,Z' "$antipode" calibrate table --tip 0,0 "$work/three.csv"
expect 2 'expected rest, mount' "$antipode" calibrate nonsense
expect 2 'forget what' "$antipode" calibrate forget
cmp -s "$room" "$work/kept.json" || fail 'a refused calibration has changed what was kept'
echo '{"version": 9}' >"$work/new.json"
expect 3 'version' "$antipode" track --room "$work/new.json" "$work/walk.csv"

# A gyroscope at rest, played as if it was plugged in: an XREAL's reports at 250 Hz, which lies still
# for 4 s with a bias of 1, -2 and 0.5 degrees a second, then one that is being turned.
xreal() {
	printf 'R: 27 06 00 ff 09 01 a1 01 15 00 26 ff 00 75 08 95 40 09 01 81 02 95 40 09 02 91 02 c0\n'
	printf 'N: Air\nI: 3 3318 0424\n'
	awk -v turn="$1" 'function le(v, n,  s, i) {
			if (v < 0) v += 2 ^ (8 * n)
			for (i = 0; i < n; i++) { s = s sprintf(" %02x", v % 256); v = int(v / 256) }
			return s
		}
		BEGIN {
		# Gyroscope 1/1000 of a degree a second, acceleration 1/10000 g; device axes (-x, z, y).
		for (i = 0; i < 1100; i++) {
			r = " 01 02" le(0, 2) le(i * 4000000 + 1000000000, 8) le(1, 2) le(1000, 4)
			r = r le(-1000 + turn * (i % 2 * 2 - 1), 3) le(500, 3) le(-2000, 3)
			r = r le(1, 2) le(10000, 4) le(0, 3) le(0, 3) le(10000, 3)
			while (length(r) < 3 * 64) r = r " 00"
			printf "E: %06d.%06d 64%s\n", int(i / 250), i % 250 * 4000, r
		}
	}'
}
xreal 0 >"$work/still.hid"
xreal 900 >"$work/turned.hid"
expect 0 '' "$antipode" calibrate rest --replay "$work/still.hid"
grep -q 'gyroscope 1.0000 -2.0000 0.5000 deg/s' "$work/stdout" || fail "rest: $(cat "$work/stdout")"
expect 3 'still for two seconds' "$antipode" calibrate rest --replay "$work/turned.hid"
expect 0 '' "$antipode" calibrate show
grep -q 'gyroscope bias *1.0000 *-2.0000 *0.5000' "$work/stdout" || fail "show: $(cat "$work/stdout")"
expect 3 'first second|nod' "$antipode" calibrate mount --replay "$work/still.hid"

# A head tracker by Android's protocol (its y is to the back) that is worn upside down, half a turn
# about the view: level for 1.2 s, then a nod by 30 degrees, down first.
awk 'BEGIN {
	print "R: 34 05 20 09 e1 a1 01 0a 44 05 16 01 80 26 ff 7f 37 60 4f 46 ed 47 a1 b0 b9 12 55 08 75 10 95 03 81 02 c0"
	print "N: Ear\nI: 5 054c 0e41"
	for (i = 0; i < 320; i++) {
		a = i < 120 || i > 300 ? 0 : 0.52 * sin((i - 120) / 180 * 6.2831853)
		v = int(32767 * cos(a / 2)); u = int(32767 * sin(a / 2)) # of pi
		printf "E: %06d.%06d 6", int(i / 100), i % 100 * 10000
		split("0 " (-v) " " u, w, " ")
		for (k = 1; k <= 3; k++) { x = w[k] < 0 ? w[k] + 65536 : w[k]; printf " %02x %02x", x % 256, int(x / 256) }
		print ""
	}
}' >"$work/nod.hid"
expect 0 '' "$antipode" calibrate mount --replay "$work/nod.hid"
grep -Eq 'axes -?0\.0[0-9]* -?0\.0[0-9]* -?(1\.0|0\.99)[0-9]* -?0\.0[0-9]*, from a nod of (29|30)' "$work/stdout" ||
	fail "mount: $(cat "$work/stdout")"

# What is kept is read by whoever uses devices.
cp "$XDG_CONFIG_HOME/antipode/devices/054c%3A0e41.json" "$work/ear.json" || fail 'the file of the ear'
sed 's/"version": 1/"version": 2/' "$work/ear.json" >"$XDG_CONFIG_HOME/antipode/devices/054c%3A0e41.json"
expect 3 '054c%3A0e41.json: /version: this program reads version 1' "$antipode" devices --replay "$work/nod.hid"
cp "$work/ear.json" "$XDG_CONFIG_HOME/antipode/devices/054c%3A0e41.json"
expect 0 '' "$antipode" devices --replay "$work/nod.hid"

expect 2 "nothing is known of 'nobody'" "$antipode" calibrate forget nobody
expect 0 '' "$antipode" calibrate forget table
[ ! -e "$room" ] || fail 'the table is not forgotten'
expect 0 '' "$antipode" calibrate forget all
expect 0 '' "$antipode" calibrate show
grep -q '^nothing is calibrated' "$work/stdout" || fail "show: $(cat "$work/stdout")"
no_parts "$work"
finish
