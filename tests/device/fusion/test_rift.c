#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "src/device/drivers/rift/rift.h"

// Reports are written here bit by bit, as text of zeros and ones, and read by the driver.

static struct ap_device_info info;
static struct ap_driver_samples samples;
static union {
    max_align_t align;
    unsigned char bytes[AP_DRIVER_STATE_MAX];
} state;

static const struct ap_driver *plug(uint16_t product) {
    memset(&info, 0, sizeof info);
    memset(&state, 0, sizeof state);
    info.bus = 3;
    info.vendor = 0x2833;
    info.product = product;
    const struct ap_driver *driver = ap_driver_find(&info);
    if (driver)
        driver->init(&state, &info);
    return driver;
}

static void close_to(const char *what, double got, double want, double tolerance) {
    if (!(fabs(got - want) <= tolerance))
        fail_msg("%s: %.12g, expected %.12g, tolerance %g", what, got, want, tolerance);
}

// Three numbers as 63 binary digits and a spare one.
static void put_triple(uint8_t *bytes, const double v[3]) {
    char digits[65] = "";
    for (int i = 0; i < 3; i++) {
        long raw = lround(v[i] * 1e4);
        for (int bit = 20; bit >= 0; bit--)
            strcat(digits, (raw + (raw < 0 ? 2097152 : 0)) >> bit & 1 ? "1" : "0");
    }
    strcat(digits, "0");
    for (int i = 0; i < 8; i++) {
        char byte[9];
        memcpy(byte, digits + 8 * i, 8);
        byte[8] = 0;
        bytes[i] = (uint8_t)strtoul(byte, NULL, 2);
    }
}

struct model {
    uint16_t product;
    uint8_t id;
    size_t len, count_at, ticks_at, ticks_bytes, first_at;
    int measurements;
    uint32_t ticks_per_ms;
};

static const struct model models[] = {{0x0001, 1, 62, 1, 2, 2, 8, 3, 1},
                                      {0x0021, 11, 64, 3, 8, 4, 12, 2, 1000},
                                      {0x2021, 11, 64, 3, 8, 4, 12, 2, 1000},
                                      {0x0031, 11, 64, 3, 8, 4, 12, 2, 1000}};

enum { MODELS = sizeof models / sizeof *models };

// Measurements up to this millisecond: turned about the vertical at `rate`, upright.
static void make(uint8_t *b, const struct model *m, uint32_t ms, int count, double rate) {
    memset(b, 0, m->len);
    b[0] = m->id;
    b[m->count_at] = (uint8_t)count;
    uint32_t ticks = ms * m->ticks_per_ms;
    for (size_t i = 0; i < m->ticks_bytes; i++)
        b[m->ticks_at + i] = (uint8_t)(ticks / (1u << 8 * i) % 256);
    for (int i = 0; i < m->measurements; i++) {
        put_triple(b + m->first_at + 16 * (size_t)i, (const double[3]){0, 9.81, 0});
        put_triple(b + m->first_at + 16 * (size_t)i + 8, (const double[3]){0, rate, 0});
    }
}

static enum ap_report_verdict feed(const struct ap_driver *driver, const uint8_t *bytes,
                                   size_t len) {
    samples.count = 0;
    samples.why[0] = 0;
    return driver->parse(&state, &info, 0, bytes, len, &samples);
}

static void test_triples(void **unused) {
    (void)unused;
    static const double values[][3] = {{0, 0, 0},
                                       {1e-4, -1e-4, 2e-4},
                                       {104.8575, -104.8576, 104.8575},
                                       {-104.8576, 104.8575, -104.8576},
                                       {12.3456, -65.4321, 9.8067}};
    for (size_t i = 0; i < sizeof values / sizeof *values; i++) {
        uint8_t bytes[8];
        put_triple(bytes, values[i]);
        struct ap_vec3 v = ap_rift_triple(bytes);
        close_to("x", v.x, values[i][0], 1e-12);
        close_to("y", v.y, values[i][1], 1e-12);
        close_to("z", v.z, values[i][2], 1e-12);
    }
}

