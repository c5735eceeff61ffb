# Sourced by check and demo (its own variables begin with setup_): installs the Debian packages that are missing (root, or sudo).

build_packages='gcc libc6-dev meson ninja-build pkg-config glslang-tools libvulkan-dev
	libopenxr-dev libopenxr-loader1 libglfw3-dev libpng-dev libassimp-dev libjansson-dev zlib1g-dev libzstd-dev libusb-1.0-0-dev libhidapi-dev
	mesa-vulkan-drivers gnuplot-nox libfreetype-dev libfontconfig-dev fonts-dejavu-core'
check_packages='clang libcmocka-dev libmpfr-dev vulkan-validationlayers libopenxr-utils
	openxr-layer-corevalidation xvfb xauth xdotool imagemagick x11-utils procps'

# For the tests in a virtual machine (tests/vm), which are skipped without.
machine_packages='qemu-system-x86 busybox-static kmod cpio xz-utils'

# setup_packages demo|check
setup_packages() {
	setup_wanted=$build_packages
	[ "$1" = demo ] || setup_wanted="$setup_wanted $check_packages"
	setup_install $setup_wanted || exit 4
	[ "$1" = demo ] || setup_install $machine_packages ||
		echo "== the tests in a virtual machine will be skipped" >&2
}

# setup_install PACKAGE…: those that are missing; 4 where they cannot be had.
setup_install() {
	setup_missing=
	for p in "$@"; do
		dpkg-query -W -f '${Status}' "$p" 2>/dev/null | grep -q 'ok installed' || setup_missing="$setup_missing $p"
	done
	[ -n "$setup_missing" ] || return 0
	setup_as_root=
	if [ "$(id -u)" != 0 ]; then
		if ! command -v sudo >/dev/null; then
			echo "these packages are missing; install them as root:$setup_missing" >&2
			return 4
		fi
		setup_as_root=sudo
	fi
	echo "== installing:$setup_missing"
	setup_log=$(mktemp)
	if ! { $setup_as_root apt-get update -q && $setup_as_root env DEBIAN_FRONTEND=noninteractive \
		apt-get install -y -q --no-install-recommends $setup_missing; } >"$setup_log" 2>&1; then
		tail -n 5 "$setup_log" >&2
		rm -f "$setup_log"
		echo "the packages could not be installed (apt-get's last words stand above)" >&2
		return 4
	fi
	rm -f "$setup_log"
}
