#!/bin/sh
# meson install into an empty folder: the program, the library with headers and pkg-config, the
# runtime with its manifest; used from there as a stranger would.
. "$ANTIPODE_SOURCE/tests/app/lib.sh"
DESTDIR="$work/root" meson install -C "$ANTIPODE_BUILD" --no-rebuild >"$work/log" 2>&1 ||
	fail "meson install: $(tail -n 3 "$work/log")"
prefix=$(find "$work/root" -type d -path '*/bin' | head -n 1)
prefix=${prefix%/bin}
for f in bin/antipode lib/udev/rules.d/70-antipode.rules share/openxr/1/openxr_antipode.json share/man/man1/antipode.1 \
	include/antipode/geom/map.h share/antipode/headsets/ci.json \
	share/bash-completion/completions/antipode; do
	[ -e "$prefix/$f" ] || fail "$f is not installed"
done
pc=$(find "$prefix" -name libantipode.pc)
export PKG_CONFIG_PATH="${pc%/*}" PKG_CONFIG_SYSROOT_DIR="$work/root"
library=$(dirname "$(find "$prefix" -name libantipode.so)")
for example in "$source_dir"/docs/examples/*.c; do
	name=$(basename "$example" .c)
	${CC:-cc} -std=c17 -Wall -Wextra -Werror ${ANTIPODE_SANITIZE:+-fsanitize=$ANTIPODE_SANITIZE} \
		"$example" -o "$work/$name" $(pkg-config --cflags --libs libantipode) -lm 2>"$work/log" ||
		fail "docs/examples/$name.c: $(head -n 3 "$work/log")"
	LD_LIBRARY_PATH=$library "$work/$name" >"$work/$name.out" 2>&1 || fail "$name: $(tail -n 2 "$work/$name.out")"
	[ -s "$work/$name.out" ] || fail "$name says nothing"
done
echo 'h3 1 exp 0 0 -1' | "$prefix/bin/antipode" eval >"$work/out" || fail "the installed eval"
unset XR_RUNTIME_JSON
if "$prefix/bin/antipode" doctor >"$work/doctor" 2>&1; then
	grep -q "ok *simulated headset.*$prefix" "$work/doctor" || fail "doctor: $(cat "$work/doctor")"
	"$prefix/bin/antipode" walk --seconds 1 >"$work/walk.csv"
	"$prefix/bin/antipode" replay --headset "$prefix/share/antipode/headsets/ci.json" --frames 0:1 \
		--out "$work/cap" "$work/walk.csv" >"$work/log" 2>&1 || fail "the installed replay: $(tail -n 2 "$work/log")"
fi
finish
