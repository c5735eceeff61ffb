#include "src/device/log/decimal.h"
#include "src/device/log/poselog_fields.h"

// The two trajectory formats of the robotics benchmarks. Neither names a device.

// t x y z qx qy qz qw, seconds, between blanks.
bool ap_tum_parse(const char *line, size_t len, struct ap_row *row, struct ap_bad_line *bad) {
    static const char *const names[8] = {"t", "x", "y", "z", "qx", "qy", "qz", "qw"};
    struct ap_field f[8];
    size_t n = ap_split_blanks(line, len, f, 8);
    if (n != 8)
        return ap_bad_line_at(bad, line, line + len, "8 fields (t x y z qx qy qz qw), not %zu", n);
    *row = (struct ap_row){.t_column = (size_t)(f[0].text - line) + 1};
    bool read = ap_decimal_seconds_ns(f[0].text, f[0].len, &row->t_ns);
    if (!ap_field_time(line, f[0].text, read, row->t_ns, "decimal seconds", bad))
        return false;
    double v[8];
    for (int i = 1; i < 8; i++)
        if (!ap_field_number(line, f[i], names[i], &v[i], bad))
            return false;
    row->pose.p = (struct ap_vec3){v[1], v[2], v[3]};
    row->pose.q = (struct ap_quat){v[4], v[5], v[6], v[7]};
    return ap_field_quat(line, f[4].text, &row->pose.q, bad);
}
