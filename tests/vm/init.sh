#!/bin/busybox sh
# The first process of the virtual machine (machine.sh).
/bin/busybox --install -s /bin
export PATH=/bin HOME=/tmp
mount -t proc proc /proc
mount -t sysfs sysfs /sys
mount -t devtmpfs devtmpfs /dev 2>/dev/null
mkdir -p /dev/pts /dev/shm
mount -t devpts devpts /dev/pts
mount -t tmpfs tmpfs /dev/shm
stty -F /dev/ttyS1 raw -echo
ip link set lo up
printf 'root:x:0:0:root:/:/bin/sh\nuser:x:1000:1000:user:/tmp:/bin/sh\n' >/etc/passwd
printf 'root:x:0:\nuser:x:1000:\n' >/etc/group
while read -r m; do insmod "/lib/modules/$m" || echo "insmod $m failed"; done </modules >/dev/ttyS1 2>&1
. /environment
cd /data
# Seconds of the machine's own clock. The first status that is not 0 is the machine's.
status=0
for script in /scripts/*; do
	echo "== ${script##*-}"
	# A test's processes end with it.
	setsid timeout "${VM_LIMIT:-300}" sh "$script" </dev/null
	last=$?
	[ $status -ne 0 ] || status=$last
done >/dev/ttyS1 2>&1
echo "status $status" >/dev/ttyS2
poweroff -f
