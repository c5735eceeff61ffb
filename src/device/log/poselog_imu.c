#include "src/device/log/poselog_imu.h"

#include <stdlib.h>

#include "src/base/number.h"
#include "src/device/log/poselog_fields.h"

bool ap_imu_line_parse(const char *line, size_t len, struct ap_imu_line *out,
                       struct ap_bad_line *bad) {
    static const char *const names[7] = {"t_ns", "wx", "wy", "wz", "ax", "ay", "az"};
    struct ap_field f[7];
    size_t n = ap_split_commas(line, len, f, 7);
    if (n != 7)
        return ap_bad_line_at(bad, line, line + len,
                              "7 fields as before (t_ns,wx,wy,wz,ax,ay,az), not %zu", n);
    int64_t t_ns = 0;
    bool read = ap_parse_int64(f[0].text, f[0].len, &t_ns);
    if (!ap_field_time(line, f[0].text, read, t_ns, "whole nanoseconds", bad))
        return false;
    double v[7];
    for (int i = 1; i < 7; i++)
        if (!ap_field_number(line, f[i], names[i], &v[i], bad))
            return false;
    *out = (struct ap_imu_line){.t_ns = t_ns,
                                .gyr_rad_s = {v[1], v[2], v[3]},
                                .acc_m_s2 = {v[4], v[5], v[6]},
                                .t_column = (size_t)(f[0].text - line) + 1,
                                .gyr_column = (size_t)(f[1].text - line) + 1};
    return true;
}

static int by_size(const void *a, const void *b) {
    const int64_t *p = a, *q = b;
    return *p < *q ? -1 : *p > *q;
}

// The middle one of the first intervals is the period; one of them may be a gap.
static void begin(struct ap_log_imu *imu) {
    int64_t steps[AP_LOG_IMU_FIRST - 1];
    for (int i = 1; i < AP_LOG_IMU_FIRST; i++)
        steps[i - 1] = imu->first[i].t_ns - imu->first[i - 1].t_ns;
    qsort(steps, AP_LOG_IMU_FIRST - 1, sizeof *steps, by_size);
    double period_s = 1e-9 * (double)steps[AP_LOG_IMU_FIRST / 2];
    period_s = period_s < 1e-4 ? 1e-4 : period_s > 0.1 ? 0.1 : period_s;
    const struct ap_imu_params params = {
        .period_s = period_s, .bits = 64, .tick_ns_num = 1, .tick_ns_den = 1};
    ap_imu_init(&imu->fusion, &params);
    for (int i = 0; i < AP_LOG_IMU_FIRST - 1; i++)
        ap_imu_add(&imu->fusion, (uint64_t)imu->first[i].t_ns, imu->first[i].gyr_rad_s,
                   imu->first[i].acc_m_s2);
}

static bool is_possible(const struct ap_imu_line *line) {
    return ap_vec3_length(line->gyr_rad_s) < 200 && ap_vec3_length(line->acc_m_s2) < 2000;
}

static bool bad_at(struct ap_bad_line *bad, size_t column, const char *expected) {
    ap_bad_line_at(bad, "", "", "%s", expected);
    bad->column = column;
    return false;
}

bool ap_log_imu_take(struct ap_log_imu *imu, const struct ap_imu_line *line,
                     const struct ap_axes *axes, struct ap_row *row, bool *has_row,
                     struct ap_bad_line *bad) {
    struct ap_imu_line l = *line;
    l.gyr_rad_s = ap_axes_rate(axes, l.gyr_rad_s);
    l.acc_m_s2 = ap_axes_vec3(axes, l.acc_m_s2);
    *has_row = false;
    if (!is_possible(&l))
        return bad_at(bad, l.gyr_column, "rates below 200 rad/s and forces below 2000 m/s²");
    if (imu->first_count < AP_LOG_IMU_FIRST) {
        imu->first[imu->first_count++] = l;
        if (imu->first_count < AP_LOG_IMU_FIRST)
            return true;
        begin(imu);
    }
    enum ap_imu_event event = ap_imu_add(&imu->fusion, (uint64_t)l.t_ns, l.gyr_rad_s, l.acc_m_s2);
    if (event == AP_IMU_REPEATED)
        return bad_at(bad, l.t_column, "a time after the line before");
    if (event == AP_IMU_REFUSED)
        return bad_at(bad, l.gyr_column, "rates and forces that a sensor can measure");
    *row = (struct ap_row){.t_ns = l.t_ns,
                           .pose = {{0, 0, 0}, ap_vqf_orientation(&imu->fusion.vqf)},
                           .reset = event == AP_IMU_RESET,
                           .t_column = l.t_column};
    *has_row = true;
    return true;
}
