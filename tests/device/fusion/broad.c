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

// The rate (rad/s, sensor's axes) that the reference has half way from row i to the next.
static struct ap_vec3 reference_rate(const struct broad_row *rows, size_t i) {
    struct ap_quat d = ap_quat_mul(ap_quat_conj(rows[i].truth), rows[i + 1].truth);
    double sine = sqrt(d.x * d.x + d.y * d.y + d.z * d.z), sign = d.w < 0 ? -1 : 1;
    double k = 2 * sign * (sine > 1e-12 ? atan2(sine, fabs(d.w)) / sine : 1) / BROAD_PERIOD_S;
    return (struct ap_vec3){k * d.x, k * d.y, k * d.z};
}

// Mean square of what is left of the rates when they are `shift` rows late.
static double rates_apart(const struct broad_row *rows, size_t count, size_t shift) {
    static const double MARKERS_TAKEN_FOR_OTHERS = 40; // rad/s
    double sum = 0, n = 0;
    for (size_t i = 0; i + 1 + shift < count; i++) {
        struct ap_vec3 w = reference_rate(rows, i);
        double size = ap_vec3_length(w);
        if (!rows[i].moving || !isfinite(size) || size > MARKERS_TAKEN_FOR_OTHERS)
            continue;
        double off = ap_vec3_length(ap_vec3_sub(rows[i + shift].gyr, w));
        sum += off * off;
        n++;
    }
    return sum / n;
}

double broad_lag_s(const struct broad_row *rows, size_t count) {
    enum { MOST = 6 };
    double apart[MOST];
    size_t best = 0;
    for (size_t s = 0; s < MOST; s++) {
        apart[s] = rates_apart(rows, count, s);
        best = apart[s] < apart[best] ? s : best;
    }
    if (best == 0 || best == MOST - 1)
        return NAN;
    double before = apart[best - 1], after = apart[best + 1]; // the parabola's lowest point
    double off = (before - after) / (before - 2 * apart[best] + after) / 2;
    return ((double)best + off - 0.5) * BROAD_PERIOD_S; // a rate is half way between two references
}

struct broad_row broad_in_step(const struct broad_row *rows, size_t i, double lag_s) {
    double back = lag_s / BROAD_PERIOD_S, whole = floor(back);
    struct broad_row row = rows[i];
    size_t late = i > (size_t)whole ? i - (size_t)whole : 0;
    row.truth = ap_quat_slerp(rows[late].truth, rows[late ? late - 1 : 0].truth, back - whole);
    return row;
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
