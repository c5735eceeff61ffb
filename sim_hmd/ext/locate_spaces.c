#include "sim_hmd/core/spaces.h"

// XR_KHR_locate_spaces, and xrLocateSpaces of OpenXR 1.1: xrLocateSpace for many at once.

static XrSpaceVelocities *velocities_of(XrSpaceLocations *locations) {
    return sim_chained(locations, XR_TYPE_SPACE_VELOCITIES);
}

static XrResult check(XrSession handle, const XrSpacesLocateInfo *info,
                      XrSpaceLocations *locations) {
    SIM_LOCKED;
    struct sim_session *session;
    XrResult result = sim_session_get(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    if (!sim_is(info, XR_TYPE_SPACES_LOCATE_INFO) || !sim_is(locations, XR_TYPE_SPACE_LOCATIONS) ||
        !info->spaceCount || !info->spaces || locations->locationCount != info->spaceCount ||
        !locations->locations)
        return XR_ERROR_VALIDATION_FAILURE;
    const XrSpaceVelocities *velocities = velocities_of(locations);
    if (velocities && (velocities->velocityCount != info->spaceCount || !velocities->velocities))
        return XR_ERROR_VALIDATION_FAILURE;
    const struct sim_space *base = sim_space_get(info->baseSpace);
    if (!base)
        return XR_ERROR_HANDLE_INVALID;
    if (base->session != session)
        return XR_ERROR_VALIDATION_FAILURE;
    return info->time <= 0 ? XR_ERROR_TIME_INVALID : XR_SUCCESS;
}

XrResult XRAPI_CALL xrLocateSpaces(XrSession handle, const XrSpacesLocateInfo *info,
                                   XrSpaceLocations *locations) {
    XrResult result = check(handle, info, locations);
    if (result != XR_SUCCESS)
        return result;
    const XrSpaceVelocities *velocities = velocities_of(locations);
    for (uint32_t i = 0; i < info->spaceCount && result == XR_SUCCESS; i++) {
        XrSpaceVelocity velocity = {.type = XR_TYPE_SPACE_VELOCITY};
        XrSpaceLocation at = {.type = XR_TYPE_SPACE_LOCATION,
                              .next = velocities ? &velocity : NULL};
        result = xrLocateSpace(info->spaces[i], info->baseSpace, info->time, &at);
        locations->locations[i] = (XrSpaceLocationData){at.locationFlags, at.pose};
        if (velocities)
            velocities->velocities[i] = (XrSpaceVelocityData){
                velocity.velocityFlags, velocity.linearVelocity, velocity.angularVelocity};
    }
    return result;
}

const struct sim_function sim_functions_KHR_locate_spaces[] = {
    {"xrLocateSpacesKHR", (PFN_xrVoidFunction)xrLocateSpaces},
    {0},
};
