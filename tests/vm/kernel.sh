#!/bin/sh
# kernel.sh DIR: puts Debian's own kernel into DIR (vmlinux and the modules that the tests' virtual
# machine uses), for machine.sh. The package is downloaded with apt-get and unpacked; nothing is
# installed, no root is needed. Does nothing where DIR has one. Exit status 77: it cannot be had.
set -eu
PATH=$PATH:/usr/sbin:/sbin
dir=${1:?which folder}
[ -e "$dir/vmlinux" ] && exit 0

cannot() {
	echo "kernel.sh: $*; the tests in the virtual machine are skipped" >&2
	exit 77
}
for tool in apt-get dpkg-deb depmod xz; do
	command -v $tool >/dev/null || cannot "$tool is missing"
done
[ "$(dpkg --print-architecture)" = amd64 ] || cannot "the machine is made for amd64 only"
mkdir -p "$(dirname "$dir")"
tmp=$(mktemp -d "$dir.XXXXXX")
trap 'rm -rf "$tmp"' EXIT

# download OPTIONS…: the package that linux-image-amd64 stands for.
download() {
	package=$(apt-cache "$@" depends linux-image-amd64 2>/dev/null |
		awk '/Depends: linux-image-/ {print $2; exit}')
	[ -n "$package" ] &&
		(cd "$tmp" && apt-get -qq -o APT::Sandbox::User=root "$@" download "$package") >"$tmp/log" 2>&1
}
# The machine's lists of packages may be old or none; then with lists of our own.
if ! download; then
	mkdir -p "$tmp/apt/lists/partial" "$tmp/apt/archives/partial"
	own="-o Dir::State::lists=$tmp/apt/lists -o Dir::Cache=$tmp/apt -o APT::Sandbox::User=root"
	apt-get -qq $own update >"$tmp/log" 2>&1 && download $own ||
		cannot "the kernel's package cannot be downloaded ($(tail -n 1 "$tmp/log"))"
fi

mkdir "$tmp/new"
dpkg-deb --fsys-tarfile "$tmp"/linux-image-*.deb | tar -x -C "$tmp/new" --wildcards \
	'./boot/vmlinuz-*' './lib/modules/*/modules.*' './lib/modules/*/kernel/lib/*' \
	'./lib/modules/*/kernel/drivers/hid/*' './lib/modules/*/kernel/drivers/usb/*' \
	'./lib/modules/*/kernel/drivers/iio/*' './lib/modules/*/kernel/drivers/mfd/*'
# The kernel itself, without its wrapping: an emulated processor unpacks for seconds. The wrapping
# ends in bytes that are not xz's, so xz's status says nothing; what comes out must be an ELF file.
image=$(echo "$tmp"/new/boot/vmlinuz-*)
at=$(LC_ALL=C grep -abo -P '\xFD7zXZ\x00' "$image" | head -n 1 | cut -d: -f1)
[ -z "$at" ] || tail -c +$((at + 1)) "$image" | xz -dc --single-stream >"$tmp/new/vmlinux" 2>/dev/null || true
[ "$(head -c 4 "$tmp/new/vmlinux" 2>/dev/null | tail -c 3)" = ELF ] || cp "$image" "$tmp/new/vmlinux"
rm -r "$tmp/new/boot"
depmod -b "$tmp/new" "$(ls "$tmp/new/lib/modules")"
mv -T "$tmp/new" "$dir" 2>/dev/null || [ -e "$dir/vmlinux" ] # somebody else was quicker
