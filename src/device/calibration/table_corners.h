#ifndef ANTIPODE_DEVICE_CALIBRATION_TABLE_CORNERS_H
#define ANTIPODE_DEVICE_CALIBRATION_TABLE_CORNERS_H

#include <stdbool.h>
#include <stdint.h>

#include "src/base/status.h"
#include "src/geom/pose.h"

// Where a square table stands, from three or four of its corners, touched with a tracked device.

enum { AP_TABLE_TOUCHES_MAX = 4 };

struct ap_table_place {
    double x_m, z_m, yaw_rad; // as in --table-at; yaw in [−45°, 45°): of the four the nearest to 0
    double height_m;          // of the surface above the room's floor
    double edge_m;
};

struct ap_table_fit {
    struct ap_table_place place;
    double residual_m[AP_TABLE_TOUCHES_MAX]; // distance of each touch from its corner
    double rms_m;                            // of those
    double corner_rad; // the angle that is to be a right one, as it was touched
    double slope_rad;  // of the plane through the touches; three or more
    double side_m[2];  // the two edges between three touches
};

// Least squares over the surface's height, the centre, the direction of the edges and their length;
// edge_m > 0: of that length. The touches may come in any order (three: one of them is the corner
// between the other two). With an error of s metres in each coordinate of three touches the centre
// is off by s·sqrt(3/8) in x and in z, the height by s/sqrt(3), the yaw by s·sqrt(3)/(2·edge).
// AP_INPUT: not three or four, not finite, an edge below 0.2 m or over 5 m, or nothing like a
// square: a touch over 0.1 m off.
enum ap_status ap_table_fit(struct ap_error *err, const struct ap_vec3 *touches, int count,
                            double edge_m, struct ap_table_fit *fit);

// What a person should look at again, a sentence; NULL: nothing. A corner is to be within 2° of a
// right angle, edges within 2 cm of each other, the surface within 1° of level.
const char *ap_table_fit_doubt(const struct ap_table_fit *fit);

// A device's samples to touches: one for each press, at the mean of where the tip was while it was
// pressed (at most 0.5 s).
struct ap_touch_finder {
    struct ap_vec3 tip_m; // in the device's axes
    bool is_pressed, is_done;
    int64_t start_ns;
    int64_t count;
    struct ap_vec3 first, sum; // of the press; the sum from the first
    double spread_m;
};

enum ap_touch_event {
    AP_TOUCH_NONE,
    AP_TOUCH_MADE,  // *touch is where
    AP_TOUCH_MOVED, // pressed, but the tip moved by over 2 cm: not taken
};

// In the order of time.
enum ap_touch_event ap_touch_find(struct ap_touch_finder *f, int64_t t_ns, struct ap_pose pose,
                                  bool pressed, struct ap_vec3 *touch);

#endif
