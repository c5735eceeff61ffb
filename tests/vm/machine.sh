#!/bin/sh
# machine.sh [-f SRC[:DST]]… [-m MODULE]… [-e NAME=VALUE]… GUEST-SCRIPT…
# Runs shell scripts in a small virtual machine with Debian's own kernel (kernel.sh), so that our
# programs meet the real HID and USB stack. Its memory holds busybox, the scripts and guest.sh, the
# files of -f (programs to /bin, the rest to /data, with the shared libraries they need) and the
# kernel's modules uhid, usbhid, hid-generic, vhci-hcd and those of -m.
#
# No hardware virtualisation: the processor is emulated and its clock counts instructions, so
# what is measured inside does not depend on what else the host does, and waiting costs nothing.
# The exit status is the first script's that is not 0; 77, saying so, where there is no QEMU or no
# kernel. ANTIPODE_VM_ONLY=NAME runs guest_NAME.sh alone.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
PATH=$PATH:/usr/sbin:/sbin
kernel=${ANTIPODE_VM_KERNEL:-${ANTIPODE_BUILD:?}/tests/vm/kernel}
limit=${ANTIPODE_VM_LIMIT:-$((1200 + 2 * (${ANTIPODE_VM_SECONDS:-0} + ${ANTIPODE_VM_UNPLUG_SECONDS:-0})))}

skip() {
	echo "skipped: $*"
	exit 77
}
for tool in qemu-system-x86_64 busybox modprobe cpio ldd; do
	command -v $tool >/dev/null || skip "$tool is missing (.ci/setup.sh lists the packages)"
done
[ -e "$kernel/vmlinux" ] || skip "there is no kernel: tests/vm/kernel.sh $kernel gets it"
busybox --list | grep -qx insmod || skip "busybox has no insmod (busybox-static has)"

tmp=$(mktemp -d "${TMPDIR:-/tmp}/antipode-vm.XXXXXX")
qemu=
trap 'rm -rf "$tmp"; [ -z "$qemu" ] || kill "$qemu" 2>/dev/null || true' EXIT
root=$tmp/root
mkdir -p "$root/bin" "$root/dev" "$root/proc" "$root/sys" "$root/tmp" "$root/run" "$root/data" \
	"$root/etc" "$root/lib/modules"
ln -s . "$root/usr"
cp "$(command -v busybox)" "$root/bin/busybox"

# add SRC DST: with the shared libraries of what is a program.
add() {
	mkdir -p "$root$(dirname "$2")"
	cp -rL "$1" "$root$2"
	ldd "$1" 2>/dev/null | grep -o '/[^ ]*' | while read -r library; do
		[ -e "$root$library" ] || { mkdir -p "$root$(dirname "$library")" && cp -L "$library" "$root$library"; }
	done || true
}
modules='uhid hid-generic usbhid vhci-hcd'
cat >"$root/environment" <<-END # of long measurements
	export VM_SECONDS=${ANTIPODE_VM_SECONDS:-} VM_UNPLUG_SECONDS=${ANTIPODE_VM_UNPLUG_SECONDS:-}
	export VM_FILES=${ANTIPODE_VM_FILES:-} VM_LIMIT=$((900 + 2 * ${ANTIPODE_VM_SECONDS:-0} + ${ANTIPODE_VM_UNPLUG_SECONDS:-0}))
END
while getopts f:m:e: option; do
	case $option in
	f)
		src=${OPTARG%%:*} dst=
		[ "$src" = "$OPTARG" ] || dst=${OPTARG#*:}
		[ -e "$src" ] || { echo "machine.sh: $src is not there" >&2; exit 1; }
		if [ -z "$dst" ]; then
			dst=/data/$(basename "$src")
			[ ! -x "$src" ] || dst=/bin/$(basename "$src")
		fi
		add "$src" "$dst"
		;;
	m) modules="$modules $OPTARG" ;;
	e) echo "export $OPTARG" >>"$root/environment" ;;
	*) exit 2 ;;
	esac
done
shift $((OPTIND - 1))
mkdir "$root/scripts"
number=10
for script; do
	name=$(basename "$script" .sh)
	name=${name#guest_}
	[ -z "${ANTIPODE_VM_ONLY:-}" ] || [ "$ANTIPODE_VM_ONLY" = "$name" ] || continue
	cp "$script" "$root/scripts/$number-$name"
	number=$((number + 1))
done
[ $number -gt 10 ] || { echo "machine.sh: no script named '$ANTIPODE_VM_ONLY'" >&2; exit 1; }
cp "$here/guest.sh" "$root/data/guest.sh"
cp "$here/init.sh" "$root/init"
chmod +x "$root/init"

release=$(ls "$kernel/lib/modules")
: >"$root/modules"
for m in $modules; do
	modprobe -d "$kernel" -S "$release" --show-depends "$m" >"$tmp/needs" || {
		echo "machine.sh: the kernel has no module $m" >&2
		exit 1
	}
	sed -n 's/^insmod \([^ ]*\).*/\1/p' "$tmp/needs" | while read -r file; do
		name=$(basename "$file")
		[ -e "$root/lib/modules/$name" ] || { cp "$file" "$root/lib/modules/" && echo "$name" >>"$root/modules"; }
	done
done
(cd "$root" && find . | cpio -o -H newc --quiet -R 0:0) >"$tmp/initrd"
rm -rf "$root"

# In the background and waited for, so that a signal (a time limit) ends the machine, too.
timeout "$limit" qemu-system-x86_64 -accel tcg -icount shift=2,sleep=off -M pc -cpu max -smp 1 \
	-m 512 -nodefaults -no-user-config -display none -no-reboot -kernel "$kernel/vmlinux" \
	-initrd "$tmp/initrd" \
	-append 'console=ttyS0 quiet panic=-1 mitigations=off nokaslr random.trust_cpu=on' \
	-serial "file:$tmp/console" -serial stdio -serial "file:$tmp/status" </dev/null &
qemu=$!
trap 'exit 143' TERM INT
status=0
wait "$qemu" || status=$?
qemu=
[ "$status" != 124 ] || { echo "machine.sh: more than $limit s" >&2; exit 1; }
said=$(sed -n 's/^status \([0-9]*\).*/\1/p' "$tmp/status" 2>/dev/null)
if [ -z "$said" ]; then
	tail -n 30 "$tmp/console" >&2 || true
	echo "machine.sh: the machine stopped without a status (QEMU: $status)" >&2
	exit 1
fi
exit "$said"
