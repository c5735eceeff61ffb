#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "src/device/drivers/joycon/joycon.h"
#include "src/device/hid/recording.h"

static const double DEGREE = 3.14159265358979323846 / 180;

static struct ap_device_info info;
static struct ap_driver_samples samples;
static union {
    max_align_t align;
    unsigned char bytes[AP_DRIVER_STATE_MAX];
} state;

static const struct ap_driver *plug(uint16_t bus, uint16_t product) {
    info.bus = bus;
    info.vendor = 0x057e;
    info.product = product;
    memset(&state, 0, sizeof state);
    const struct ap_driver *driver = ap_driver_find(&info);
    if (driver)
        driver->init(&state, &info);
    return driver;
}

static void close_to(const char *what, double got, double want, double tolerance) {
    if (!(fabs(got - want) <= tolerance))
        fail_msg("%s: %.12g, expected %.12g, tolerance %g", what, got, want, tolerance);
}

static void check_vec(const char *what, struct ap_vec3 got, double x, double y, double z) {
    close_to(what, ap_vec3_length(ap_vec3_sub(got, (struct ap_vec3){x, y, z})), 0, 1e-9);
}

static void put16(uint8_t *b, int v) {
    b[0] = (uint8_t)(v & 255);
    b[1] = (uint8_t)(v >> 8 & 255);
}

// The same measurement three times.
static void make(uint8_t b[AP_JOYCON_REPORT], uint8_t timer, const int accel[3],
                 const int gyro[3]) {
    memset(b, 0, AP_JOYCON_REPORT);
    b[0] = 0x30;
    b[1] = timer;
    for (size_t i = 0; i < 3; i++)
        for (size_t k = 0; k < 3; k++) {
            put16(b + 13 + 12 * i + 2 * k, accel[k]);
            put16(b + 19 + 12 * i + 2 * k, gyro[k]);
        }
}

static void test_packet(void **unused) {
    (void)unused;
    uint8_t b[AP_JOYCON_REPORT];
    make(b, 200, (const int[]){4096, 8192, -4096}, (const int[]){1000, -2000, 3000});
    b[2] = 0x60; // three quarters full
    b[3] = 0x08; // A
    b[5] = 0x80; // ZL
    struct ap_joycon_calibration c = ap_joycon_usual_calibration();
    struct ap_joycon_packet p;
    assert_int_equal(ap_joycon_parse(ap_joycon_ids[0].model, &c, b, sizeof b, &p), AP_REPORT_OK);
    const double g = 9.80665, w = 70 * DEGREE;
    for (int i = 0; i < 3; i++) {
        check_vec("left, forces", p.at[i].acc_m_s2, -2 * g, -g, -g);
        check_vec("left, rates", p.at[i].gyr_rad_s, 2 * w, 3 * w, -w);
    }
    assert_int_equal(p.at[0].ticks, 200);
    assert_int_equal(p.at[2].ticks, 202);
    close_to("battery", p.battery, 0.75, 0);
    assert_true(p.trigger && !(p.buttons & 1));
    assert_int_equal(ap_joycon_parse(ap_joycon_ids[1].model, &c, b, sizeof b, &p), AP_REPORT_OK);
    check_vec("right, forces", p.at[2].acc_m_s2, 2 * g, g, -g);
    check_vec("right, rates", p.at[2].gyr_rad_s, -2 * w, -3 * w, -w);
    assert_true(p.buttons & 1);
    for (size_t len = 0; len < sizeof b; len++)
        assert_int_equal(ap_joycon_parse(ap_joycon_ids[2].model, &c, b, len, &p), AP_REPORT_BAD);
    b[0] = 0x3f;
    assert_int_equal(ap_joycon_parse(ap_joycon_ids[2].model, &c, b, sizeof b, &p),
                     AP_REPORT_IGNORED);
}

