#include "src/device/headset.h"

// headsets/standard.json; tests/device/test_headset.c holds the two against each other.
struct ap_headset_profile ap_headset_builtin(void) {
    return (struct ap_headset_profile){.name = "standard",
                                       .refresh_hz = 90,
                                       .ipd_m = 0.064,
                                       .eye = {{.width_px = 1440,
                                                .height_px = 1600,
                                                .left_rad = -0.82,
                                                .right_rad = 0.74,
                                                .up_rad = 0.8,
                                                .down_rad = -0.88},
                                               {.width_px = 1440,
                                                .height_px = 1600,
                                                .left_rad = -0.74,
                                                .right_rad = 0.82,
                                                .up_rad = 0.8,
                                                .down_rad = -0.88}},
                                       .grip_from_aim = AP_POSE_IDENTITY};
}
