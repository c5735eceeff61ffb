#include "src/device/fusion/vqf.h"

// Variances are in (0.01 °/s)², the paper's unit, in which they are near one.

static const double DEGREE = 3.14159265358979323846 / 180;

static const double RATE_MAX = 200, FORCE_MAX = 2000, DT_MAX = 0.5;
static const double VERTICAL_FORGETTING = 1e-4; // how little motion says about the vertical axis

static bool fill(double *value, double standard, double low, double high) {
    if (*value == 0)
        *value = standard;
    return *value >= low && *value <= high;
}

static bool fill_all(struct ap_vqf_params *p) {
    return fill(&p->period_s, 0, 1e-5, 0.5) && fill(&p->tau_acc_s, 3, p->period_s, 1e4) &&
           fill(&p->bias_sigma_init, 0.5, 1e-3, 100) && fill(&p->bias_forget_s, 100, 1e-2, 1e7) &&
           fill(&p->bias_clip, 2, 1e-3, 1000) && fill(&p->bias_sigma_motion, 0.1, 1e-3, 100) &&
           fill(&p->bias_sigma_rest, 0.03, 1e-3, 100) && fill(&p->rest_min_s, 1.5, 1e-3, 1e4) &&
           fill(&p->rest_tau_s, 0.5, p->period_s, 1e4) && fill(&p->rest_gyr, 2, 1e-3, 1000) &&
           fill(&p->rest_acc, 0.5, 1e-3, 1000);
}

// The measurement's variance at which the filter settles at the wanted standard deviation.
static double weight_for(double sigma, double variance_step) {
    double p = 1e4 * sigma * sigma;
    return p * p / variance_step + p;
}

static void clear_covariance(struct ap_vqf *v) {
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            v->covariance[i][j] = i == j ? v->variance_init : 0;
}

bool ap_vqf_init(struct ap_vqf *vqf, const struct ap_vqf_params *params) {
    struct ap_vqf v = {.params = *params};
    if (!fill_all(&v.params))
        return false;
    const struct ap_vqf_params *p = &v.params;
    v.variance_init = 1e4 * p->bias_sigma_init * p->bias_sigma_init;
    v.variance_step = 1e4 * 0.1 * 0.1 * p->period_s / p->bias_forget_s;
    v.weight_motion = weight_for(p->bias_sigma_motion, v.variance_step);
    v.weight_vertical = v.weight_motion / VERTICAL_FORGETTING;
    v.weight_rest = weight_for(p->bias_sigma_rest, v.variance_step);
    clear_covariance(&v);
    ap_vqf_restart(&v);
    *vqf = v;
    return true;
}

void ap_vqf_restart(struct ap_vqf *v) {
    const struct ap_vqf_params *p = &v->params;
    v->gyr = v->tilt = AP_QUAT_IDENTITY;
    ap_lowpass_init(&v->acc_low, 3, p->tau_acc_s, p->period_s);
    ap_lowpass_init(&v->bias_low, 11, p->tau_acc_s, p->period_s);
    ap_lowpass_init(&v->gyr_low, 3, p->rest_tau_s, p->period_s);
    ap_lowpass_init(&v->rest_acc_low, 3, p->rest_tau_s, p->period_s);
    v->rest_s = 0;
    v->rest_gyr = (struct ap_vec3){0, 0, 0};
    v->at_rest = false;
}

static struct ap_vec3 low_pass(struct ap_lowpass *filter, struct ap_vec3 in) {
    double x[3] = {in.x, in.y, in.z};
    ap_lowpass_step(filter, x, x);
    return (struct ap_vec3){x[0], x[1], x[2]};
}

static double square(struct ap_vec3 v) {
    return ap_vec3_dot(v, v);
}

static bool any_beyond(struct ap_vec3 v, double limit) {
    return fabs(v.x) > limit || fabs(v.y) > limit || fabs(v.z) > limit;
}

static void detect_rest(struct ap_vqf *v, struct ap_vec3 gyr, struct ap_vec3 acc, double dt_s) {
    const struct ap_vqf_params *p = &v->params;
    struct ap_vec3 gyr_low = low_pass(&v->gyr_low, gyr), acc_low = low_pass(&v->rest_acc_low, acc);
    double gyr_max = p->rest_gyr * DEGREE;
    v->rest_gyr = gyr_low;
    if (square(ap_vec3_sub(gyr, gyr_low)) >= gyr_max * gyr_max ||
        square(ap_vec3_sub(acc, acc_low)) >= p->rest_acc * p->rest_acc ||
        any_beyond(gyr_low, p->bias_clip * DEGREE))
        v->rest_s = 0;
    else
        v->rest_s = fmin(v->rest_s + dt_s, 1e6);
    v->at_rest = v->rest_s >= p->rest_min_s;
}

