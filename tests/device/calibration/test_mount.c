#include "tests/device/calibration/noise.h"

#include <string.h>

#include "src/device/calibration/mount.h"

static const double DEGREE = M_PI / 180;
static const struct ap_vec3 x_axis = {1, 0, 0}, y_axis = {0, 1, 0};

static struct ap_quat random_quat(void) {
    struct ap_vec3 axis = ap_vec3_normalize(gauss3(1));
    return ap_quat_from_axis_angle(axis, 2 * M_PI * uniform());
}

struct wearer {
    struct ap_quat tracker_from_body;
    double heading_rad, nod_rad, noise_rad;
    struct ap_vec3 about; // of the body: −x is down
};

// Two seconds level at 100 Hz, then down and up again.
static void wear(struct ap_mount *mount, const struct wearer *w) {
    struct ap_quat heading = ap_quat_from_axis_angle(y_axis, w->heading_rad);
    memset(mount, 0, sizeof *mount);
    for (int i = 0; i < 500; i++) {
        double down = i < 200 ? 0 : w->nod_rad * sin(2 * M_PI * (i - 200) / 300);
        struct ap_quat body = ap_quat_mul(heading, ap_quat_from_axis_angle(w->about, down));
        struct ap_vec3 jitter = gauss3(w->noise_rad);
        double angle = ap_vec3_length(jitter);
        if (angle > 0)
            body = ap_quat_mul(body, ap_quat_from_axis_angle(ap_vec3_normalize(jitter), angle));
        ap_mount_add(mount, (int64_t)i * 10000000,
                     ap_quat_mul(body, ap_quat_conj(w->tracker_from_body)));
    }
}

static double angle_between(struct ap_quat a, struct ap_quat b) {
    struct ap_quat d = ap_quat_mul(ap_quat_conj(a), b);
    return 2 * atan2(sqrt(d.x * d.x + d.y * d.y + d.z * d.z), fabs(d.w));
}

static void test_exact(void **state) {
    (void)state;
    for (int n = 0; n < 500; n++) {
        struct ap_mount mount;
        struct ap_mount_result result;
        struct ap_error err = {""};
        struct wearer w = {.tracker_from_body = random_quat(),
                           .heading_rad = 2 * M_PI * uniform(),
                           .nod_rad = (20 + 40 * uniform()) * DEGREE,
                           .about = {-1, 0, 0}};
        wear(&mount, &w);
        assert_true(ap_mount_is_level(&mount));
        if (ap_mount_result(&err, &mount, &result))
            fail_msg("%s", err.text);
        check_near("off the truth", angle_between(result.tracker_from_body, w.tracker_from_body), 0,
                   1e-7);
        check_near("nod", result.nod_rad, w.nod_rad, 0.01);
    }
}

// Jitter of half a degree in every sample: the mount comes out to a fifth of that.
static void test_noise(void **state) {
    (void)state;
    double square = 0;
    enum { TRIALS = 200 };
    for (int n = 0; n < TRIALS; n++) {
        struct ap_mount mount;
        struct ap_mount_result result;
        struct wearer w = {.tracker_from_body = random_quat(),
                           .nod_rad = 30 * DEGREE,
                           .noise_rad = 0.3 * DEGREE,
                           .about = {-1, 0, 0}};
        wear(&mount, &w);
        assert_int_equal(ap_mount_result(NULL, &mount, &result), AP_OK);
        square += pow(angle_between(result.tracker_from_body, w.tracker_from_body), 2) / TRIALS;
    }
    check_near("degrees off, rms", sqrt(square) / DEGREE, 0, 0.15);
}

static void refuse(const struct wearer *w, const char *what) {
    struct ap_mount mount;
    struct ap_error err = {""};
    struct ap_mount_result result = {.nod_rad = -1};
    wear(&mount, w);
    assert_int_equal(ap_mount_result(&err, &mount, &result), AP_INPUT);
    if (!strstr(err.text, what))
        fail_msg("'%s' says nothing of '%s'", err.text, what);
    assert_true(result.nod_rad == -1);
}

static void test_refused(void **state) {
    (void)state;
    const struct ap_quat q = random_quat();
    refuse(&(struct wearer){.tracker_from_body = q, .nod_rad = 0.1, .about = x_axis},
           "a nod of 6 degrees");
    refuse(&(struct wearer){.tracker_from_body = q, .nod_rad = 0.5, .about = y_axis}, "straight");
    refuse(&(struct wearer){.tracker_from_body = q,
                            .nod_rad = 0.5,
                            .about = ap_vec3_normalize((struct ap_vec3){-1, 1, 0})},
           "45 degrees off level");
    refuse(
        &(struct wearer){
            .tracker_from_body = q, .nod_rad = 0.5, .about = {-1, 0, 0}, .noise_rad = 2 * DEGREE},
        "hold still");
    struct ap_mount nothing = {.started = false};
    assert_int_equal(ap_mount_result(NULL, &nothing, &(struct ap_mount_result){.nod_rad = 0}),
                     AP_INPUT);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact),
        cmocka_unit_test(test_noise),
        cmocka_unit_test(test_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
