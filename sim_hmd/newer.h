#ifndef ANTIPODE_SIM_HMD_NEWER_H
#define ANTIPODE_SIM_HMD_NEWER_H

#include <openxr/openxr.h>

// What the specification has and Debian's header (1.0.20) has not. Values from the OpenXR registry.

#ifndef XR_EXT_local_floor
#define XR_EXT_local_floor 1
#define XR_EXT_local_floor_SPEC_VERSION 1
#define XR_EXT_LOCAL_FLOOR_EXTENSION_NAME "XR_EXT_local_floor"
#define XR_REFERENCE_SPACE_TYPE_LOCAL_FLOOR_EXT ((XrReferenceSpaceType)1000426000)
#endif

#endif
