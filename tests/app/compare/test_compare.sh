#!/bin/sh
# antipode compare: what is the same, what differs and how it is told, what is missing, limits.
. "$ANTIPODE_SOURCE/tests/app/lib.sh"
make=${ANTIPODE_MAKE_PICTURE:?}

says() {
	grep -Eq -- "$1" "$work/stdout" || fail "standard output has no /$1/: $(cat "$work/stdout")"
}
capture() { # DIR: three frames
	mkdir -p "$1"
	for k in 0 1 2; do
		"$make" "$1/00000$k-left.png" 40 30 "$k"
		"$make" "$1/00000$k-right.png" 40 30 "1$k"
	done
}
capture "$work/a"
capture "$work/b"

expect 0 '' "$antipode" compare "$work/a" "$work/b"
says '^6 pairs: 6 the same, 0 within'
expect 0 '' "$antipode" compare --metric all "$work/a/000000-left.png" "$work/b/000000-left.png"
says '000000-left.png: same$'

# One box differs: 5 by 4 pixels at 7, 9, by 16.
"$make" "$work/b/000001-right.png" 40 30 11 7 9 5 4 16
expect 1 '' "$antipode" compare --metric all --out "$work/o" "$work/a" "$work/b"
says '^000001-right.png: differs: PSNR 46.60[0-9] dB, SSIM 0\.[0-9]*, FLIP 0\.[0-9]*, 20 pixels by up to 16, most of them together 20 in 5x4 at 7,9$'
says '^6 pairs: 5 the same, 0 within the limits, 1 differ, 0 unreadable; 0 missing'
[ -s "$work/o/000001-right-diff.png" ] || fail "no picture of the difference"
[ ! -e "$work/o/000000-left-diff.png" ] || fail "a picture of no difference"
[ "$(wc -l <"$work/o/compare.csv")" = 7 ] || fail "compare.csv: $(cat "$work/o/compare.csv")"
grep -q '^000001-right.png,differs,46.60.*,20,16,7,9,5,4,20$' "$work/o/compare.csv" ||
	fail "compare.csv: $(cat "$work/o/compare.csv")"
grep -q '^000000-left.png,same,inf,1,0,0,0,' "$work/o/compare.csv" ||
	fail "compare.csv: $(cat "$work/o/compare.csv")"
expect 1 '' "$antipode" compare --quiet "$work/a" "$work/b"
[ "$(wc -l <"$work/stdout")" = 2 ] || fail "--quiet: $(cat "$work/stdout")"

# Limits; with several all must hold.
expect 0 '' "$antipode" compare --min-psnr 46 "$work/a" "$work/b"
says '1 within the limits'
expect 1 '' "$antipode" compare --min-psnr 47 "$work/a" "$work/b"
expect 0 '' "$antipode" compare --max-pixels 20 --max-step 16 "$work/a" "$work/b"
expect 1 '' "$antipode" compare --max-pixels 20 --max-step 15 "$work/a" "$work/b"
expect 1 '' "$antipode" compare --max-pixels 19 "$work/a" "$work/b"
expect 0 '' "$antipode" compare --min-ssim 0.5 --max-flip 0.5 "$work/a" "$work/b"
expect 1 '' "$antipode" compare --min-ssim 0.99999 "$work/a" "$work/b"
expect 1 '' "$antipode" compare --max-flip 0.00001 "$work/a" "$work/b"

# PNG against PAM; pictures made from others are passed over; a frame that one side lacks; sizes.
rm "$work/b/000001-right.png"
"$make" "$work/b/000001-right.pam" 40 30 11
"$make" "$work/b/000001-sbs.png" 80 30 3
"$make" "$work/b/contact.png" 80 30 3
expect 0 '' "$antipode" compare "$work/a" "$work/b"
rm "$work/b/000001-right.pam"
expect 1 '' "$antipode" compare --min-psnr 1 "$work/a" "$work/b"
says '^000001-right.png: differs: missing in .*/b$'
says '1 missing on one side'
expect 1 '' "$antipode" compare --min-psnr 1 "$work/b" "$work/a"
says '^000001-right.png: differs: missing in .*/b$'
"$make" "$work/b/000001-right.png" 41 30 11
expect 1 '' "$antipode" compare --min-psnr 1 "$work/a" "$work/b"
says '^000001-right.png: differs: 40x30 and 41x30 pixels$'

