#!/bin/sh
# Worlds of cells through the program: every scene with a name gives pictures, and a budget that is
# used up costs detail and one line.
. "$ANTIPODE_SOURCE/tests/app/lib.sh"
ci=$source_dir/src/device/headsets/ci.json
if ! "$antipode" doctor 2>/dev/null | grep -q '^ok *Vulkan device'; then
	echo "skipped: no Vulkan device"
	exit 77
fi
"$antipode" walk --seconds 1 >"$work/walk.csv" || fail "antipode walk"

for name in 3,3,3 3,3,4 3,3,5 3,4,3 4,3,3 5,3,3 4,3,4 5,3,4 4,3,5 3,5,3 5,3,5; do
	scenes="${scenes:-} honeycomb:$name,horizon=30"
done
for scene in $scenes torus poincare-dodecahedral,struts seifert-weber,horizon=30 \
	mirrored-dodecahedron,horizon=30; do
	expect 0 '' "$antipode" replay --scene "$scene" --headset "$ci" --frames 0:1 --force \
		--out "$work/out" "$work/walk.csv"
	size=$(stat -c %s "$work/out/000000-left.png")
	[ "$size" -gt 3000 ] || fail "$scene: an empty picture ($size bytes)"
done

column() { # of the first row of views.csv
	awk -F, -v name="$1" 'NR == 1 {for (i = 1; i <= NF; i++) if ($i == name) at = i}
		NR == 2 {print $at}' "$work/out/views.csv"
}
run() { # two frames, the standard error in $work/stderr
	expect 0 '' "$antipode" replay --scene "honeycomb:5,3,4,$1" --headset "$ci" --frames 0:9:4 \
		--force --out "$work/out" "$work/walk.csv"
}
run horizon=6
whole=$(column cells)
[ "$(column cells_over_budget)" = 0 ] || fail "512 MiB are not enough for a horizon of 6 px"
grep -q budget "$work/stderr" && fail "a budget that is large enough is warned of"
run horizon=6,budget=1
some=$(column cells)
[ "$(column cells_over_budget)" -gt 0 ] || fail "a budget of 1 MiB was enough"
[ "$some" -gt 20 ] && [ "$some" -lt "$whole" ] || fail "$some cells of $whole with 1 MiB"
lines=$(grep -c 'budget for cells is used up' "$work/stderr")
[ "$lines" = 1 ] || fail "the budget's end is told $lines times"
echo "1 MiB: $some of $whole cells: $(cat "$work/stderr")"

# Nothing left out: the same pictures for more work, in cells, behind walls, and in both images of s3.
compare_culled() { # name, options…
	name=$1
	shift
	for how in '' --no-cull; do
		# shellcheck disable=SC2086
		expect 0 '' "$antipode" replay "$@" $how --headset "$ci" --frames 0:9:8 --force \
			--out "$work/all$how" "$work/walk.csv"
		[ -z "$how" ] && cp "$work/all/views.csv" "$work/out/views.csv"
		[ -z "$how" ] && fewer=$(column draws) none=$(column culled)
	done
	cp "$work/all--no-cull/views.csv" "$work/out/views.csv"
	more=$(column draws)
	[ "$none" -gt 0 ] && [ "$(column culled)" = 0 ] || fail "$name: culled $none and $(column culled)"
	[ "$more" -gt $((fewer + fewer / 10)) ] || fail "$name: $more parts drawn with --no-cull, $fewer without"
	for picture in 000000-left 000000-right 000008-left 000008-right; do
		cmp "$work/all/$picture.png" "$work/all--no-cull/$picture.png" || fail "$name: $picture differs"
	done
	echo "$name: $fewer parts drawn in an eye, $more with --no-cull, the same pictures"
}
compare_culled '{5,3,4} struts' --scene honeycomb:5,3,4,horizon=30
compare_culled '{5,3,4} walls' --scene honeycomb:5,3,4,walls,width=0.6,horizon=30
compare_culled 'billiards in s3' --space s3
compare_culled 'billiards in h3' --space h3 --view tourist

# One sample a pixel: another picture of the same world.
expect 2 'samples: expected 1, 4, 16 or 64' "$antipode" replay --samples 2 "$work/walk.csv"
for samples in 1 4; do
	expect 0 '' "$antipode" replay --scene honeycomb:5,3,4,walls,horizon=30 --samples $samples \
		--headset "$ci" --frames 0:1 --force --out "$work/samples$samples" "$work/walk.csv"
done
cmp "$work/samples1/views.csv" "$work/samples4/views.csv" || fail "--samples 1 draws other things"
! cmp -s "$work/samples1/000000-left.png" "$work/samples4/000000-left.png" ||
	fail "--samples 1 and 4 are the same picture"
finish
