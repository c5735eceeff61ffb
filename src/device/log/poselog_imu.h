#ifndef ANTIPODE_DEVICE_LOG_POSELOG_IMU_H
#define ANTIPODE_DEVICE_LOG_POSELOG_IMU_H

#include "src/device/axes.h"
#include "src/device/fusion/imu.h"
#include "src/device/log/poselog_format.h"

// Recorded rates and forces (EuRoC's imu0/data.csv) as a log of poses: VQF gives the orientation, a
// body's model the place. The first lines tell the rate; rows come from the one after them on.

enum { AP_LOG_IMU_FIRST = 9 };

struct ap_imu_line {
    int64_t t_ns;
    struct ap_vec3 gyr_rad_s, acc_m_s2;
    size_t t_column, gyr_column;
};

// t_ns,wx,wy,wz,ax,ay,az.
bool ap_imu_line_parse(const char *line, size_t len, struct ap_imu_line *out,
                       struct ap_bad_line *bad);

struct ap_log_imu {
    struct ap_imu fusion;
    struct ap_imu_line first[AP_LOG_IMU_FIRST];
    int first_count;
};

// One line into the fusion. *has_row: it gave a row, whose pose's place is still to be said. False:
// a bad line (beyond what sensors measure; a time not after the last one), which changes nothing.
bool ap_log_imu_take(struct ap_log_imu *imu, const struct ap_imu_line *line,
                     const struct ap_axes *axes, struct ap_row *row, bool *has_row,
                     struct ap_bad_line *bad);

#endif
