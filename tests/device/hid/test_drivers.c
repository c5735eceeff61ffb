#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "src/device/drivers/hydra/hydra.h"
#include "src/device/drivers/slimevr/slimevr.h"
#include "src/device/drivers/spacemouse/spacemouse.h"
#include "src/device/hid/driver.h"
#include "tests/device/hid/bytes_of.h"

static struct ap_device_info info;
static struct ap_driver_samples samples;
static union {
    max_align_t align;
    unsigned char bytes[AP_DRIVER_STATE_MAX];
} state;

static const struct ap_driver *plug(uint16_t vendor, uint16_t product, const char *descriptor) {
    uint8_t bytes[AP_HID_DESCRIPTOR_MAX];
    size_t len = bytes_of(descriptor, strlen(descriptor), bytes, sizeof bytes);
    struct ap_error err;
    memset(&info, 0, sizeof info);
    memset(&state, 0, sizeof state);
    info.vendor = vendor;
    info.product = product;
    if (len && ap_hid_parse_descriptor(&err, bytes, len, &info.descriptor))
        fail_msg("%s", err.text);
    const struct ap_driver *driver = ap_driver_find(&info);
    if (driver && driver->init)
        driver->init(&state, &info);
    return driver;
}

static enum ap_report_verdict feed(const struct ap_driver *driver, int64_t t_ns, const char *hex) {
    uint8_t bytes[256];
    size_t len = bytes_of(hex, strlen(hex), bytes, sizeof bytes);
    samples.count = 0;
    return driver->parse(&state, &info, t_ns, bytes, len, &samples);
}

static void check_quat(struct ap_quat got, double x, double y, double z, double w,
                       double tolerance) {
    double sign = got.x * x + got.y * y + got.z * z + got.w * w < 0 ? -1 : 1;
    double worst = fmax(fmax(fabs(sign * got.x - x), fabs(sign * got.y - y)),
                        fmax(fabs(sign * got.z - z), fabs(sign * got.w - w)));
    if (!(worst <= tolerance))
        fail_msg("(%.9f %.9f %.9f %.9f), expected (%.9f %.9f %.9f %.9f), tolerance %g", got.x,
                 got.y, got.z, got.w, x, y, z, w, tolerance);
}

static void check_vec(struct ap_vec3 got, double x, double y, double z, double tolerance) {
    double worst = fmax(fabs(got.x - x), fmax(fabs(got.y - y), fabs(got.z - z)));
    if (!(worst <= tolerance))
        fail_msg("(%.9f %.9f %.9f), expected (%.9f %.9f %.9f), tolerance %g", got.x, got.y, got.z,
                 x, y, z, tolerance);
}

static void check_driver(const struct ap_driver *driver, const char *name) {
    assert_string_equal(driver ? driver->name : "none", name);
}

static const double HALF = 0.70710678118654752440;

static void test_android(void **unused) {
    (void)unused;
    const struct ap_driver *driver = plug(0x1234, 0x5678, ANDROID_DESCRIPTOR);
    check_driver(driver, "android-head-tracker");
    struct ap_driver_step steps[AP_DRIVER_STEPS_MAX];
    assert_int_equal(driver->start(&info, steps), 1);
    // All events, full power, the second transport, the shortest interval.
    assert_int_equal(steps[0].kind, AP_STEP_SET_FEATURE);
    assert_int_equal(steps[0].len, 2);
    assert_int_equal(steps[0].bytes[0], 9);
    assert_int_equal(steps[0].bytes[1], 0x07);
    // A quarter turn about the tracker's z, which is up: to the left.
    assert_int_equal(feed(driver, 0, "07 0000 0000 ff3f 0000 0000 ff3f 05"), AP_REPORT_OK);
    assert_int_equal(samples.count, 1);
    check_quat(samples.at[0].pose.q, 0, HALF, 0, HALF, 3e-5);
    assert_true(samples.at[0].has_rate && !samples.at[0].reset);
    check_vec(samples.at[0].angular_velocity_rad_s, 0, 16, 0, 1e-3);
    // No angular velocity, but a turn of 0.1 rad about x within 20 ms.
    assert_int_equal(feed(driver, 1000000000, "07 0000 0000 0000 0000 0000 0000 05"), 0);
    assert_false(samples.at[0].has_rate);
    assert_int_equal(feed(driver, 1020000000, "07 1304 0000 0000 0000 0000 0000 05"), 0);
    assert_true(samples.at[0].has_rate && !samples.at[0].reset);
    check_vec(samples.at[0].angular_velocity_rad_s, 5, 0, 0, 2e-3);
    // Another reference.
    assert_int_equal(feed(driver, 1040000000, "07 0000 0000 0000 0000 0000 0000 06"), 0);
    assert_true(samples.at[0].reset && !samples.at[0].has_rate);
    assert_true(samples.at[0].has_reset_count && samples.at[0].reset_count == 6);
    assert_int_equal(feed(driver, 1050000000, "07 0000 00"), AP_REPORT_BAD);
    assert_int_equal(feed(driver, 1050000000, "09 03"), AP_REPORT_IGNORED);
    assert_int_equal(feed(driver, 1050000000, ""), AP_REPORT_IGNORED);
}