static void integrate(struct ap_vqf *v, struct ap_vec3 rate, double dt_s) {
    double size = sqrt(square(rate)), half = size * dt_s / 2;
    double s = size > 0 ? sin(half) / size : 0;
    struct ap_quat step = {s * rate.x, s * rate.y, s * rate.z, cos(half)};
    v->gyr = ap_quat_normalize(ap_quat_mul(v->gyr, step));
}

// Turns the low-passed force's direction to +y the shortest way. Gives the direction before that,
// whose sideways part is what the gyroscope drifted in this step.
static struct ap_vec3 correct_tilt(struct ap_vqf *v, struct ap_vec3 acc) {
    struct ap_vec3 low = low_pass(&v->acc_low, ap_quat_rotate(v->gyr, acc));
    struct ap_vec3 up = ap_quat_rotate(v->tilt, low);
    double size = sqrt(square(up));
    if (!(size > 1e-6))
        return (struct ap_vec3){0, 1, 0};
    up = ap_vec3_scale(1 / size, up);
    double w = sqrt(fmax(0, (up.y + 1) / 2));
    struct ap_quat turn = {1, 0, 0, 0}; // upside down
    if (w > 1e-6)
        turn = (struct ap_quat){-up.z / (2 * w), 0, up.x / (2 * w), w};
    v->tilt = ap_quat_normalize(ap_quat_mul(turn, v->tilt));
    return up;
}

static void matrix_of(double m[3][3], struct ap_quat q) {
    m[0][0] = 1 - 2 * (q.y * q.y + q.z * q.z);
    m[1][1] = 1 - 2 * (q.x * q.x + q.z * q.z);
    m[2][2] = 1 - 2 * (q.x * q.x + q.y * q.y);
    m[0][1] = 2 * (q.x * q.y - q.w * q.z);
    m[1][0] = 2 * (q.x * q.y + q.w * q.z);
    m[0][2] = 2 * (q.x * q.z + q.w * q.y);
    m[2][0] = 2 * (q.x * q.z - q.w * q.y);
    m[1][2] = 2 * (q.y * q.z - q.w * q.x);
    m[2][1] = 2 * (q.y * q.z + q.w * q.x);
}

// The inverse of a symmetric positive definite matrix; false where rounding made it something else.
static bool invert(double out[3][3], double m[3][3]) {
    double c[3] = {m[1][1] * m[2][2] - m[1][2] * m[2][1], m[1][2] * m[2][0] - m[1][0] * m[2][2],
                   m[1][0] * m[2][1] - m[1][1] * m[2][0]};
    double det = m[0][0] * c[0] + m[0][1] * c[1] + m[0][2] * c[2];
    if (!(det > 0) || !isfinite(det))
        return false;
    for (int i = 0; i < 3; i++)
        out[i][0] = c[i] / det;
    out[0][1] = (m[0][2] * m[2][1] - m[0][1] * m[2][2]) / det;
    out[1][1] = (m[0][0] * m[2][2] - m[0][2] * m[2][0]) / det;
    out[2][1] = (m[0][1] * m[2][0] - m[0][0] * m[2][1]) / det;
    out[0][2] = (m[0][1] * m[1][2] - m[0][2] * m[1][1]) / det;
    out[1][2] = (m[0][2] * m[1][0] - m[0][0] * m[1][2]) / det;
    out[2][2] = (m[0][0] * m[1][1] - m[0][1] * m[1][0]) / det;
    return true;
}

// What is seen of the bias in one step: row·bias = its value, with a variance each.
struct sight {
    double rows[3][3];
    double error[3]; // value − row·(bias so far), rad/s
    double weight[3];
};

static double clip(double x, double limit) {
    return fmin(fmax(x, -limit), limit);
}

