#include "src/device/calibration/rest.h"

#include <math.h>
#include <string.h>

static const int64_t TIME_MAX_NS = INT64_MAX / 4; // so that differences are numbers
static const int64_t QUARTER_NS = 250000000, GAP_NS = 500000000;
enum { QUARTERS_MIN = 8, SAMPLES_MIN = 5 };
static const double DEGREE = M_PI / 180, G = 9.80665;

static struct ap_vec3 square(struct ap_vec3 v) {
    return (struct ap_vec3){v.x * v.x, v.y * v.y, v.z * v.z};
}

static double largest(struct ap_vec3 v) {
    return fmax(fabs(v.x), fmax(fabs(v.y), fabs(v.z)));
}

// Per axis, from the sums of differences from the first.
static struct ap_vec3 deviation(struct ap_vec3 sum, struct ap_vec3 sum2, int64_t n) {
    struct ap_vec3 m = ap_vec3_scale(1.0 / (double)n, sum);
    struct ap_vec3 v = ap_vec3_sub(ap_vec3_scale(1.0 / (double)n, sum2), square(m));
    return (struct ap_vec3){sqrt(fmax(v.x, 0)), sqrt(fmax(v.y, 0)), sqrt(fmax(v.z, 0))};
}

static void end_run(struct ap_rest *r) {
    if (r->held.quarters >= QUARTERS_MIN && r->found_count < AP_RESTS_MAX)
        r->found[r->found_count++] = r->held;
    r->run_quarters = 0;
    memset(&r->run, 0, sizeof r->run);
    memset(&r->held, 0, sizeof r->held);
}

// Why a quarter is none of rest, or NULL.
static const char *why_not(const struct ap_rest *r, struct ap_vec3 gyr, struct ap_vec3 acc) {
    const struct ap_rest_sums *b = &r->block;
    if (b->count < SAMPLES_MIN)
        return "fewer than 20 measurements a second came";
    if (largest(deviation(b->gyr, b->gyr2, b->count)) > 0.5 * DEGREE)
        return "it was being turned";
    if (largest(deviation(b->acc, b->acc2, b->count)) > 0.2)
        return "it was being shaken";
    if (ap_vec3_length(gyr) > 5 * DEGREE)
        return "it turned steadily, by over 5 degrees a second";
    if (fabs(ap_vec3_length(acc) - G) > 1)
        return "the force was not gravity's";
    if (r->run_quarters > 0 && (largest(ap_vec3_sub(gyr, r->before_gyr)) > 0.3 * DEGREE ||
                                largest(ap_vec3_sub(acc, r->before_acc)) > 0.1))
        return "it was turned slowly";
    return NULL;
}

static void end_quarter(struct ap_rest *r) {
    const struct ap_rest_sums *b = &r->block;
    if (b->count == 0)
        return;
    double n = (double)b->count;
    struct ap_vec3 gyr = ap_vec3_add(b->gyr0, ap_vec3_scale(1 / n, b->gyr));
    struct ap_vec3 acc = ap_vec3_add(b->acc0, ap_vec3_scale(1 / n, b->acc));
    const char *why = why_not(r, gyr, acc);
    if (why) {
        end_run(r);
        r->last_why = why;
        return;
    }
    // The first quarter of a rest is when it is let go, the last when it is taken: neither counts.
    r->held = r->run;
    if (r->run_quarters > 0) {
        r->run.quarters++;
        r->run.gyr = ap_vec3_add(r->run.gyr, gyr);
        r->run.gyr2 = ap_vec3_add(r->run.gyr2, square(gyr));
        r->run.acc = ap_vec3_add(r->run.acc, acc);
    }
    r->run_quarters++;
    r->before_gyr = gyr;
    r->before_acc = acc;
}

bool ap_rest_add(struct ap_rest *r, int64_t t_ns, struct ap_vec3 gyr, struct ap_vec3 acc) {
    if (!isfinite(gyr.x + gyr.y + gyr.z + acc.x + acc.y + acc.z) || t_ns < -TIME_MAX_NS ||
        t_ns > TIME_MAX_NS || (r->started && t_ns <= r->last_ns))
        return false;
    bool gap = r->started && t_ns - r->last_ns > GAP_NS;
    if (gap)
        end_run(r);
    if (!r->started || gap || t_ns - r->block_ns >= QUARTER_NS) {
        if (r->started && !gap)
            end_quarter(r);
        memset(&r->block, 0, sizeof r->block);
        r->block.gyr0 = gyr;
        r->block.acc0 = acc;
        r->block_ns = t_ns;
    }
    r->started = true;
    r->last_ns = t_ns;
    r->samples++;
    struct ap_rest_sums *b = &r->block;
    struct ap_vec3 dg = ap_vec3_sub(gyr, b->gyr0), da = ap_vec3_sub(acc, b->acc0);
    b->count++;
    b->gyr = ap_vec3_add(b->gyr, dg);
    b->acc = ap_vec3_add(b->acc, da);
    b->gyr2 = ap_vec3_add(b->gyr2, square(dg));
    b->acc2 = ap_vec3_add(b->acc2, square(da));
    return true;
}