# What cannot be read; the other pairs are compared all the same.
echo 'not a picture' >"$work/b/000001-right.png"
expect 3 'b/000001-right.png: not a whole PNG' "$antipode" compare "$work/a" "$work/b"
says '^6 pairs: 5 the same, 0 within the limits, 0 differ, 1 unreadable'
head -c 300 "$work/a/000001-right.png" >"$work/b/000001-right.png"
expect 3 'b/000001-right.png' "$antipode" compare --out "$work/o2" "$work/a" "$work/b"
grep -q '^000001-right.png,unreadable,' "$work/o2/compare.csv" || fail "compare.csv: unreadable"
mkdir "$work/empty"
expect 3 'no picture' "$antipode" compare "$work/empty" "$work/empty"
expect 1 '' "$antipode" compare "$work/a" "$work/empty"
expect 3 'no/such' "$antipode" compare "$work/a" "$work/no/such"
expect 3 'is a folder' "$antipode" compare "$work/a" "$work/a/000000-left.png"
expect 3 'cannot be read|not a whole' "$antipode" compare "$work/a/000000-left.png" /dev/null
expect 2 'operand too many' "$antipode" compare a b c
expect 2 'metric' "$antipode" compare --metric mse a b
expect 2 'pixels-per-degree' "$antipode" compare --pixels-per-degree 0 "$work/a" "$work/a"
expect 4 '/dev/null' "$antipode" compare --out /dev/null/o "$work/a" "$work/b"

# Hostile names, folders of other pictures.
mkdir "$work/x" "$work/y"
odd=$(printf '000001-le,"\033ft.png')
"$make" "$work/x/$odd" 4 4 1
"$make" "$work/y/$odd" 4 4 2
mkdir "$work/x/000002-left.png" "$work/y/000002-left.png"
expect 3 '000002-left.png' "$antipode" compare --out "$work/o3" "$work/x" "$work/y"
says '000001-le,"\?ft.png: differs'
grep -q '^"000001-le,""?ft.png",differs' "$work/o3/compare.csv" || fail "$(cat "$work/o3/compare.csv")"
mkdir "$work/p" "$work/q"
"$make" "$work/p/logo.png" 4 4 1
"$make" "$work/q/logo.png" 4 4 1
expect 0 '' "$antipode" compare "$work/p" "$work/q"
no_parts "$work"
finish

# Depths of 16 bits, PNG's or PAM's: all of them are compared, under the names that a capture gives.
depth() { # FILE: two of them, the second by its two bytes in octal
	printf 'P7\nWIDTH 2\nHEIGHT 1\nDEPTH 1\nMAXVAL 65535\nTUPLTYPE GRAYSCALE\nENDHDR\n\001\002'"$2" >"$1"
}
mkdir "$work/d" "$work/e"
depth "$work/d/000000-layer0-depth-left.pam" '\200\001'
depth "$work/e/000000-layer0-depth-left.pam" '\200\001'
"$make" "$work/d/000000-layer0-front.png" 8 8 1
"$make" "$work/e/000000-layer0-front.png" 8 8 1
expect 0 '' "$antipode" compare "$work/d" "$work/e"
says '^2 pairs: 2 the same'
depth "$work/e/000000-layer0-depth-left.pam" '\200\002'
expect 1 '' "$antipode" compare "$work/d" "$work/e"
says '^000000-layer0-depth-left.pam: differs: PSNR 99.3[0-9]* dB, 1 pixels by up to 1, .* in 1x1 at 1,0$'
expect 0 '' "$antipode" compare --min-psnr 99 "$work/d" "$work/e"
rm "$work/e/000000-layer0-front.png"
expect 1 '' "$antipode" compare --min-psnr 99 "$work/d" "$work/e"
