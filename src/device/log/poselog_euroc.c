#include "src/base/number.h"
#include "src/device/log/poselog_fields.h"

// t_ns,px,py,pz,qw,qx,qy,qz and what a ground truth has more (velocities, biases), which is not
// looked at. Note the real part in front.
bool ap_euroc_parse(const char *line, size_t len, struct ap_row *row, struct ap_bad_line *bad) {
    static const char *const names[8] = {"t_ns", "px", "py", "pz", "qw", "qx", "qy", "qz"};
    struct ap_field f[8];
    size_t n = ap_split_commas(line, len, f, 8);
    if (n < 8)
        return ap_bad_line_at(bad, line, line + len,
                              "at least 8 fields (t_ns,px,py,pz,qw,qx,qy,qz), not %zu", n);
    *row = (struct ap_row){.t_column = (size_t)(f[0].text - line) + 1};
    bool read = ap_parse_int64(f[0].text, f[0].len, &row->t_ns);
    if (!ap_field_time(line, f[0].text, read, row->t_ns, "whole nanoseconds", bad))
        return false;
    double v[8];
    for (int i = 1; i < 8; i++)
        if (!ap_field_number(line, f[i], names[i], &v[i], bad))
            return false;
    row->pose.p = (struct ap_vec3){v[1], v[2], v[3]};
    row->pose.q = (struct ap_quat){v[5], v[6], v[7], v[4]};
    return ap_field_quat(line, f[4].text, &row->pose.q, bad);
}
