# Sourced by check and demo: installs the Debian packages that are missing (root, or sudo).

build_packages='gcc libc6-dev meson ninja-build pkg-config glslang-tools libvulkan-dev
	libopenxr-dev libopenxr-loader1 libglfw3-dev libpng-dev libassimp-dev libjansson-dev
	mesa-vulkan-drivers gnuplot-nox'
check_packages='clang libcmocka-dev libmpfr-dev vulkan-validationlayers libopenxr-utils
	openxr-layer-corevalidation xvfb xauth xdotool imagemagick x11-utils procps'

# setup_packages demo|check
setup_packages() {
	wanted=$build_packages
	[ "$1" = demo ] || wanted="$wanted $check_packages"
	missing=
	for p in $wanted; do
		dpkg-query -W -f '${Status}' "$p" 2>/dev/null | grep -q 'ok installed' || missing="$missing $p"
	done
	[ -n "$missing" ] || return 0
	as_root=
	if [ "$(id -u)" != 0 ]; then
		if ! command -v sudo >/dev/null; then
			echo "these packages are missing; install them as root:$missing" >&2
			exit 4
		fi
		as_root=sudo
	fi
	echo "== installing:$missing"
	log=$(mktemp)
	if ! { $as_root apt-get update -q && $as_root env DEBIAN_FRONTEND=noninteractive \
		apt-get install -y -q --no-install-recommends $missing; } >"$log" 2>&1; then
		tail -n 5 "$log" >&2
		echo "the packages could not be installed (apt-get's last words stand above)" >&2
		exit 4
	fi
	rm -f "$log"
}