// Solves the symmetric positive 3×3 system by Cholesky's decomposition.
static struct ap_vec3 solve(double a[3][3], struct ap_vec3 b) {
    double l[3][3] = {{0}}, y[3], x[3], right[3] = {b.x, b.y, b.z};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j <= i; j++) {
            double s = a[i][j];
            for (int k = 0; k < j; k++)
                s -= l[i][k] * l[j][k];
            l[i][j] = i == j ? sqrt(s) : s / l[j][j];
        }
    for (int i = 0; i < 3; i++) {
        y[i] = right[i];
        for (int k = 0; k < i; k++)
            y[i] -= l[i][k] * y[k];
        y[i] /= l[i][i];
    }
    for (int i = 2; i >= 0; i--) {
        x[i] = y[i];
        for (int k = i + 1; k < 3; k++)
            x[i] -= l[k][i] * x[k];
        x[i] /= l[i][i];
    }
    return (struct ap_vec3){x[0], x[1], x[2]};
}

// |force − bias| = g in every pose: Levenberg's steps from zero. What the poses do not tell stays
// zero; the damping is of the steps, so what they do tell is exact.
static struct ap_vec3 acc_bias(const struct ap_vec3 *force, int count) {
    struct ap_vec3 bias = {0, 0, 0};
    for (int step = 0; step < 40; step++) {
        double a[3][3] = {{0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}};
        struct ap_vec3 b = {0, 0, 0};
        for (int i = 0; i < count; i++) {
            struct ap_vec3 f = ap_vec3_sub(force[i], bias);
            double length = ap_vec3_length(f);
            struct ap_vec3 u = ap_vec3_scale(1 / length, f);
            const double v[3] = {u.x, u.y, u.z};
            b = ap_vec3_add(b, ap_vec3_scale(length - G, u));
            for (int r = 0; r < 3; r++)
                for (int c = 0; c < 3; c++)
                    a[r][c] += v[r] * v[c];
        }
        bias = ap_vec3_add(bias, solve(a, b));
    }
    return bias;
}

static int count_poses(const struct ap_vec3 *force, int count) {
    static const double COS_20 = 0.9396926207859084;
    int poses = 0;
    for (int i = 0; i < count; i++) {
        bool seen = false;
        for (int k = 0; k < i && !seen; k++)
            seen = ap_vec3_dot(ap_vec3_normalize(force[i]), ap_vec3_normalize(force[k])) > COS_20;
        poses += !seen;
    }
    return poses;
}

enum ap_status ap_rest_result(struct ap_error *err, const struct ap_rest *rest,
                              struct ap_rest_result *out) {
    struct ap_rest r = *rest; // what is going on counts, too
    end_run(&r);
    if (r.samples == 0)
        return ap_fail(err, AP_INPUT, "no measurements of a gyroscope and an accelerometer");
    if (r.found_count == 0)
        return ap_fail(err, AP_INPUT,
                       "it did not lie still for two seconds%s%s: put it on a table and let go",
                       r.last_why ? ": " : "", r.last_why ? r.last_why : "");
    struct ap_vec3 sum = {0, 0, 0}, sum2 = {0, 0, 0}, force[AP_RESTS_MAX];
    int64_t n = 0;
    for (int i = 0; i < r.found_count; i++) {
        const struct ap_rest_found *f = &r.found[i];
        n += f->quarters;
        sum = ap_vec3_add(sum, f->gyr);
        sum2 = ap_vec3_add(sum2, f->gyr2);
        force[i] = ap_vec3_scale(1.0 / f->quarters, f->acc);
    }
    struct ap_rest_result result = {.seconds = 1e-9 * (double)(QUARTER_NS * n),
                                    .poses = count_poses(force, r.found_count)};
    result.bias.gyr_rad_s = ap_vec3_scale(1.0 / (double)n, sum);
    result.bias.acc_m_s2 = acc_bias(force, r.found_count);
    result.gyr_sigma_rad_s = largest(deviation(sum, sum2, n)) / sqrt((double)n - 1);
    if (ap_vec3_length(result.bias.acc_m_s2) > 1)
        return ap_fail(err, AP_INPUT,
                       "the accelerometer would be off by %.2f m/s2: expected at most 1",
                       ap_vec3_length(result.bias.acc_m_s2));
    *out = result;
    return AP_OK;
}