// The Kalman step: gain K = P·Rᵀ·(W + R·P·Rᵀ)⁻¹, bias += K·error, P −= K·R·P.
static void learn(struct ap_vqf *v, const struct sight *s) {
    double(*p)[3] = v->covariance;
    double rp[3][3] = {{0}}, sum[3][3], inverse[3][3], gain[3][3] = {{0}};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            for (int k = 0; k < 3; k++)
                rp[i][j] += s->rows[i][k] * p[k][j];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            sum[i][j] = i == j ? s->weight[i] : 0;
            for (int k = 0; k < 3; k++)
                sum[i][j] += rp[i][k] * s->rows[j][k];
        }
    if (!invert(inverse, sum)) {
        clear_covariance(v);
        return;
    }
    double limit = v->params.bias_clip * DEGREE, step[3] = {0, 0, 0};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            for (int k = 0; k < 3; k++)
                gain[i][j] += rp[k][i] * inverse[k][j]; // P is symmetric
            step[i] += gain[i][j] * clip(s->error[j], limit);
        }
    for (int i = 0; i < 3; i++)
        for (int j = i; j < 3; j++) {
            for (int k = 0; k < 3; k++)
                p[i][j] -= gain[i][k] * rp[k][j];
            p[j][i] = p[i][j];
        }
    v->bias.x = clip(v->bias.x + step[0], limit);
    v->bias.y = clip(v->bias.y + step[1], limit);
    v->bias.z = clip(v->bias.z + step[2], limit);
}

static void see_rest(const struct ap_vqf *v, struct sight *s) {
    struct ap_vec3 e = ap_vec3_sub(v->rest_gyr, v->bias);
    *s = (struct sight){.error = {e.x, e.y, e.z}};
    for (int i = 0; i < 3; i++) {
        s->rows[i][i] = 1;
        s->weight[i] = v->weight_rest;
    }
}

// In motion: the tilt that had to be corrected in this step came from the bias, seen through the
// same low-pass as the force. About the vertical nothing is seen; a weak pull toward no bias there
// keeps that axis from wandering while the sensor stays level.
static void see_motion(const struct ap_vqf *v, struct ap_vec3 up, double rows[3][3],
                       const double low[11], struct sight *s) {
    double rate = 1 / v->params.period_s;
    const double seen[3] = {up.z * rate + low[9], 0, -up.x * rate + low[10]};
    for (int i = 0; i < 3; i++) {
        double along = 0;
        const double bias[3] = {v->bias.x, v->bias.y, v->bias.z};
        for (int j = 0; j < 3; j++) {
            s->rows[i][j] = rows[i][j];
            along += rows[i][j] * bias[j];
        }
        s->error[i] = seen[i] - along;
        s->weight[i] = i == 1 ? v->weight_vertical : v->weight_motion;
    }
}

static void estimate_bias(struct ap_vqf *v, struct ap_vec3 up) {
    double rows[3][3], low[11];
    matrix_of(rows, ap_vqf_orientation(v));
    for (int i = 0; i < 9; i++)
        low[i] = rows[i / 3][i % 3];
    const struct ap_vec3 *b = &v->bias;
    low[9] = rows[0][0] * b->x + rows[0][1] * b->y + rows[0][2] * b->z;
    low[10] = rows[2][0] * b->x + rows[2][1] * b->y + rows[2][2] * b->z;
    ap_lowpass_step(&v->bias_low, low, low);
    for (int i = 0; i < 9; i++)
        rows[i / 3][i % 3] = low[i];
    for (int i = 0; i < 3; i++)
        if (v->covariance[i][i] < v->variance_init)
            v->covariance[i][i] += v->variance_step;
    struct sight sight;
    if (v->at_rest && !v->params.no_rest_bias)
        see_rest(v, &sight);
    else if (!v->params.no_motion_bias)
        see_motion(v, up, rows, low, &sight);
    else
        return;
    learn(v, &sight);
}

bool ap_vqf_update(struct ap_vqf *v, struct ap_vec3 gyr, struct ap_vec3 acc, double dt_s) {
    // Written so that NaN fails.
    if (!(square(gyr) <= RATE_MAX * RATE_MAX && square(acc) <= FORCE_MAX * FORCE_MAX && dt_s > 0 &&
          dt_s <= DT_MAX)) {
        v->rejected++;
        return false;
    }
    v->accepted++;
    detect_rest(v, gyr, acc, dt_s);
    integrate(v, ap_vec3_sub(gyr, v->bias), dt_s);
    if (square(acc) > 0)
        estimate_bias(v, correct_tilt(v, acc));
    return true;
}

struct ap_quat ap_vqf_orientation(const struct ap_vqf *v) {
    return ap_quat_normalize(ap_quat_mul(v->tilt, v->gyr));
}

struct ap_vec3 ap_vqf_rate(const struct ap_vqf *v, struct ap_vec3 gyr) {
    return ap_vec3_sub(gyr, v->bias);
}

double ap_vqf_bias_sigma(const struct ap_vqf *v) {
    double most = fmax(v->covariance[0][0], fmax(v->covariance[1][1], v->covariance[2][2]));
    return sqrt(fmax(0, most)) / 100 * DEGREE;
}
