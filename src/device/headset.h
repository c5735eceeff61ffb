#ifndef ANTIPODE_DEVICE_HEADSET_H
#define ANTIPODE_DEVICE_HEADSET_H

#include <jansson.h>
#include <stdint.h>

#include "src/base/json.h"
#include "src/base/status.h"
#include "src/device/headsets/lens.h"
#include "src/geom/pose.h"

// A headset profile: shared/contract's JSON, docs/headset-profile.md. Unknown keys are errors.
struct ap_eye_profile {
    uint32_t width_px, height_px;                 // 1…16384
    double left_rad, right_rad, up_rad, down_rad; // signs as in XrFovf; |angle| < pi/2
    double yaw_rad;                               // about the eye's +y
    struct ap_lens lens;                          // red_scale 0: none is described
    // What the lens lets see: an ellipse in tangents, center x, y (+y up) and radius x, y; its
    // center lies in the fov. Radius 0: all of it.
    double seen[4];
};

struct ap_headset_profile {
    char name[128];
    double refresh_hz;
    double ipd_m;
    struct ap_eye_profile eye[2]; // left, right
    struct ap_pose grip_from_aim; // identity unless the profile has it
};

// AP_INPUT with the place in the file: fov ≥ 180°, left ≥ right, size 0, refresh or ipd ≤ 0…
enum ap_status ap_headset_read(struct ap_error *err, const char *path,
                               struct ap_headset_profile *profile);

// From a document that holds the profile as a member.
enum ap_status ap_headset_parse(struct ap_error *err, const struct ap_json_at *at,
                                struct ap_headset_profile *profile);

// As JSON, so that parse(write(p)) == p bit for bit. NULL without memory.
json_t *ap_headset_to_json(const struct ap_headset_profile *profile);

// The profile that src/device/headsets/standard.json holds: what is used where none is given.
struct ap_headset_profile ap_headset_builtin(void);

// Where a controller held at room_from_grip points from: room_from_aim.
struct ap_pose ap_headset_aim(const struct ap_headset_profile *profile,
                              struct ap_pose room_from_grip);

// view_from_eye: position (∓ipd/2, 0, 0), orientation yaw_rad about +y. eye 0 left, 1 right.
struct ap_pose ap_headset_view_from_eye(const struct ap_headset_profile *profile, int eye);

#endif