static void set_feature(const char *text, size_t len) {
    info.feature_count = 1;
    info.features[0].len = len;
    info.features[0].bytes[0] = 5;
    memcpy(info.features[0].bytes + 1, text, strlen(text));
}

static void test_android_description(void **unused) {
    (void)unused;
    plug(0, 0, ANDROID_DESCRIPTOR);
    set_feature("#AndroidHeadTracker#2.0#3", 42);
    check_driver(ap_driver_find(&info), "android-head-tracker");
    set_feature("#AnotherTracker#1.0", 42);
    check_driver(ap_driver_find(&info), "none");
    set_feature("#AndroidHeadTracker#1.0", 12);
    check_driver(ap_driver_find(&info), "none");
}

static void test_orientation(void **unused) {
    (void)unused;
    const struct ap_driver *driver = plug(0x8087, 0x0ac2, ORIENTATION_DESCRIPTOR);
    check_driver(driver, "hid-orientation");
    struct ap_driver_step steps[AP_DRIVER_STEPS_MAX];
    assert_int_equal(driver->start(&info, steps), 1);
    assert_int_equal(steps[0].bytes[0], 3);
    assert_int_equal(steps[0].bytes[1], 1);
    // The relative orientation is taken, the one with a compass is not.
    assert_int_equal(feed(driver, 0, "02 0000 0000 0000 ff7f"), AP_REPORT_IGNORED);
    assert_int_equal(feed(driver, 0, "01 0000"), AP_REPORT_IGNORED);
    assert_int_equal(feed(driver, 0, "03 0000 0000 825a 825a"), AP_REPORT_OK);
    check_quat(samples.at[0].pose.q, 0, HALF, 0, HALF, 1e-9);
    assert_int_equal(samples.at[0].kind, AP_SAMPLE_ORIENTATION);
    assert_int_equal(feed(driver, 0, "03 0000 0000 0000 0000"), AP_REPORT_BAD);
    assert_int_equal(feed(driver, 0, "03 0000 0000 0000"), AP_REPORT_BAD);
}

static void test_spacemouse(void **unused) {
    (void)unused;
    const struct ap_driver *driver = plug(0x256f, 0xc635, CAP_DESCRIPTOR);
    check_driver(driver, "spacemouse");
    check_driver(plug(0x256f, 0xc650, CAP_DESCRIPTOR), "none");
    plug(0x046d, 0xc626, CAP_DESCRIPTOR);
    // Pushed away from oneself at full: one metre a second, along −z. The order is y, x, z.
    assert_int_equal(feed(driver, 0, "01 81 00 00"), AP_REPORT_OK);
    check_vec(samples.at[0].pose.p, 0, 0, 0, 0);
    assert_int_equal(samples.at[0].kind, AP_SAMPLE_FLIGHT);
    assert_int_equal(feed(driver, 50000000, "02 00 00 00"), AP_REPORT_OK);
    check_vec(samples.at[0].pose.p, 0, 0, -0.05, 1e-12);
    // The release is lost: 0.15 s after the last report (that of the other axes) it stands still.
    assert_int_equal(feed(driver, 5000000000, "01 00 00 00"), AP_REPORT_OK);
    check_vec(samples.at[0].pose.p, 0, 0, -0.2, 1e-12);
    // Pulled up: z is down. Turned about the vertical, to the left, for a second.
    assert_int_equal(feed(driver, 5000000000, "01 00 00 81"), AP_REPORT_OK);
    assert_int_equal(feed(driver, 5100000000, "01 00 00 00"), AP_REPORT_OK);
    check_vec(samples.at[0].pose.p, 0, 0.1, -0.2, 1e-12);
    assert_int_equal(feed(driver, 5100000000, "02 81 00 00"), AP_REPORT_OK);
    for (int i = 1; i <= 20; i++)
        assert_int_equal(feed(driver, 5100000000 + i * INT64_C(50000000), "02 81 00 00"), 0);
    check_quat(samples.at[0].pose.q, 0, HALF, 0, HALF, 1e-12);
    check_vec(samples.at[0].angular_velocity_rad_s, 0, 1.5707963267948966, 0, 1e-12);
    // −128 is beyond the range that is declared; now forward is −x.
    assert_int_equal(feed(driver, 6100000000, "02 00 00 00"), 0);
    assert_int_equal(feed(driver, 6100000000, "01 80 00 00"), 0);
    assert_int_equal(feed(driver, 6200000000, "01 00 00 00"), 0);
    check_vec(samples.at[0].pose.p, -0.1, 0.1, -0.2, 1e-12);
    assert_int_equal(feed(driver, 6200000000, "03 05 08"), AP_REPORT_OK);
    assert_int_equal(samples.at[0].buttons, 0x805);
    assert_int_equal(feed(driver, 6200000000, "01 00"), AP_REPORT_BAD);
    assert_int_equal(feed(driver, 6200000000, "1c 00 00"), AP_REPORT_IGNORED);
}

