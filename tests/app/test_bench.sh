#!/bin/sh
# antipode bench: tables that are complete and say what they must, plots, errors in one line. Nothing
# here depends on how fast the machine is.
. "$ANTIPODE_SOURCE/tests/app/lib.sh"
out=$work/b

expect 2 "'speed': expected logmap, walkers" "$antipode" bench --what logmap,speed --out "$out"
expect 2 "'': expected logmap" "$antipode" bench --what , --out "$out"
[ ! -e "$out" ] || fail 'a usage error made a folder'
: >"$work/file"
expect 4 'file' "$antipode" bench --quick --what walkers --out "$work/file"

# all TABLE CONDITION ROWS [WHICH]: the rows that WHICH chooses are so many, and CONDITION holds in
# each; both of awk, without quotes and the commas between them.
all() {
	awk -F'"' -v OFS= '{ for (i = 2; i <= NF; i += 2) gsub(",", "", $i); $1 = $1 } 1' "$out/$1.csv" |
		awk -F, -v rows="$3" "NR > 1 && (${4:-1}) { n++; if (!($2)) { print; bad = 1 } }
			END { if (n != rows) print n + 0 \" rows, not \" rows; exit n != rows || bad }" >"$work/bad" ||
		fail "$1.csv, not $2: $(head -n 3 "$work/bad")"
}

expect 0 '' "$antipode" bench --quick --what logmap,walkers --out "$out"
plotted='logmap walkers'
# The renderer's polynomial, as C and by SIMD, holds the bound; the paper's formula is known not to.
for space in s3 h3; do
	all logmap '$9 > 0 && $9 < 4e-7' 1 "\$1 == \"$space\" && \$2 == \"float\" && \$3 == \"scalar\" && \$4 ~ /^polynomial/"
	all logmap '$9 > 1e-6' 1 "\$1 == \"$space\" && \$2 == \"float\" && \$4 ~ /the paper/"
	all logmap '$9 < 1e-15' 1 "\$1 == \"$space\" && \$4 ~ /carried/"
done
awk -F, '/SIMD/ && !($NF > 0 && $NF < 4e-7)' "$out/logmap.csv" | grep . && fail 'SIMD computes something else'
# In 20,000 steps double drifts measurably, and what is carried does not: against 256 bits.
all walkers '$7 > 1e-16 && $7 < 1e-11' 5 '$1 == "h3" && $2 !~ /double-double/'
all walkers '$7 > 0 && $7 < 1e-15' 3 '$2 ~ /double-double/'
all walkers '$8 < 5e-15' 2 '$1 != "e3" && $2 ~ /every step/'
all walkers '$8 > 1e-14' 2 '$1 != "e3" && $2 ~ /never/'

if "$antipode" doctor 2>/dev/null | grep -q '^ok *Vulkan device'; then
	expect 0 '' "$antipode" bench --quick --what frames --out "$out"
	plotted="$plotted frames"
	# What was asked for is kept, and seen to be: no error at all would be none measured.
	all frames '$6 > 0.001 && $6 <= $2 && $7 > 1000' 8
	coarse=$(awk -F, '/billiards/ && $2 == 4 { print $9 }' "$out/frames.csv")
	fine=$(awk -F, '/billiards/ && $2 == 0.05 { print $9 }' "$out/frames.csv")
	[ "$fine" -gt $((2 * coarse)) ] || fail "$fine triangles for 0.05 px, $coarse for 4 px"
	expect 0 '' "$antipode" bench --quick --what curvature --out "$out"
	plotted="$plotted curvature"
	# The same triangles and nearly the same picture by each pipeline: it is curvature that is compared.
	all curvature '$NF == 153600 && $(NF - 1) < 0.01' 12 '/two eyes/'
	all curvature '$(NF - 1) == 0' 6 '/^plain|^the same/'
else
	echo "skipped: what is drawn, for there is no Vulkan device"
	expect 4 'curvature: ' "$antipode" bench --quick --what curvature --out "$out"
fi
no_parts "$out"

for name in $plotted; do
	if command -v gnuplot >/dev/null; then
		[ "$(head -c 4 "$out/$name.png" | tail -c 3)" = PNG ] || fail "$name.png is no picture"
		gnuplot --default-settings <"$out/$name.gnuplot" >"$work/again.png" 2>"$work/stderr"
		[ -s "$work/again.png" ] || fail "$name.gnuplot does not draw: $(cat "$work/stderr")"
		grep -q . "$work/stderr" && fail "$name.gnuplot: $(head -n 3 "$work/stderr")"
	else
		[ ! -e "$out/$name.png" ] || fail "$name.png without gnuplot"
	fi
done
finish