static void test_calibration(void **unused) {
    (void)unused;
    uint8_t b[49] = {0x21};
    b[13] = 0x90;
    b[14] = 0x10;
    put16(b + 15, 0x6020);
    b[19] = 24;
    for (size_t k = 0; k < 3; k++) {
        put16(b + 26 + 2 * k, 16384);
        put16(b + 32 + 2 * k, 10 * ((int)k + 1));
        put16(b + 38 + 2 * k, 13371);
    }
    struct ap_joycon_calibration c = {.is_users = false};
    assert_true(ap_joycon_read_calibration(b, sizeof b, &c));
    close_to("scale of forces", c.accel_scale[1], 9.80665 / 4096, 1e-12);
    close_to("bias", c.gyro_bias[2], 30, 0);
    close_to("scale of rates", c.gyro_scale[0], 936 * DEGREE / 13361, 1e-12);
    struct ap_joycon_calibration before = c;
    for (size_t len = 0; len < 44; len++)
        assert_false(ap_joycon_read_calibration(b, len, &c));
    memset(b + 20, 0xff, 24); // an empty flash
    assert_false(ap_joycon_read_calibration(b, sizeof b, &c));
    assert_memory_equal(&c, &before, sizeof c);
    // The user's own, whose first two bytes say that it is one; then the maker's does not count.
    uint8_t users[49] = {0x21};
    users[14] = 0x10;
    put16(users + 15, 0x8026);
    users[19] = 26;
    for (size_t k = 0; k < 3; k++) {
        put16(users + 28 + 2 * k, 8192);
        put16(users + 34 + 2 * k, -5);
        put16(users + 40 + 2 * k, 13366);
    }
    assert_false(ap_joycon_read_calibration(users, sizeof users, &c));
    users[20] = 0xb2;
    users[21] = 0xa1;
    for (size_t len = 0; len < 46; len++)
        assert_false(ap_joycon_read_calibration(users, len, &c));
    assert_true(ap_joycon_read_calibration(users, sizeof users, &c));
    close_to("user's scale of forces", c.accel_scale[1], 9.80665 / 2048, 1e-12);
    close_to("user's bias", c.gyro_bias[2], -5, 0);
    close_to("user's scale of rates", c.gyro_scale[0], 936 * DEGREE / 13371, 1e-12);
    for (size_t k = 0; k < 3; k++) {
        put16(b + 20 + 2 * k, 0);
        put16(b + 26 + 2 * k, 16384);
        put16(b + 32 + 2 * k, 0);
        put16(b + 38 + 2 * k, 13371);
    }
    assert_false(ap_joycon_read_calibration(b, sizeof b, &c));
    close_to("the user's stays", c.gyro_bias[2], -5, 0);
}

static enum ap_report_verdict feed(const struct ap_driver *driver, uint8_t timer) {
    uint8_t b[AP_JOYCON_REPORT];
    make(b, timer, (const int[]){0, 0, 4096}, (const int[]){0, 0, 1000}); // lies flat, turns
    samples.count = 0;
    return driver->parse(&state, &info, 0, b, sizeof b, &samples);
}

// Turned by 70°/s for as long as the timer says, however the reports are spaced.
static void test_timer(void **unused) {
    (void)unused;
    const struct ap_driver *driver = plug(5, 0x2006);
    assert_ptr_equal(driver, &ap_driver_joycon);
    static const uint8_t steps[] = {3, 3, 6, 3, 2, 4, 1, 3, 90, 3};
    uint8_t timer = 0;
    int ticks = 3;
    assert_int_equal(feed(driver, timer), AP_REPORT_OK);
    assert_true(samples.count == 1 && samples.at[0].reset);
    for (int i = 0; i < 200; i++) {
        timer = (uint8_t)(timer + steps[i % 10]);
        ticks += steps[i % 10];
        assert_int_equal(feed(driver, timer), AP_REPORT_OK);
        assert_true(samples.count == 1 && !samples.at[0].reset);
        struct ap_quat q = samples.at[0].pose.q;
        double off = remainder(2 * atan2(q.y, q.w) - 70 * DEGREE * 0.005 * ticks, 360 * DEGREE);
        close_to("turned, rad", off, 0, 1e-6);
    }
    assert_int_equal(feed(driver, timer), AP_REPORT_IGNORED);                // twice the same
    assert_int_equal(feed(driver, (uint8_t)(timer - 1)), AP_REPORT_IGNORED); // out of order
    assert_int_equal(feed(driver, (uint8_t)(timer + 120)), AP_REPORT_OK);    // 0.6 s
    assert_true(samples.at[0].reset);
}

