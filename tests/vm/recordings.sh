#!/bin/sh
# recordings.sh OPTIONS… SCRIPT: machine.sh with the raw HID recordings that ANTIPODE_SHARED has.
set -eu
recordings=${ANTIPODE_SHARED:-}/data/hid
if [ -z "${ANTIPODE_SHARED:-}" ] || [ ! -d "$recordings" ]; then
	echo "skipped: ANTIPODE_SHARED does not name a folder with data/hid"
	exit 77
fi
for file in "$recordings"/*.hid; do
	set -- -f "$file" "$@"
done
exec "$(dirname "$0")/machine.sh" "$@"