static void test_hold(void **unused) {
    (void)unused;
    static const double want[][2] = {{-1, 0},        {0, 0},      {0.05, 0.05}, {0.1, 0.1},
                                     {0.15, 0.1375}, {0.2, 0.15}, {3, 0.15},    {NAN, 0}};
    for (size_t i = 0; i < sizeof want / sizeof *want; i++)
        if (!(fabs(ap_spacemouse_hold_s(want[i][0]) - want[i][1]) < 1e-15))
            fail_msg("after %g s: %.17g, expected %g", want[i][0], ap_spacemouse_hold_s(want[i][0]),
                     want[i][1]);
}

#define EMPTY16 "00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00"

static void test_slimevr(void **unused) {
    (void)unused;
    const struct ap_driver *driver = plug(0x1209, 0x7690, "");
    check_driver(driver, "slimevr");
    check_driver(plug(0x4e76, 0xd2da, ""), "slimevr");
    check_driver(plug(0x1209, 0x7691, ""), "none");
    // Nobody has said that tracker 7 is there.
    static const char turned[] = "01 07 00 00 00 00 825a 825a 0000 0000 8000";
    assert_int_equal(feed(driver, 0, turned), AP_REPORT_OK);
    assert_int_equal(samples.count, 0);
    assert_int_equal(feed(driver, 0,
                          "ff 07 01 02 03 04 05 06 00 00 00 00 00 00 00 00"
                          "ff 02 01 02 03 04 05 07 00 00 00 00 00 00 00 00" EMPTY16),
                     AP_REPORT_OK);
    assert_int_equal(samples.count, 0);
    // Turned about the trackers' z, which is up; twice the same packet is one sample.
    char twice[256];
    snprintf(twice, sizeof twice, "%s %s", turned, turned);
    assert_int_equal(feed(driver, 0, twice), AP_REPORT_OK);
    assert_int_equal(samples.count, 1);
    assert_int_equal(samples.at[0].tracker, 0);
    struct ap_quat z_up = {0, 0, HALF, HALF}, turn = {-HALF, 0, 0, HALF};
    struct ap_quat want = ap_quat_mul(turn, z_up);
    check_quat(samples.at[0].pose.q, want.x, want.y, want.z, want.w, 1e-9);
    check_vec(samples.at[0].acceleration_m_s2, 0, 0, 1, 0);
    // What is left in the battery comes with another packet, and stays; padding says nothing.
    assert_false(samples.at[0].has_battery);
    snprintf(twice, sizeof twice, "00 07 c6 96 00 00 00 00 00 00 00 00 00 00 00 00 %s", turned);
    assert_int_equal(feed(driver, 0, twice), AP_REPORT_OK);
    assert_true(samples.at[0].has_battery && samples.at[0].battery == 0.7f);
    snprintf(twice, sizeof twice, "00 07 00 00 00 00 00 00 00 00 00 00 00 00 00 00 %s", turned);
    assert_int_equal(feed(driver, 0, twice), AP_REPORT_OK);
    assert_true(samples.at[0].has_battery && samples.at[0].battery == 0.7f);
    // Packed: v = (0, 0, 1/2) is half of pi about z.
    struct ap_slimevr_packet p;
    uint8_t packed[16] = {7, 2, 2};
    uint32_t bits = 512u | 1024u << 10 | 1536u << 21;
    for (int i = 0; i < 4; i++)
        packed[5 + i] = (uint8_t)(bits >> 8 * i);
    assert_true(ap_slimevr_parse(packed, &p));
    check_quat(p.q, 0, 0, HALF, HALF, 1e-12);
    assert_true(p.has_buttons && p.buttons == 2);
    // Not a rotation, a report of half a packet, one of nothing.
    assert_int_equal(feed(driver, 0, "01 07 00 00 00 00 00 00 00 00 00 00 00 00 00 00"),
                     AP_REPORT_BAD);
    assert_int_equal(feed(driver, 0, "01 07 00 00"), AP_REPORT_BAD);
    assert_int_equal(feed(driver, 0, ""), AP_REPORT_BAD);
    assert_int_equal(feed(driver, 0, "01 09 00 00 00 00 00 00 00 00 00 00 00 00 00 00"),
                     AP_REPORT_OK);
}

