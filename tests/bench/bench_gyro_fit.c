#include <stdio.h>
#include <stdlib.h>

#include "src/device/fusion/vqf.h"
#include "tests/device/fusion/broad.h"

// Where the heading drift in the BROAD recordings comes from: the gyroscope's axes and scales are
// fitted to the optical reference over the first 34 s (a 3×3 matrix and a bias, by least squares
// over turns of 60 samples), and VQF's errors are taken in the rest, with and without that matrix.
// CSV on standard output. The reference is read a sample late, as the fast recording has it
// (docs/fusion.md). The folder with the recordings is the argument, or data/imu of
// $ANTIPODE_SHARED.

enum { UNKNOWNS = 12, WINDOW = 60, ROUNDS = 4, LATE = 1 };

static const double SPLIT_S = 34;

struct fit {
    double matrix[3][3]; // what is added: rate + matrix·rate − bias
    double bias[3];
};

struct sums {
    double a[UNKNOWNS][UNKNOWNS + 1];
};

static struct ap_vec3 corrected(const struct fit *f, struct ap_vec3 w) {
    const double v[3] = {w.x, w.y, w.z};
    double out[3];
    for (int i = 0; i < 3; i++)
        out[i] = v[i] - f->bias[i] + f->matrix[i][0] * v[0] + f->matrix[i][1] * v[1] +
                 f->matrix[i][2] * v[2];
    return (struct ap_vec3){out[0], out[1], out[2]};
}

static struct ap_quat turn_of(struct ap_vec3 rate) {
    double size = ap_vec3_length(rate);
    return size > 0 ? ap_quat_from_axis_angle(ap_vec3_scale(1 / size, rate), size * BROAD_PERIOD_S)
                    : AP_QUAT_IDENTITY;
}

static struct ap_vec3 rotation_vector(struct ap_quat q) {
    double sign = q.w < 0 ? -1 : 1, sine = sqrt(q.x * q.x + q.y * q.y + q.z * q.z);
    double k = sine > 1e-9 ? 2 * atan2(sine, fabs(q.w)) / sine : 2;
    return (struct ap_vec3){sign * k * q.x, sign * k * q.y, sign * k * q.z};
}

static bool is_known(struct ap_quat q) {
    return isfinite(q.x + q.y + q.z + q.w);
}

// One window's equations: by how much the measured turn misses the reference's, and what each
// unknown would change of it.
static void add_window(struct sums *s, const struct fit *f, const struct broad_row *rows) {
    struct ap_quat from = rows[-LATE].truth, to = rows[WINDOW - LATE].truth;
    if (!is_known(from) || !is_known(to))
        return;
    struct ap_quat turns[WINDOW], turned = AP_QUAT_IDENTITY;
    for (int k = 0; k < WINDOW; k++)
        turns[k] = turned = ap_quat_mul(turned, turn_of(corrected(f, rows[k + 1].gyr)));
    struct ap_vec3 miss =
        rotation_vector(ap_quat_mul(ap_quat_conj(turned), ap_quat_mul(ap_quat_conj(from), to)));
    if (ap_vec3_length(miss) > 0.2) // a marker was taken for another
        return;
    double j[3][UNKNOWNS] = {{0}};
    for (int k = 0; k < WINDOW; k++) {
        struct ap_quat later = ap_quat_mul(ap_quat_conj(turned), turns[k]);
        const struct ap_vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, w = rows[k + 1].gyr;
        for (int i = 0; i < 3; i++) {
            struct ap_vec3 seen = ap_vec3_scale(BROAD_PERIOD_S, ap_quat_rotate(later, axes[i]));
            const double at[3] = {seen.x, seen.y, seen.z}, rate[4] = {w.x, w.y, w.z, -1};
            for (int m = 0; m < 3; m++)
                for (int c = 0; c < 4; c++)
                    j[m][c < 3 ? 3 * i + c : 9 + i] += at[m] * rate[c];
        }
    }
    const double e[3] = {miss.x, miss.y, miss.z};
    for (int m = 0; m < 3; m++)
        for (int r = 0; r < UNKNOWNS; r++) {
            for (int c = 0; c < UNKNOWNS; c++)
                s->a[r][c] += j[m][r] * j[m][c];
            s->a[r][UNKNOWNS] += j[m][r] * e[m];
        }
}