// A second of turning, reports now and then lost: the counter says for how long, through its end.
static void test_turning(void **unused) {
    (void)unused;
    for (int k = 0; k < MODELS; k++) {
        const struct model *m = &models[k];
        const struct ap_driver *driver = plug(m->product);
        assert_ptr_equal(driver, &ap_driver_rift);
        uint8_t b[64];
        uint32_t first = m->ticks_bytes == 2 ? 65536 - 300 : UINT32_MAX / 1000 - 300, ms = first;
        double rate = 0;
        int rows = 0;
        struct ap_quat before = AP_QUAT_IDENTITY;
        double turned = 0;
        for (int i = 0; i < 600; i++, ms += (uint32_t)m->measurements) {
            rate = i > 20 ? 1.5 : 0;
            if (i % 50 == 49)
                continue; // lost
            make(b, m, ms, m->measurements, rate);
            assert_int_equal(feed(driver, b, m->len), AP_REPORT_OK);
            assert_int_equal(samples.count, 1);
            assert_true(samples.at[0].reset == (i == 0) && samples.at[0].has_rate);
            assert_int_equal(samples.at[0].kind, AP_SAMPLE_ORIENTATION);
            struct ap_quat d = ap_quat_mul(ap_quat_conj(before), samples.at[0].pose.q);
            turned += i ? 2 * atan2(d.y, d.w) : 0;
            before = samples.at[0].pose.q;
            rows++;
        }
        // From sample 20 on, and what was lost lies between two that turned alike.
        close_to("turned, rad", turned, 1.5e-3 * m->measurements * (599 - 20 - 1), 2e-3);
        assert_int_equal(rows, 588);
        // Once more the same, then one before it, then one of half a minute later.
        assert_int_equal(feed(driver, b, m->len), AP_REPORT_IGNORED);
        make(b, m, ms - 40, m->measurements, rate);
        assert_int_equal(feed(driver, b, m->len), AP_REPORT_IGNORED);
        make(b, m, ms + 30000, m->measurements, rate);
        assert_int_equal(feed(driver, b, m->len), AP_REPORT_OK);
        assert_true(samples.at[0].reset);
    }
}

// What was found at rest is taken away.
static void test_bias(void **unused) {
    (void)unused;
    for (int k = 0; k < MODELS; k++) {
        const struct model *m = &models[k];
        const struct ap_driver *driver = plug(m->product);
        info.bias.gyr_rad_s = (struct ap_vec3){0, 0.25, 0};
        driver->init(&state, &info);
        uint8_t b[64];
        for (uint32_t i = 0; i < 100; i++) {
            make(b, m, i * (uint32_t)m->measurements, m->measurements, 0.25);
            assert_int_equal(feed(driver, b, m->len), AP_REPORT_OK);
        }
        close_to("turned", samples.at[0].pose.q.y, 0, 1e-9);
        close_to("rate", samples.at[0].angular_velocity_rad_s.y, 0, 1e-9);
    }
}

static void test_bad(void **unused) {
    (void)unused;
    for (int k = 0; k < MODELS; k++) {
        const struct model *m = &models[k];
        const struct ap_driver *driver = plug(m->product);
        uint8_t b[64];
        make(b, m, 5, m->measurements, 0);
        for (size_t len = 0; len < m->len; len++) {
            assert_int_equal(feed(driver, b, len), AP_REPORT_BAD);
            assert_non_null(strstr(samples.why, "bytes with a measurement"));
        }
        make(b, m, 5, 0, 0);
        assert_int_equal(feed(driver, b, m->len), AP_REPORT_BAD);
        make(b, m, 5, 255, 0); // more than fit: those that are there
        assert_int_equal(feed(driver, b, m->len), AP_REPORT_OK);
        b[0] = 12; // a controller's
        assert_int_equal(feed(driver, b, m->len), AP_REPORT_IGNORED);
    }
    assert_null(plug(0x0002));
    plug(0x0031);
    info.interface_known = true;
    assert_ptr_equal(ap_driver_find(&info), &ap_driver_rift);
    info.interface_number = 1; // its controllers' radio
    assert_null(ap_driver_find(&info));
}

static void test_start(void **unused) {
    (void)unused;
    struct ap_driver_step steps[AP_DRIVER_STEPS_MAX];
    const struct ap_driver *driver = plug(0x0031);
    info.feature_count = 1;
    info.features[0] = (struct ap_feature_report){7, {2, 0x11, 0x22, 0x63, 5, 1, 2}};
    int n = driver->start(&info, steps);
    assert_int_equal(n, 3);
    static const uint8_t config[] = {2, 0x11, 0x22, 0x2f, 5, 0x10, 0x27},
                         components[] = {0x1d, 0, 0, 7}, alive[] = {8, 0, 0, 0x10, 0x27};
    assert_memory_equal(steps[0].bytes, config, sizeof config);
    assert_memory_equal(steps[1].bytes, components, sizeof components);
    assert_memory_equal(steps[2].bytes, alive, sizeof alive);
    for (int i = 0; i < n; i++)
        assert_int_equal(steps[i].kind, AP_STEP_SET_FEATURE);
    assert_int_equal(steps[2].len, 5);
    assert_in_range(steps[2].repeat_ms, 1, 9000); // well before the ten seconds are over
    plug(0x0001);
    assert_int_equal(driver->start(&info, steps), 2);
    assert_int_equal(steps[0].bytes[3], 0x0c);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_triples),
                                       cmocka_unit_test(test_turning), cmocka_unit_test(test_bias),
                                       cmocka_unit_test(test_bad), cmocka_unit_test(test_start)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
