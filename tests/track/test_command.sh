#!/bin/sh
# test_command.sh TRACK: the command line, the rows, the warnings and the exit statuses of `track`.
track=$(realpath "$1") || exit 1
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
cd "$dir" || exit 1
failed=0

# expect STATUS WHAT ARGS…: out and err hold what was written.
expect() {
	wanted=$1 what=$2
	shift 2
	"$track" "$@" > out 2> err < "${input:-/dev/null}"
	status=$?
	if [ $status -ne "$wanted" ]; then
		echo "FAIL $what: status $status, expected $wanted: $(cat err)"
		failed=1
	fi
}

# say WHAT ACTUAL EXPECTED
say() {
	if [ "$2" != "$3" ]; then
		echo "FAIL $1: '$2', expected '$3'"
		failed=1
	fi
}

in_err() {
	if ! grep -q -- "$1" err; then
		echo "FAIL standard error lacks '$1': $(cat err)"
		failed=1
	fi
}

cat > walk.csv <<'END'
t_ns,device,px,py,pz,qx,qy,qz,qw
5,left,0.1,0.8,-0.4,0,0,0,1
10,head,0,1.6,-0.8,0,0,0,1
10,left,0.1,0.75,-0.45,0,0.6,0,0.8
20,head,-0.7,1.6,-0.8,0,0.1,0,0.995
30,right,-0.5,0.8,0.1,0.5,0.5,0.5,0.5
END

expect 0 "default" walk.csv
say "header" "$(head -n 1 out)" "t_ns,device,m00,m01,m02,m03,m10,m11,m12,m13,m20,m21,m22,m23,m30,m31,m32,m33"
say "rows" "$(wc -l < out)" 5
say "fields" "$(awk -F, '{ print NF }' out | sort -u)" 18
say "keys" "$(cut -d, -f1,2 out | tail -n +2 | tr '\n' ' ')" "10,head 10,left 20,head 30,right "
in_err "1 hand sample before the head's first gave no row"
cp out default
expect 0 "spelled out" --space h3 --tracker billiards --table-edge 0.9 --table-height 0.75 \
	--table-at 0,0,0 --up y --head-frame head walk.csv
say "the defaults are what they are said to be" "$(cksum < out)" "$(cksum < default)"
input=walk.csv
expect 0 "standard input" -
say "from standard input" "$(cksum < out)" "$(cksum < default)"
input=

# In e3 the virtual pose is the room's, over rho, from the base point: all trackers alike.
for tracker in naive anchor billiards; do
	expect 0 "$tracker" --space e3 --radius 2 --tracker $tracker walk.csv
	say "$tracker: head in e3" "$(grep '^10,head' out)" "10,head,1,0,0,0,0,1,0,0.42500000000000004,0,0,1,-0.40000000000000002,0,0,0,1"
	grep -v '^5,' out > "$tracker.e3"
done
say "naive rows" "$("$track" --tracker naive walk.csv | wc -l)" 6
for tracker in naive anchor; do
	paste -d, "$tracker.e3" billiards.e3 | awk -F, -v t=$tracker 'NR > 1 {
		for (i = 3; i <= 18; i++) { d = $i - $(i + 18); if (d < 0) d = -d; if (!(d < 4e-15)) { print "FAIL " t " e3: " $i ", " $(i + 18); exit 1 } } }' || failed=1
done

# Below the table's centre, on its surface, lies the base point, wherever the table stands.
printf 't_ns,device,px,py,pz,qx,qy,qz,qw\n0,head,1.5,0.5,-2,0,0.47942553860420301,0,0.87758256189037276\n' > at.csv
expect 0 "table-at" --table-at 1.5,-2,1 --table-height 0.5 --space h3 --tracker naive at.csv
say "table-at" "$(awk -F, 'NR == 2 { for (i = 3; i <= 18; i++) { d = $i - (i == 3 || i == 8 || i == 13 || i == 18); if (d * d > 1e-30) print $i } }' out)" ""

expect 2 "no log"
expect 2 "unknown option" --spaec h3 walk.csv
expect 2 "space" --space h4 walk.csv
expect 2 "tracker" --tracker nearest walk.csv
expect 2 "radius 0" --radius 0 walk.csv
expect 2 "edge and radius" --radius 1 --table-edge 0.9 walk.csv
in_err "does not fit"
say "nothing written" "$(wc -c < out)" 0
expect 0 "edge and radius, anchor" --radius 1 --table-edge 0.9 --tracker anchor walk.csv
expect 0 "edge and radius, e3" --radius 1 --table-edge 0.9 --space e3 walk.csv
expect 2 "table-at" --table-at 1,2 walk.csv
in_err "X,Z,YAW"
expect 3 "no file" nowhere.csv
in_err nowhere.csv

{ cat walk.csv; echo "40,head,0,nan,0,0,0,0,1"; echo "50,head,0,1.6,0.9,0,0,0,1"; } > bad.csv
expect 3 "bad line" bad.csv
in_err "bad.csv:7:"
say "rows before it" "$(wc -l < out)" 5
expect 0 "skip-bad" --skip-bad bad.csv
in_err "1 bad line was skipped"
say "rows with skip-bad" "$(wc -l < out)" 6
printf 't_ns,device,px,py,pz,qx,qy,qz,qw\n1,left,0,1,0,0,0,0,1\n' > hand.csv
expect 0 "no head" hand.csv
in_err "no device 'head'"
expect 3 "too far" --radius 0.001 --tracker naive walk.csv
in_err "too far"
if [ -w /dev/full ]; then
	"$track" walk.csv > /dev/full 2> err
	say "full disk" $? 4
fi
expect 0 "help" --help
for option in space radius tracker table-edge table-height table-at up head-frame skip-bad; do
	grep -q -e "--$option" out || { echo "FAIL --help lacks --$option"; failed=1; }
done
[ $failed -eq 0 ] && echo "all well"
exit $failed
