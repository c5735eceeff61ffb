#!/bin/sh
# antipode devices and record, with recordings that are played as devices, and on a machine without
# any.
. "$ANTIPODE_SOURCE/tests/app/lib.sh"
. "$ANTIPODE_SOURCE/tests/app/devices/make_recording.sh"
cd "$work" || exit 1
make_slimevr 100 100 >one.hid
make_slimevr 120 200 >two.hid

# The list.
expect 0 '' "$antipode" devices --replay one.hid --replay two.hid --seconds 0.5
grep -Eq '^SlimeVR receiver +usb +- +slimevr +3 .* head +one.hid#0 \(replay\)' stdout ||
	fail "the list has no head: $(cat stdout)"
grep -Eq ' left +two.hid#0 \(replay\)' stdout || fail "the list has no left: $(cat stdout)"
expect 0 '' "$antipode" devices --replay one.hid --device cue=slimevr --seconds 0.8 --json
grep -q '"cue"' stdout || fail "no role cue in the JSON: $(cat stdout)"
grep -q '"bad": 0' stdout || fail "bad reports in the JSON: $(cat stdout)"
expect 0 '' "$antipode" devices --watch --replay one.hid --seconds 2
grep -Eq '^head +(ahead|exact|between|lost) ' stdout || fail "--watch shows no head: $(cat stdout)"

expect 2 'one of them' "$antipode" devices --watch --json --replay one.hid --seconds 0.2
name=$(printf 'caf\351.hid')
cp one.hid "$name"
expect 0 '' "$antipode" devices --json --replay "$name" --seconds 0.1
grep -q '"caf?.hid#0"' stdout || fail "a path in the JSON: $(cat stdout)"

# What cannot be.
expect 3 'is no hidraw node' "$antipode" devices --device head=/dev/null
expect 2 'ROLE=WHICH' "$antipode" devices --device head
expect 2 'ROLE=WHICH' "$antipode" devices --device 'a,b=c' # it becomes a column of a CSV
expect 2 'numbered from 1' "$antipode" devices --device head=a:0
expect 2 'numbered from 1' "$antipode" devices --device head=a:17
expect 2 'expected a device' "$antipode" devices --device head=:1
expect 0 '' "$antipode" devices --device head=00:11:22:33:44:00 --replay one.hid --seconds 0.1
for command in devices 'record x.hid' 'calibrate rest' 'sim' play; do
	program=
	[ "$command" != sim ] || program='-- true'
	expect 2 "'head=A' and 'head=B'" "$antipode" $command --device head=A --device head=B $program
	expect 2 "'head=A' and 'head=B'" "$antipode" $command --position head=A --position head=B $program
	expect 2 "expected hidraw, libusb or hidapi" "$antipode" $command --bus nonsense $program
	expect 2 "is there twice" "$antipode" $command --bus libusb --bus libusb $program
	expect 2 "needs no bus" "$antipode" $command --bus libusb --replay one.hid $program
done
for command in 'sim --replay no-such-file -- true' 'play --replay no-such-file'; do
	expect 3 'no-such-file: cannot open' "$antipode" $command
done
expect 2 'not both' "$antipode" play --no-devices --device head=A
expect 2 'for calibrate table, not rest' "$antipode" calibrate rest --tip 0,0,0
expect 2 'for calibrate rest, mount, table, not show' "$antipode" calibrate show --device head=A
expect 2 'a whole number' "$antipode" calibrate rest --poses 1.5
expect 2 'name a file' "$antipode" record -
expect 4 'name is empty' "$antipode" record '' --replay one.hid
mkfifo pipe && expect 4 'is no plain file' "$antipode" record pipe --force --replay one.hid
if "$antipode" devices --bus hidapi 2>stderr; then
	for bus in hidraw hidapi libusb; do expect 0 '' "$antipode" devices --bus $bus; done
	expect 2 'the same devices' "$antipode" devices --bus hidraw --bus hidapi
else
	grep -q 'built without it' stderr || fail "--bus hidapi: $(cat stderr)"
