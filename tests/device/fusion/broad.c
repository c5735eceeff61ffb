#include "tests/device/fusion/broad.h"

#include <stdio.h>
#include <stdlib.h>

const double BROAD_PERIOD_S = 1 / 285.714285714285714;

static const double DEGREE = 3.14159265358979323846 / 180;
static const double TURN = 2 * 3.14159265358979323846;

struct broad_row *broad_read(const char *path, size_t *count) {
    FILE *file = fopen(path, "r");
    if (!file)
        return NULL;
    size_t room = 32768, n = 0;
    struct broad_row *rows = calloc(room, sizeof *rows);
    char line[512];
    while (rows && n < room && fgets(line, sizeof line, file)) {
        double v[12];
        char *at = line;
        int i = 0;
        for (; i < 12 && *line != '#'; i++) {
            char *end;
            v[i] = strtod(at, &end);
            if (end == at)
                break;
            at = *end == ',' ? end + 1 : end;
        }
        if (i == 12)
            rows[n++] = (struct broad_row){
                v[0], {v[1], v[2], v[3]}, {v[4], v[5], v[6]}, {v[8], v[9], v[10], v[7]}, v[11] > 0};
    }
    fclose(file);
    *count = n;
    return rows;
}

void broad_add(struct broad_errors *e, const struct broad_row *row, struct ap_quat estimate) {
    if (!isfinite(row->truth.w + row->truth.x + row->truth.y + row->truth.z))
        return;
    struct ap_quat z_from_y = {sqrt(0.5), 0, 0, sqrt(0.5)};
    struct ap_quat d = ap_quat_mul(ap_quat_mul(z_from_y, estimate), ap_quat_conj(row->truth));
    double heading = 2 * atan2(d.z, d.w);
    heading -= TURN * round((heading - e->last_heading) / TURN); // beside the last one
    e->last_heading = heading;
    if (row->t_s < 2) {
        e->heading_start += heading;
        e->starts++;
        return;
    }
    double off = heading - e->heading_start / (double)e->starts;
    e->n++;
    e->t += row->t_s;
    e->tt += row->t_s * row->t_s;
    e->h += off;
    e->th += row->t_s * off;
    if (!row->moving)
        return;
    double inclination = 2 * acos(fmin(1, hypot(d.z, d.w)));
    double whole = 2 * acos(fmin(1, fabs(cos(inclination / 2) * cos(off / 2))));
    e->inclination2 += inclination * inclination;
    e->total2 += whole * whole;
    e->moving++;
}

double broad_inclination_deg(const struct broad_errors *e) {
    return sqrt(e->inclination2 / e->moving) / DEGREE;
}

double broad_total_deg(const struct broad_errors *e) {
    return sqrt(e->total2 / e->moving) / DEGREE;
}

double broad_drift_deg_min(const struct broad_errors *e) {
    return 60 * (e->n * e->th - e->t * e->h) / (e->n * e->tt - e->t * e->t) / DEGREE;
}
