#ifndef ANTIPODE_TESTS_DEVICE_FUSION_BROAD_H
#define ANTIPODE_TESTS_DEVICE_FUSION_BROAD_H

#include <stdbool.h>
#include <stddef.h>

#include "src/geom/vec.h"

// The two real IMU recordings with an optical reference (shared/data/imu), and how far an estimate
// is from the reference.

struct broad_row {
    double t_s;
    struct ap_vec3 gyr, acc;
    struct ap_quat truth; // sensor to earth, +z up; NaN where the markers were hidden
    bool moving;
};

// malloc'ed rows; NULL where the file cannot be read.
struct broad_row *broad_read(const char *path, size_t *count);

extern const double BROAD_PERIOD_S;

// By how many seconds the rates come after the reference: where the gyroscope agrees best (least
// squares) with the turns from one reference to the next, and no orientation is estimated. NaN
// where there is nothing to compare.
double broad_lag_s(const struct broad_row *rows, size_t count);

// Row i with the reference of lag_s (0 to a period or two) before; of the first row, before that.
struct broad_row broad_in_step(const struct broad_row *rows, size_t i, double lag_s);

struct broad_errors {
    double heading_start; // the offset removed: the mean of the first two seconds
    size_t starts;
    double last_heading, turns; // to unwrap
    double n, t, tt, h, th;     // sums for the line through the heading error
    double inclination2, total2, moving;
};

// The estimate (sensor to earth, +y up) at a row. Rows in order, from the first.
void broad_add(struct broad_errors *errors, const struct broad_row *row, struct ap_quat estimate);

double broad_inclination_deg(const struct broad_errors *errors); // RMS while moving
double broad_total_deg(const struct broad_errors *errors);       // the same
double broad_drift_deg_min(const struct broad_errors *errors);   // slope of the heading error

#endif
