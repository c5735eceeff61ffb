#include "tests/device/calibration/noise.h"

#include <string.h>

#include "src/device/calibration/rest.h"
#include "src/device/drivers/fused.h"

static const double DEGREE = M_PI / 180, G = 9.80665;

struct sensor {
    struct ap_rest rest;
    int64_t t_ns;
    struct ap_vec3 gyr_bias, acc_bias;
    double gyr_noise, acc_noise;
};

static struct sensor some_sensor(void) {
    return (struct sensor){.gyr_bias = {0.8 * DEGREE, -0.5 * DEGREE, 0.2 * DEGREE},
                           .acc_bias = {0.12, -0.2, 0.07},
                           .gyr_noise = 0.1 * DEGREE,
                           .acc_noise = 0.02};
}

// So long at 250 Hz, `up` of the sensor upwards, turning by `rate`.
static void measure(struct sensor *s, double seconds, struct ap_vec3 up, struct ap_vec3 rate) {
    struct ap_vec3 force = ap_vec3_add(ap_vec3_scale(G, ap_vec3_normalize(up)), s->acc_bias);
    for (int i = 0; i < (int)(250 * seconds); i++) {
        s->t_ns += 4000000;
        struct ap_vec3 gyr = ap_vec3_add(ap_vec3_add(rate, s->gyr_bias), gauss3(s->gyr_noise));
        assert_true(ap_rest_add(&s->rest, s->t_ns, gyr, ap_vec3_add(force, gauss3(s->acc_noise))));
    }
}

static const struct ap_vec3 still = {0, 0, 0}, y_up = {0, 1, 0};

// The gyroscope's bias from ten seconds: noise/√samples, and the error is what it says.
static void test_gyro_bias(void **state) {
    (void)state;
    double worst = 0, square = 0, said = 0;
    enum { TRIALS = 100 };
    for (int n = 0; n < TRIALS; n++) {
        struct sensor s = some_sensor();
        struct ap_rest_result r;
        measure(&s, 10, y_up, still);
        assert_int_equal(ap_rest_result(NULL, &s.rest, &r), AP_OK);
        struct ap_vec3 off = ap_vec3_sub(r.bias.gyr_rad_s, s.gyr_bias);
        worst = fmax(worst, ap_vec3_length(off));
        square += off.x * off.x / TRIALS;
        said += r.gyr_sigma_rad_s / TRIALS;
        check_near("seconds at rest", r.seconds, 9.5, 0.51);
        assert_int_equal(r.poses, 1);
        // One pose: only the part along up, here y.
        check_near("acc bias along up", r.bias.acc_m_s2.y, s.acc_bias.y, 0.01);
        check_near("acc bias across", r.bias.acc_m_s2.x, 0, 0.01);
    }
    double expected = 0.1 * DEGREE / sqrt(250 * 9.5);
    check_near("standard error over 0.1 deg/s / sqrt(n)", sqrt(square) / expected, 1, 0.25);
    // It says the worst of three axes.
    check_near("what it says of it", said / expected, 1.25, 0.25);
    assert_true(worst < 0.01 * DEGREE);
}

// Six faces tell all three axes of the accelerometer.
static void test_six_faces(void **state) {
    (void)state;
    struct sensor s = some_sensor();
    struct ap_rest_result r;
    for (int face = 0; face < 6; face++) {
        double sign = face % 2 ? -1 : 1;
        struct ap_vec3 up = {face / 2 == 0 ? sign : 0, face / 2 == 1 ? sign : 0,
                             face / 2 == 2 ? sign : 0};
        measure(&s, 3, up, still);
        measure(&s, 1, (struct ap_vec3){1, 1, sign}, (struct ap_vec3){1.5, 0.3, 0});
    }
    assert_int_equal(ap_rest_result(NULL, &s.rest, &r), AP_OK);
    assert_int_equal(r.poses, 6);
    check_near("acc x", r.bias.acc_m_s2.x, s.acc_bias.x, 0.003);
    check_near("acc y", r.bias.acc_m_s2.y, s.acc_bias.y, 0.003);
    check_near("acc z", r.bias.acc_m_s2.z, s.acc_bias.z, 0.003);
    check_near("gyro x", r.bias.gyr_rad_s.x, s.gyr_bias.x, 0.01 * DEGREE);
}

