#!/bin/sh
# The client's tests under the Khronos core validation layer: no call of ours may break the
# specification.
if ! ls /usr/share/openxr/1/api_layers/explicit.d/*core_validation* >/dev/null 2>&1; then
	echo "skipped: Debian's openxr-layer-corevalidation is not installed"
	exit 77
fi
log=$(mktemp)
trap 'rm -f "$log"' EXIT
XR_ENABLE_API_LAYERS=XR_APILAYER_LUNARG_core_validation XR_CORE_VALIDATION_EXPORT_TYPE=text \
	XR_CORE_VALIDATION_FILE_NAME=$log "$1" || exit 1
if grep -E 'VALID_ERROR|VALID_WARNING|VALIDATION_ERROR' "$log" | sort | uniq -c | head -20 | grep .; then
	exit 1
fi
echo "the validation layer has nothing to say"
