#include "xr/internal.h"

struct ap_pose ap_pose_from_xr(XrPosef pose) {
    struct ap_quat q = {pose.orientation.x, pose.orientation.y, pose.orientation.z,
                        pose.orientation.w};
    return (struct ap_pose){{pose.position.x, pose.position.y, pose.position.z},
                            ap_quat_normalize(q)};
}

XrPosef ap_pose_to_xr(struct ap_pose pose) {
    struct ap_quat q = ap_quat_normalize(pose.q);
    return (XrPosef){{(float)q.x, (float)q.y, (float)q.z, (float)q.w},
                     {(float)pose.p.x, (float)pose.p.y, (float)pose.p.z}};
}

enum ap_status ap_xr_locate(struct ap_error *err, struct ap_xr *xr, XrSpace space, XrTime time,
                            struct ap_xr_located *located) {
    XrSpaceLocation at = {.type = XR_TYPE_SPACE_LOCATION};
    enum ap_status st =
        ap_xr_check(err, xr, ap_xrl.LocateSpace(space, xr->stage, time, &at), "xrLocateSpace");
    if (st)
        return st;
    const XrSpaceLocationFlags valid =
        XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT;
    const XrSpaceLocationFlags tracked =
        XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT | XR_SPACE_LOCATION_POSITION_TRACKED_BIT;
    *located = (struct ap_xr_located){.pose = AP_POSE_IDENTITY};
    located->valid = (at.locationFlags & valid) == valid;
    located->tracked = located->valid && (at.locationFlags & tracked) == tracked;
    if (located->valid)
        located->pose = ap_pose_from_xr(at.pose);
    return AP_OK;
}