static void refuse(struct sensor *s, const char *what) {
    struct ap_error err = {""};
    struct ap_rest_result r = {.poses = -1};
    assert_int_equal(ap_rest_result(&err, &s->rest, &r), AP_INPUT);
    if (!strstr(err.text, what))
        fail_msg("'%s' says nothing of '%s'", err.text, what);
    assert_int_equal(r.poses, -1);
}

static void test_motion_is_refused(void **state) {
    (void)state;
    struct sensor s = some_sensor();
    refuse(&s, "no measurements");
    measure(&s, 1.5, y_up, still); // too short
    refuse(&s, "two seconds");
    s = some_sensor();
    measure(&s, 10, y_up, (struct ap_vec3){0, 0.2, 0});
    refuse(&s, "turned steadily");
    s = some_sensor();
    s.gyr_noise = 2 * DEGREE; // in a hand
    measure(&s, 10, y_up, still);
    refuse(&s, "being turned");
    s = some_sensor();
    s.acc_noise = 1; // in a car
    measure(&s, 10, y_up, still);
    refuse(&s, "shaken");
    s = some_sensor();
    s.acc_bias.y = 3;
    measure(&s, 10, y_up, still);
    refuse(&s, "gravity");
    s = some_sensor();
    for (int i = 0; i < 100; i++) { // tilting by 1.5 degrees a second, in steps below noise
        double a = 0.4 * DEGREE * i;
        measure(&s, 0.25, (struct ap_vec3){sin(2 * a), cos(2 * a), 0}, still);
    }
    refuse(&s, "turned slowly");
}

static void test_hostile(void **state) {
    (void)state;
    struct ap_rest rest;
    memset(&rest, 0, sizeof rest);
    struct ap_vec3 up = {0, G, 0}, nan3 = {NAN, 0, 0};
    assert_false(ap_rest_add(&rest, INT64_MIN, still, up));
    assert_true(ap_rest_add(&rest, 5, still, up));
    assert_false(ap_rest_add(&rest, 5, still, up));
    assert_false(ap_rest_add(&rest, 4, still, up));
    assert_false(ap_rest_add(&rest, 6, nan3, up));
    assert_false(ap_rest_add(&rest, 6, still, nan3));
    // A gap of a day, and times at the ends of the range.
    assert_true(ap_rest_add(&rest, 86400000000000, still, up));
    assert_false(ap_rest_add(&rest, INT64_MAX, still, up));
    assert_true(ap_rest_add(&rest, INT64_MAX / 4, still, up));
    assert_int_equal(ap_rest_result(NULL, &rest, &(struct ap_rest_result){.poses = 0}), AP_INPUT);
}

// A device that drifts by its bias does not once the bias is known.
static void test_applied(void **state) {
    (void)state;
    const struct ap_imu_params params = {
        .period_s = 0.004, .bits = 64, .tick_ns_num = 1, .tick_ns_den = 1};
    double turned[2];
    for (int known = 0; known < 2; known++) {
        struct ap_imu imu;
        struct ap_vec3 bias = {0, 3 * DEGREE, 0}; // over what the filter allows for
        struct ap_driver_samples samples = {.count = 0};
        assert_true(ap_imu_init(&imu, &params));
        if (known)
            imu.bias.gyr_rad_s = bias;
        struct ap_driver_sample *last = NULL;
        for (uint64_t i = 0; i < 2500; i++) {
            samples.count = 0;
            last = ap_driver_add_fused(&samples, &imu, 1 + i * 4000000, bias,
                                       (struct ap_vec3){0, G, 0});
            assert_non_null(last);
            assert_true(last->has_imu && last->gyro_rad_s.y == bias.y);
        }
        turned[known] = 2 * atan2(fabs(last->pose.q.y), fabs(last->pose.q.w));
    }
    assert_true(turned[0] > 5 * DEGREE);
    check_near("turned with the bias known", turned[1], 0, 1e-9);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_gyro_bias),         cmocka_unit_test(test_six_faces),
        cmocka_unit_test(test_motion_is_refused), cmocka_unit_test(test_hostile),
        cmocka_unit_test(test_applied),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
