#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "src/base/clock.h"
#include "src/device/fusion/vqf.h"
#include "tests/device/fusion/broad.h"

// VQF against the usual filters on the two BROAD recordings: inclination and total error (RMS while
// moving), as recorded and with the two clocks in step (broad_lag_s), heading drift, nanoseconds a
// sample. CSV on standard output. The folder with the
// recordings is the argument, or data/imu of $ANTIPODE_SHARED.

enum kind { GYRO, COMPLEMENTARY, MAHONY, MAHONY_INTEGRAL, VQF_NO_BIAS, VQF_REST, VQF };
static const char *const names[] = {"gyro only",
                                    "complementary 1 s",
                                    "Mahony kp 0.5",
                                    "Mahony kp 0.5 ki 0.01",
                                    "VQF without bias",
                                    "VQF rest bias only",
                                    "VQF"};

struct filter {
    enum kind kind;
    struct ap_vqf vqf;
    struct ap_quat q; // of the plain ones
    struct ap_vec3 integral;
    bool started;
};

static void turn(struct filter *f, struct ap_vec3 rate, double dt_s) {
    double size = ap_vec3_length(rate);
    if (size > 0)
        f->q = ap_quat_normalize(
            ap_quat_mul(f->q, ap_quat_from_axis_angle(ap_vec3_scale(1 / size, rate), size * dt_s)));
}

// The rotation vector, in sensor axes, by which the estimated up is off the measured one.
static struct ap_vec3 off_up(const struct filter *f, struct ap_vec3 acc) {
    struct ap_vec3 up = ap_quat_rotate(ap_quat_conj(f->q), (struct ap_vec3){0, 1, 0});
    return ap_vec3_cross(ap_vec3_normalize(acc), up);
}

static void step(struct filter *f, const struct broad_row *row) {
    if (f->kind >= VQF_NO_BIAS) {
        ap_vqf_update(&f->vqf, row->gyr, row->acc, BROAD_PERIOD_S);
        return;
    }
    if (!f->started) { // level at once
        struct ap_vec3 axis = ap_vec3_cross(row->acc, (struct ap_vec3){0, 1, 0});
        double angle = atan2(ap_vec3_length(axis), row->acc.y);
        f->q = ap_quat_from_axis_angle(ap_vec3_normalize(axis), angle);
        f->started = true;
    }
    struct ap_vec3 rate = row->gyr, off = off_up(f, row->acc);
    if (f->kind == COMPLEMENTARY)
        rate = ap_vec3_add(rate, off);
    if (f->kind == MAHONY || f->kind == MAHONY_INTEGRAL) {
        double ki = f->kind == MAHONY ? 0 : 0.01;
        f->integral = ap_vec3_add(f->integral, ap_vec3_scale(ki * BROAD_PERIOD_S, off));
        rate = ap_vec3_add(rate, ap_vec3_add(ap_vec3_scale(0.5, off), f->integral));
    }
    turn(f, rate, BROAD_PERIOD_S);
}

static struct filter start(enum kind kind) {
    struct filter f = {.kind = kind, .q = AP_QUAT_IDENTITY};
    struct ap_vqf_params params = {.period_s = BROAD_PERIOD_S,
                                   .no_motion_bias = kind == VQF_NO_BIAS || kind == VQF_REST,
                                   .no_rest_bias = kind == VQF_NO_BIAS};
    if (!ap_vqf_init(&f.vqf, &params))
        abort();
    return f;
}

static struct ap_quat orientation(const struct filter *f) {
    return f->kind >= VQF_NO_BIAS ? ap_vqf_orientation(&f->vqf) : f->q;
}

static void run(const char *name, enum kind kind, const struct broad_row *rows, size_t count) {
    struct broad_errors errors = {0}, in_step = {0};
    struct filter f = start(kind);
    double lag_s = broad_lag_s(rows, count);
    for (size_t i = 0; i < count; i++) {
        struct broad_row row = broad_in_step(rows, i, lag_s);
        step(&f, &rows[i]);
        broad_add(&errors, &rows[i], orientation(&f));
        broad_add(&in_step, &row, orientation(&f));
    }
    int64_t best = INT64_MAX;
    for (int round = 0; round < 5; round++) {
        f = start(kind);
        int64_t begin = ap_clock_now_ns();
        for (size_t i = 0; i < count; i++)
            step(&f, &rows[i]);
        int64_t took = ap_clock_now_ns() - begin;
        best = took < best ? took : best;
    }
    printf("%s,%s,%.3f,%.2f,%.3f,%.2f,%.2f,%.0f\n", name, names[kind],
           broad_inclination_deg(&errors), broad_total_deg(&errors),
           broad_inclination_deg(&in_step), broad_total_deg(&in_step), broad_drift_deg_min(&errors),
           (double)best / (double)count);
}

int main(int argc, char **argv) {
    static const char *const files[] = {"broad_05_60s", "broad_21_60s"};
    const char *shared = getenv("ANTIPODE_SHARED");
    if (argc < 2 && !shared) {
        printf("skipped: ANTIPODE_SHARED is not set, and no folder was given\n");
        return 77;
    }
    printf("recording,filter,inclination_rms_deg,total_rms_deg,inclination_in_step_deg,"
           "total_in_step_deg,drift_deg_min,ns_per_sample\n");
    for (int i = 0; i < 2; i++) {
        char path[1024];
        snprintf(path, sizeof path, "%s/%s%s.csv", argc > 1 ? argv[1] : shared,
                 argc > 1 ? "" : "data/imu/", files[i]);
        size_t count = 0;
        struct broad_row *rows = broad_read(path, &count);
        if (!rows || !count) {
            fprintf(stderr, "%s: cannot be read\n", path);
            return 1;
        }
        for (enum kind kind = GYRO; kind <= VQF; kind++)
            run(files[i], kind, rows, count);
        free(rows);
    }
    return 0;
}