// The packed rotations against what the trackers' firmware packs, all over: the quaternion's vector
// part, its length made 2/pi times half the angle, x in 10 bits, y and z in 11, what is over cut
// off.
static void test_slimevr_packed(void **unused) {
    (void)unused;
    double worst = 0;
    for (int i = 0; i < 4000; i++) {
        double angle = 3.1 * (i % 101) / 101, a = i * 0.37, b = i * 0.11;
        struct ap_vec3 axis = {cos(a) * cos(b), sin(a) * cos(b), sin(b)};
        struct ap_quat want = ap_quat_from_axis_angle(axis, angle);
        double sine = sqrt(1 - want.w * want.w);
        double r = angle > 0 ? 0.63661977236758134308 * atan2(sine, want.w) : 0;
        uint32_t bits = ((uint32_t)((axis.x * r + 1) * 512) & 0x3ff) |
                        ((uint32_t)((axis.y * r + 1) * 1024) & 0x7ff) << 10 |
                        ((uint32_t)((axis.z * r + 1) * 1024) & 0x7ff) << 21;
        uint8_t packet[16] = {2};
        for (int k = 0; k < 4; k++)
            packet[5 + k] = (uint8_t)(bits >> 8 * k);
        struct ap_slimevr_packet p;
        assert_true(ap_slimevr_parse(packet, &p));
        double c = fabs(p.q.x * want.x + p.q.y * want.y + p.q.z * want.z + p.q.w * want.w);
        worst = fmax(worst, 2 * acos(fmin(1, c)) * 57.295779513);
    }
    print_message("packed rotations: worst %.3f degrees\n", worst);
    if (!(worst < 0.5))
        fail_msg("worst %.3f degrees, allowed 0.5", worst);
}

static void test_hydra(void **unused) {
    (void)unused;
    const struct ap_driver *driver = plug(0x1532, 0x0300, "");
    check_driver(driver, "hydra");
    struct ap_driver_step steps[AP_DRIVER_STEPS_MAX];
    assert_int_equal(driver->start(&info, steps), 2);
    assert_int_equal(steps[0].len, 91);
    static const char head[] = "00 00 00 00 00 00 00 2a ";
    static const char left[] = "64 00 c8 00 2c 01 ff7f 0000 0000 0000 01 0000 0000 ff 0000 ";
    static const char right[] = "9c ff 00 00 00 00 0000 ff7f 0000 0000 00 0000 0000 00 0000";
    char text[512];
    snprintf(text, sizeof text, "%s%s%s", head, left, right);
    assert_int_equal(feed(driver, 0, text), AP_REPORT_OK);
    assert_int_equal(samples.count, 2);
    uint8_t bytes[64];
    struct ap_hydra_controller c[2];
    assert_int_equal(ap_hydra_parse(bytes, bytes_of(text, strlen(text), bytes, 64), c), 0);
    check_vec(c[0].p_m, 0.1, -0.3, 0.2, 1e-12);
    check_quat(c[0].q, 0, 0, 0, 1, 1e-12);
    assert_true(c[0].buttons == 1 && c[0].trigger == 1);
    check_vec(c[1].p_m, -0.1, 0, 0, 1e-12);
    check_quat(c[1].q, 1, 0, 0, 0, 1e-12);
    assert_int_equal(samples.at[1].kind, AP_SAMPLE_POSE);
    assert_int_equal(ap_hydra_parse(bytes, 51, c), AP_REPORT_BAD);
    memset(bytes + 36, 0, 8);
    assert_int_equal(ap_hydra_parse(bytes, 52, c), AP_REPORT_BAD);
}

static void test_table(void **unused) {
    (void)unused;
    for (int i = 0; i < ap_driver_count(); i++) {
        const struct ap_driver *a = ap_driver_at(i);
        assert_true(a->name[0] && a->title[0] && (a->match || a->ids) && a->parse);
        assert_true(a->state_bytes <= AP_DRIVER_STATE_MAX);
        for (int k = 0; k < i; k++)
            assert_string_not_equal(a->name, ap_driver_at(k)->name);
    }
    assert_null(ap_driver_at(-1));
    assert_null(ap_driver_at(ap_driver_count()));
    memset(&info, 0, sizeof info);
    assert_null(ap_driver_find(&info));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_android),        cmocka_unit_test(test_android_description),
        cmocka_unit_test(test_orientation),    cmocka_unit_test(test_spacemouse),
        cmocka_unit_test(test_hold),           cmocka_unit_test(test_slimevr),
        cmocka_unit_test(test_slimevr_packed), cmocka_unit_test(test_hydra),
        cmocka_unit_test(test_table),
    };
    return cmocka_run_group_tests_name("hid-drivers", tests, NULL, NULL);
}