static void test_start(void **unused) {
    (void)unused;
    struct ap_driver_step steps[AP_DRIVER_STEPS_MAX];
    assert_int_equal(plug(3, 0x2009)->start(&info, steps), 8);
    assert_true(steps[0].bytes[0] == 0x80 && steps[0].bytes[1] == 2);
    assert_int_equal(plug(5, 0x2007)->start(&info, steps), 4);
    static const uint8_t sensor[] = {0x01, 2, 0, 1, 0x40, 0x40, 0, 1, 0x40, 0x40, 0x40, 1};
    static const uint8_t full[] = {0x01, 3, 0, 1, 0x40, 0x40, 0, 1, 0x40, 0x40, 0x03, 0x30};
    assert_memory_equal(steps[2].bytes, sensor, sizeof sensor);
    assert_memory_equal(steps[3].bytes, full, sizeof full);
    assert_null(plug(5, 0x2017));
}

// A real left Joy-Con moved by hand, little and for 5 s. There is no truth; but the force, turned
// into the room by the orientation, must point up. With the rates' signs turned it has 0.041 g
// sideways, with two axes swapped 0.077 g.
static void test_recording(void **unused) {
    (void)unused;
    const char *shared = getenv("ANTIPODE_SHARED");
    if (!shared) {
        print_message("skipped: ANTIPODE_SHARED is not set\n");
        skip();
    }
    char path[1024], line[4096];
    snprintf(path, sizeof path, "%s/data/hid/joycon_left_grey_real.hid", shared);
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    const struct ap_driver *driver = plug(5, 0x2006);
    struct ap_vec3 sum = {0, 0, 0};
    double size = 0, squares = 0;
    int poses = 0, resets = 0;
    while (fgets(line, sizeof line, file)) {
        static struct ap_hid_line l;
        struct ap_bad_line bad;
        assert_true(ap_hid_parse_line(line, strcspn(line, "\r\n"), &l, &bad));
        if (l.kind != AP_HID_LINE_REPORT)
            continue;
        samples.count = 0;
        if (driver->parse(&state, &info, l.t_ns, l.bytes, l.byte_count, &samples))
            fail_msg("%s", samples.why);
        for (int i = 0; i < samples.count; i++, poses++) {
            const struct ap_driver_sample *s = &samples.at[i];
            resets += s->reset;
            size += ap_vec3_length(s->acceleration_m_s2) / 9.80665;
            struct ap_vec3 force = ap_quat_rotate(s->pose.q, s->acceleration_m_s2);
            sum = ap_vec3_add(sum, force);
            squares += force.x * force.x + force.z * force.z;
        }
    }
    fclose(file);
    double tilt = acos(sum.y / ap_vec3_length(sum)) / DEGREE;
    double sideways = sqrt(squares / poses) / 9.80665;
    print_message("%d poses, mean force %.4f g, tilted by %.2f degrees, sideways %.4f g RMS\n",
                  poses, size / poses, tilt, sideways);
    assert_int_equal(poses, 316);
    assert_int_equal(resets, 1);
    close_to("force, g", size / poses, 1, 0.03);
    close_to("tilt, degrees", tilt, 0, 2);
    close_to("sideways, g RMS", sideways, 0, 0.038);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_packet),    cmocka_unit_test(test_calibration),
        cmocka_unit_test(test_timer),     cmocka_unit_test(test_start),
        cmocka_unit_test(test_recording),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
