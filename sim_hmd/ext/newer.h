#ifndef ANTIPODE_SIM_HMD_EXT_NEWER_H
#define ANTIPODE_SIM_HMD_EXT_NEWER_H

#include <openxr/openxr.h>

// What the specification has and Debian's header (1.0.20) has not. Values from the OpenXR registry.

#ifndef XR_EXT_local_floor
#define XR_EXT_local_floor 1
#define XR_EXT_local_floor_SPEC_VERSION 1
#define XR_EXT_LOCAL_FLOOR_EXTENSION_NAME "XR_EXT_local_floor"
#define XR_REFERENCE_SPACE_TYPE_LOCAL_FLOOR_EXT ((XrReferenceSpaceType)1000426000)
#endif

#ifndef XR_EXT_palm_pose
#define XR_EXT_palm_pose 1
#define XR_EXT_palm_pose_SPEC_VERSION 3
#define XR_EXT_PALM_POSE_EXTENSION_NAME "XR_EXT_palm_pose"
#endif

// OpenXR 1.1 has it under the same names without KHR.
#ifndef XR_KHR_locate_spaces
#define XR_KHR_locate_spaces 1
#define XR_KHR_locate_spaces_SPEC_VERSION 1
#define XR_KHR_LOCATE_SPACES_EXTENSION_NAME "XR_KHR_locate_spaces"
#define XR_TYPE_SPACES_LOCATE_INFO ((XrStructureType)1000471000)
#define XR_TYPE_SPACE_LOCATIONS ((XrStructureType)1000471001)
#define XR_TYPE_SPACE_VELOCITIES ((XrStructureType)1000471002)

typedef struct XrSpacesLocateInfo {
    XrStructureType type;
    const void *XR_MAY_ALIAS next;
    XrSpace baseSpace;
    XrTime time;
    uint32_t spaceCount;
    const XrSpace *spaces;
} XrSpacesLocateInfo;

typedef struct XrSpaceLocationData {
    XrSpaceLocationFlags locationFlags;
    XrPosef pose;
} XrSpaceLocationData;

typedef struct XrSpaceLocations {
    XrStructureType type;
    void *XR_MAY_ALIAS next;
    uint32_t locationCount;
    XrSpaceLocationData *locations;
} XrSpaceLocations;

typedef struct XrSpaceVelocityData {
    XrSpaceVelocityFlags velocityFlags;
    XrVector3f linearVelocity;
    XrVector3f angularVelocity;
} XrSpaceVelocityData;

typedef struct XrSpaceVelocities {
    XrStructureType type;
    void *XR_MAY_ALIAS next;
    uint32_t velocityCount;
    XrSpaceVelocityData *velocities;
} XrSpaceVelocities;

typedef XrResult(XRAPI_PTR *PFN_xrLocateSpaces)(XrSession session,
                                                const XrSpacesLocateInfo *locateInfo,
                                                XrSpaceLocations *spaceLocations);
XrResult XRAPI_CALL xrLocateSpaces(XrSession session, const XrSpacesLocateInfo *locateInfo,
                                   XrSpaceLocations *spaceLocations);
#endif

#endif