fi
expect 3 'no-such-file' "$antipode" devices --replay no-such-file
echo "E: 0.0 3 00 00" >lies.hid
expect 3 'lies.hid:1:' "$antipode" devices --replay lies.hid
expect 2 'the poses go into the CSV' "$antipode" record x.csv
expect 4 'no-folder' "$antipode" record no-folder/x.hid --replay one.hid
expect 3 'at most 65536 bytes' timeout 5 "$antipode" track /dev/zero
echo "D: 0" >empty.hid
expect 3 'no report' "$antipode" record x.hid --replay empty.hid
[ ! -e x.hid ] && [ ! -e x.csv ] || fail "a recording of nothing was written"

# What was recorded replays to the same poses, plain and packed, number for number.
for name in take.hid take.hid.gz take.hid.zst; do
	rm -f take.csv
	expect 0 '' "$antipode" record "$name" --replay two.hid
	grep -q '120 reports of 1 device, 120 poses beside it, 0 dropped' stdout ||
		fail "$name: $(cat stdout stderr)"
	"$antipode" track --space e3 "$name" | cut -d, -f2- >from_raw
	"$antipode" track --space e3 take.csv | cut -d, -f2- >from_poses
	[ "$(wc -l <from_raw)" -eq 121 ] || fail "$name: $(wc -l <from_raw) lines"
	cmp from_raw from_poses || fail "$name: its poses differ from those beside it"
	"$antipode" track --space e3 two.hid | cut -d, -f2- | cmp - from_raw ||
		fail "$name: its poses differ from the first recording's"
done
gzip -t take.hid.gz || fail "take.hid.gz is no gzip file"
grep -h '^E:' two.hid | cut -d' ' -f3- >sent
grep -h '^E:' take.hid | cut -d' ' -f3- | cmp - sent || fail "take.hid: other bytes than were sent"

# Two reports at a time, and a tracker that begins anew: the recording can be read all the same.
make_head_tracker >head.hid
expect 0 '' "$antipode" record anew.hid --replay head.hid
for name in anew.hid anew.csv; do
	[ "$("$antipode" track --space e3 "$name" | wc -l)" -eq 41 ] || fail "$name cannot be read"
done
[ "$(cut -d, -f13 anew.csv | grep -c '^1')" -eq 2 ] || fail "anew.csv: $(cut -d, -f13 anew.csv | grep -c '^1') new references"
(ulimit -f 1; exec "$antipode" record large.hid --replay head.hid) >stdout 2>stderr
status=$?
[ $status -eq 4 ] || fail "a file that may not grow: exit status $status, $(cat stderr)"
[ ! -e large.hid ] || fail "large.hid is there"

# A recording of a recording that is there already; replaced only when asked.
expect 2 'force' "$antipode" record take.hid --replay one.hid
expect 0 '' "$antipode" record take.hid --replay one.hid --force
[ "$(grep -c '^E:' take.hid)" -eq 100 ] || fail "--force did not replace"

# Two devices in one file, each with its lines.
expect 0 '' "$antipode" record both.hid --replay one.hid --replay two.hid
[ "$(grep -c '^R:' both.hid)" -eq 2 ] || fail "both.hid: $(grep -c '^R:' both.hid) descriptors"
[ "$("$antipode" track --space e3 both.hid | grep -c ',left,')" -eq 120 ] || fail "both.hid: rows of left"
awk '/^E:/ {if ($2 < t) bad++; t = $2} END {exit bad > 0}' both.hid || fail "both.hid: times decrease"

# Ctrl-C ends it whole: before, nothing has the name; afterwards all has.
make_slimevr 3000 100 >long.hid
"$antipode" record ended.hid --replay long.hid >stdout 2>stderr &
pid=$!
sleep 1.5
[ ! -e ended.hid ] || fail "ended.hid is there before its end"
kill -INT $pid
wait $pid || fail "Ctrl-C: exit status $?: $(cat stderr)"
reports=$(grep -c '^E:' ended.hid)
[ "$reports" -gt 20 ] && [ "$reports" -lt 1000 ] || fail "Ctrl-C: $reports reports"
[ "$(awk 'END {print NR - 1}' ended.csv)" -eq "$reports" ] || fail "Ctrl-C: other poses than reports"
no_parts "$work"
finish