// Symmetric and positive definite, so no pivoting.
static void solve(struct sums *s, double x[UNKNOWNS]) {
    for (int i = 0; i < UNKNOWNS; i++)
        for (int r = 0; r < UNKNOWNS; r++) {
            double k = r == i ? 0 : s->a[r][i] / s->a[i][i];
            for (int c = i; c <= UNKNOWNS; c++)
                s->a[r][c] -= k * s->a[i][c];
        }
    for (int i = 0; i < UNKNOWNS; i++)
        x[i] = s->a[i][UNKNOWNS] / s->a[i][i];
}

static struct fit find_fit(const struct broad_row *rows, size_t count) {
    struct fit f = {.bias = {0}};
    for (int round = 0; round < ROUNDS; round++) {
        struct sums s = {.a = {{0}}};
        for (size_t i = LATE; i + WINDOW < count && rows[i].t_s < SPLIT_S; i += WINDOW / 2)
            add_window(&s, &f, &rows[i]);
        double x[UNKNOWNS];
        solve(&s, x);
        for (int i = 0; i < 3; i++) {
            for (int c = 0; c < 3; c++)
                f.matrix[i][c] += x[3 * i + c];
            f.bias[i] += x[9 + i];
        }
    }
    return f;
}

// VQF finds the bias by itself, so only the matrix is used.
static void run(const char *name, const char *what, struct fit f, const struct broad_row *rows,
                size_t count) {
    struct ap_vqf vqf;
    if (!ap_vqf_init(&vqf, &(struct ap_vqf_params){.period_s = BROAD_PERIOD_S}))
        abort();
    struct broad_errors errors = {0};
    f.bias[0] = f.bias[1] = f.bias[2] = 0;
    for (size_t i = 0; i < count; i++) {
        ap_vqf_update(&vqf, corrected(&f, rows[i].gyr), rows[i].acc, BROAD_PERIOD_S);
        if (i && rows[i].t_s >= SPLIT_S && rows[i - 1].t_s < SPLIT_S) // from here on
            errors.n = errors.t = errors.tt = errors.h = errors.th = errors.inclination2 =
                errors.total2 = errors.moving = 0;
        broad_add(&errors, &rows[i >= LATE ? i - LATE : 0], ap_vqf_orientation(&vqf));
    }
    printf("%s,%s,%.3f,%.2f\n", name, what, broad_inclination_deg(&errors),
           broad_drift_deg_min(&errors));
}

int main(int argc, char **argv) {
    static const char *const files[] = {"broad_05_60s", "broad_21_60s"};
    const char *shared = getenv("ANTIPODE_SHARED");
    if (argc < 2 && !shared) {
        printf("skipped: ANTIPODE_SHARED is not set, and no folder was given\n");
        return 77;
    }
    printf("recording,gyroscope,inclination_rms_deg,drift_deg_min\n");
    for (int i = 0; i < 2; i++) {
        char path[1024];
        snprintf(path, sizeof path, "%s/%s%s.csv", argc > 1 ? argv[1] : shared,
                 argc > 1 ? "" : "data/imu/", files[i]);
        size_t count = 0;
        struct broad_row *rows = broad_read(path, &count);
        if (!rows || count < 2 * WINDOW) {
            fprintf(stderr, "%s: cannot be read\n", path);
            return 1;
        }
        struct fit f = find_fit(rows, count);
        run(files[i], "as it is", (struct fit){.bias = {0}}, rows, count);
        run(files[i], "fitted before", f, rows, count);
        for (int r = 0; r < 3; r++)
            printf("# %s percent: %7.3f %7.3f %7.3f\n", files[i], 100 * f.matrix[r][0],
                   100 * f.matrix[r][1], 100 * f.matrix[r][2]);
        free(rows);
    }
    return 0;
}
