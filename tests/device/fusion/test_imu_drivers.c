#include <inttypes.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "src/device/drivers/fused.h"
#include "src/device/drivers/playstation/playstation.h"
#include "src/device/drivers/xreal/xreal.h"
#include "src/device/timeline.h"

// The drivers of devices that only measure rates and forces: their packets byte by byte, and the
// shared recordings through driver and fusion against where their bytes were made from.

static const double DEGREE = 3.14159265358979323846 / 180;

static struct ap_device_info info;
static struct ap_driver_samples samples;
static union {
    max_align_t align;
    unsigned char bytes[AP_DRIVER_STATE_MAX];
} state;

static const struct ap_driver *plug(uint16_t bus, uint16_t vendor, uint16_t product) {
    info.bus = bus;
    info.vendor = vendor;
    info.product = product;
    const struct ap_driver *driver = ap_driver_find(&info);
    memset(&state, 0, sizeof state);
    if (driver)
        driver->init(&state, &info);
    return driver;
}

static void close_to(const char *what, double got, double want, double tolerance) {
    if (!(fabs(got - want) <= tolerance))
        fail_msg("%s: %.12g, expected %.12g, tolerance %g", what, got, want, tolerance);
}

static void put16(uint8_t *b, int v) {
    b[0] = (uint8_t)(v & 255);
    b[1] = (uint8_t)(v >> 8 & 255);
}

static void put_crc(uint8_t *b, size_t len) {
    uint32_t crc = ap_crc32(ap_crc32(0, (const uint8_t[]){0xa1}, 1), b, len - 4);
    put16(b + len - 4, (int)(crc & 0xffff));
    put16(b + len - 2, (int)(crc >> 16));
}

static void test_crc(void **unused) {
    (void)unused;
    assert_int_equal(ap_crc32(0, (const uint8_t *)"123456789", 9), 0xcbf43926);
    // What turns an XREAL Air's stream on, as its own program sends it.
    static const uint8_t on[] = {0xaa, 0xc5, 0xd1, 0x21, 0x42, 4, 0, 0x19, 1, 0};
    uint8_t command[AP_XREAL_COMMAND];
    ap_xreal_command(command, 0x19, (const uint8_t[]){1}, 1);
    assert_memory_equal(command, on, sizeof on);
}

// A calibration of 1.5 times the usual rate, with biases; the places of the numbers by layout.
static struct ap_feature_report calibration_of(const struct ap_playstation_layout *layout) {
    struct ap_feature_report f = {.len = layout->calibration_len, .bytes = {layout->calibration}};
    for (size_t i = 0; i < 3; i++) {
        put16(f.bytes + 1 + 2 * i, 10 * ((int)i + 1));
        put16(f.bytes + layout->plus[i], 8856);
        put16(f.bytes + layout->minus[i], -8856);
        put16(f.bytes + 23 + 4 * i, 8192 + 100);
        put16(f.bytes + 25 + 4 * i, -8192 + 100);
    }
    put16(f.bytes + 19, 810);
    put16(f.bytes + 21, 810);
    return f;
}

static void check_playstation(uint16_t bus, uint16_t product, size_t gyro, size_t accel,
                              size_t ticks, size_t buttons, size_t triggers, size_t battery) {
    const struct ap_driver *driver = plug(bus, 0x054c, product);
    assert_ptr_equal(driver, &ap_driver_playstation);
    const struct ap_playstation_layout *layout =
        ap_driver_ids_of(&ap_driver_playstation, &info)->model;
    struct ap_feature_report feature = calibration_of(layout);
    struct ap_playstation_calibration c = ap_playstation_calibrate(layout, &feature);
    uint8_t b[78] = {layout->report};
    for (int i = 0; i < 3; i++) {
        put16(b + gyro + 2 * (size_t)i, 10 * (i + 1) + 1000 * (i - 1));
        put16(b + accel + 2 * (size_t)i, 100 + 4096 * i);
    }
    put16(b + ticks, 0x1234);
    b[buttons] = 0x28; // no direction, cross
    b[buttons + 1] = 1;
    b[triggers + 1] = 51;
    b[battery] = 0x17; // at a cable, seven tenths and some
    if (layout->has_crc)
        put_crc(b, layout->len);
    struct ap_playstation_packet p;
    assert_int_equal(ap_playstation_parse(layout, &c, b, layout->len, &p), AP_REPORT_OK);
    double turn = 1000 * 1620 / 17712.0 * DEGREE;
    close_to("pitch", p.gyr_rad_s.x, -turn, 1e-12);
    close_to("yaw", p.gyr_rad_s.y, 0, 1e-12);
    close_to("roll", p.gyr_rad_s.z, turn, 1e-12);
    close_to("x", p.acc_m_s2.x, 0, 1e-12);
    close_to("y", p.acc_m_s2.y, 9.80665 / 2, 1e-12);
    close_to("z", p.acc_m_s2.z, 9.80665, 1e-12);
    assert_int_equal(p.ticks, 0x1234);
    assert_int_equal(p.buttons, 0x11);
    close_to("trigger", p.trigger, 0.2, 1e-12);
    close_to("battery", p.battery, 0.75, 1e-12);
    for (size_t len = 0; len < layout->len; len++)
        assert_int_equal(ap_playstation_parse(layout, &c, b, len, &p), AP_REPORT_BAD);
    b[gyro] ^= 4;
    assert_int_equal(ap_playstation_parse(layout, &c, b, layout->len, &p),
                     layout->has_crc ? AP_REPORT_BAD : AP_REPORT_OK);
    b[0] = 0x7f;
    assert_int_equal(ap_playstation_parse(layout, &c, b, layout->len, &p), AP_REPORT_IGNORED);
}

static void test_playstation_packets(void **unused) {
    (void)unused;
    check_playstation(3, 0x0ce6, 16, 22, 28, 8, 5, 53);
    check_playstation(5, 0x0ce6, 17, 23, 29, 9, 6, 54);
    check_playstation(3, 0x09cc, 13, 19, 10, 5, 8, 30);
    check_playstation(5, 0x05c4, 15, 21, 12, 7, 10, 32);
    assert_null(plug(3, 0x054c, 0x1234));
    assert_null(plug(6, 0x054c, 0x0ce6));
}

// The same motion through each of the four reports, with the calibration as each has it: the same
// poses, buttons aside.
static void test_playstation_motion(void **unused) {
    (void)unused;
    static const struct {
        uint16_t bus, product;
        uint8_t report;
        size_t len, gyro, accel, ticks, plus[3], minus[3], feature_len;
        uint8_t feature;
        bool is_short; // its clock
    } kinds[] = {
        {3, 0x0ce6, 0x01, 64, 16, 22, 28, {7, 11, 15}, {9, 13, 17}, 41, 5, false},
        {5, 0x0df2, 0x31, 78, 17, 23, 29, {7, 11, 15}, {9, 13, 17}, 41, 5, false},
        {3, 0x05c4, 0x01, 64, 13, 19, 10, {7, 11, 15}, {9, 13, 17}, 37, 2, true},
        {5, 0x09cc, 0x11, 78, 15, 21, 12, {7, 9, 11}, {13, 15, 17}, 41, 5, true},
    };
    struct ap_quat first[500];
    for (size_t k = 0; k < 4; k++) {
        struct ap_feature_report *f = &info.features[0];
        *f = (struct ap_feature_report){.len = kinds[k].feature_len, .bytes = {kinds[k].feature}};
        for (size_t a = 0; a < 3; a++) {
            put16(f->bytes + 1 + 2 * a, 5 - 7 * (int)a);
            put16(f->bytes + kinds[k].plus[a], 8800 + 50 * (int)a);
            put16(f->bytes + kinds[k].minus[a], -8800);
            put16(f->bytes + 23 + 4 * a, 8200 + 10 * (int)a);
            put16(f->bytes + 25 + 4 * a, -8100);
        }
        put16(f->bytes + 19, 540);
        put16(f->bytes + 21, 540);
        info.feature_count = 1;
        const struct ap_driver *driver = plug(kinds[k].bus, 0x054c, kinds[k].product);
        assert_ptr_equal(driver, &ap_driver_playstation);
        for (int i = 0; i < 500; i++) {
            uint8_t b[78] = {kinds[k].report};
            uint32_t thirds = 4294900000u + 12000u * (uint32_t)i; // of a microsecond
            uint32_t ticks = kinds[k].is_short ? thirds / 16 : thirds;
            put16(b + kinds[k].ticks, (int)(ticks & 0xffff));
            if (!kinds[k].is_short)
                put16(b + kinds[k].ticks + 2, (int)(ticks >> 16));
            for (size_t a = 0; a < 3; a++) {
                put16(b + kinds[k].gyro + 2 * a, (int)(3000 * sin(0.02 * i + (double)a)));
                put16(b + kinds[k].accel + 2 * a, a == 1 ? 8192 : 300 - 200 * (int)a);
            }
            if (kinds[k].len == 78)
                put_crc(b, 78);
            samples.count = 0;
            assert_int_equal(driver->parse(&state, &info, 0, b, kinds[k].len, &samples),
                             AP_REPORT_OK);
            struct ap_quat q = samples.at[0].pose.q;
            if (k == 0)
                first[i] = q;
            struct ap_quat d = ap_quat_mul(ap_quat_conj(first[i]), q);
            close_to("turned from the first kind's", sqrt(d.x * d.x + d.y * d.y + d.z * d.z), 0,
                     1e-12);
        }
    }
    struct ap_quat way = ap_quat_mul(ap_quat_conj(first[0]), first[100]);
    assert_true(fabs(way.w) < 0.99); // it did turn
    info.feature_count = 0;
}

// Copies of these controllers answer with nonsense.
static void test_calibration(void **unused) {
    (void)unused;
    plug(3, 0x054c, 0x0ce6);
    const struct ap_playstation_layout *layout =
        ap_driver_ids_of(&ap_driver_playstation, &info)->model;
    struct ap_feature_report zero = {.len = 41, .bytes = {5}}, full = zero,
                             cut = calibration_of(layout);
    memset(full.bytes + 1, 0xff, 40);
    cut.len = 40;
    const struct ap_feature_report *reports[] = {NULL, &zero, &full, &cut};
    for (int i = 0; i < 4; i++) {
        struct ap_playstation_calibration c = ap_playstation_calibrate(layout, reports[i]);
        for (int axis = 0; axis < 3; axis++) {
            close_to("scale of rates", c.gyro_scale[axis], DEGREE / 16.4, 1e-15);
            close_to("scale of forces", c.accel_scale[axis], 9.80665 / 8192, 1e-15);
            close_to("biases", fabs(c.gyro_bias[axis]) + fabs(c.accel_bias[axis]), 0, 0);
        }
    }
}

static void put24(uint8_t *b, int v) {
    put16(b, v);
    b[2] = (uint8_t)(v >> 16 & 255);
}

static void test_xreal_packet(void **unused) {
    (void)unused;
    uint8_t b[64] = {1, 2};
    put16(b + 4, 1000);
    b[11] = 0x80;
    put16(b + 12, 2000);
    b[16] = 0x80; // 2²³
    put16(b + 27, 16);
    b[31] = 0x80;
    static const int raw[] = {-0x800000, 0x400000, 0x1000};
    for (size_t i = 0; i < 3; i++) {
        put24(b + 18 + 3 * i, raw[i]);
        put24(b + 33 + 3 * i, raw[i]);
    }
    struct ap_xreal_packet p;
    assert_int_equal(ap_xreal_parse(b, 64, &p), AP_REPORT_OK);
    assert_true(p.device_ns == UINT64_C(0x80000000000003e8));
    close_to("x", p.gyr_rad_s.x, 2000 * DEGREE, 1e-9);
    close_to("y", p.gyr_rad_s.y, 2000.0 / 2048 * DEGREE, 1e-12);
    close_to("z", p.gyr_rad_s.z, 1000 * DEGREE, 1e-9);
    close_to("up", p.acc_m_s2.y, 9.80665 * 16 / 2048, 1e-12);
    for (size_t len = 0; len < 64; len++)
        assert_int_equal(ap_xreal_parse(b, len, &p), AP_REPORT_BAD);
    b[31] = 0;
    assert_int_equal(ap_xreal_parse(b, 64, &p), AP_REPORT_BAD);
    b[0] = 0xaa;
    assert_int_equal(ap_xreal_parse(b, 64, &p), AP_REPORT_IGNORED);
    // The fourth interface takes commands to the screens, but for the Ultra's.
    info.interface_known = true;
    info.interface_number = 4;
    assert_null(plug(3, 0x3318, 0x0424));
    assert_ptr_equal(plug(3, 0x3318, 0x0426), &ap_driver_xreal);
    info.interface_number = 3;
    assert_ptr_equal(plug(3, 0x3318, 0x0424), &ap_driver_xreal);
    info.interface_known = false;
}

static const struct ap_driver *plug_xreal_and_answer(const char *config, size_t piece) {
    const struct ap_driver *driver = plug(3, 0x3318, 0x0424);
    struct ap_driver_step step;
    uint8_t b[64] = {0xaa, [5] = 7, [7] = AP_XREAL_CONFIG_LENGTH};
    size_t left = strlen(config);
    put16(b + 8, (int)left);
    assert_false(driver->ask(&state, &step));
    while (left > 0) {
        size_t n = piece < left ? piece : left;
        assert_int_equal(driver->parse(&state, &info, 0, b, sizeof b, &samples), AP_REPORT_IGNORED);
        assert_true(driver->ask(&state, &step));
        assert_int_equal(step.bytes[8], AP_XREAL_CONFIG_NEXT);
        assert_false(driver->ask(&state, &step)); // once
        memset(b, ' ', sizeof b);
        b[0] = 0xaa;
        put16(b + 5, 3 + (int)n);
        b[7] = AP_XREAL_CONFIG_NEXT;
        memcpy(b + 8, config, n);
        config += n;
        left -= n;
    }
    driver->parse(&state, &info, 0, b, sizeof b, &samples);
    assert_true(driver->ask(&state, &step));
    assert_int_equal(step.bytes[8], AP_XREAL_STREAM);
    assert_int_equal(step.bytes[9], 1);
    return driver;
}

// What is left of a rate of 0 once the bias is taken away.
static struct ap_vec3 rate_at_nothing(const struct ap_driver *driver) {
    uint8_t b[64] = {1, 2, [12] = 1, [16] = 0x80, [27] = 16, [31] = 0x80};
    put24(b + 39, 0x800000 / 16);
    samples.count = 0;
    assert_int_equal(driver->parse(&state, &info, 0, b, sizeof b, &samples), AP_REPORT_OK);
    assert_true(samples.at[0].gyro_rad_s.x == 0);
    return samples.at[0].angular_velocity_rad_s;
}

// The factory's biases are found wherever the text is cut, and only where they belong.
static void test_xreal_config(void **unused) {
    (void)unused;
    static const char config[] =
        "{\"a\": [{\"IMU\": {\"device_1\": {\"gyro_bias\": [9,9,9]}}}, \"}\\\"\"],\n"
        " \"IMU\": {\"device_2\": {\"gyro_bias\": [8, 8, 8]}, \"device_1\": {\"accel_bias\": "
        "[0.125,-0.25, 0.5], \"gyro_bias\" :[ 0.01, -2e-2, 0.03 ], \"x\": {\"gyro_bias\": [7,7,7]},"
        "\"scale\": [1,1,1]}}, \"gyro_bias\": [6, 6, 6]}";
    for (size_t piece = 1; piece <= 56; piece++) {
        struct ap_vec3 w = rate_at_nothing(plug_xreal_and_answer(config, piece));
        // Theirs are x right, y down, z ahead. The fusion's own estimate is in it, too.
        close_to("x", w.x, -0.01, 2e-5);
        close_to("y", w.y, -0.02, 2e-5);
        close_to("z", w.z, 0.03, 2e-5);
    }
    static const char *const none[] = {
        "{}",
        "no JSON",
        "{\"IMU\":{\"device_1\":{\"accel_bias\":[0,0,0]}}}",
        "{\"IMU\":{\"device_1\":{\"accel_bias\":[0,0,0],\"gyro_bias\":[0.1,0.1]}}}",
        "{\"IMU\":{\"device_1\":{\"accel_bias\":[0,0,0],\"gyro_bias\":[0.1,\"a\",0.1]}}}",
        "{\"IMU\":{\"device_1\":{\"accel_bias\":[0,0,0],\"gyro_bias\":[0.1,0.1,1e9]}}}",
        "{\"IMU\":{\"device_1\":{\"accel_bias\":[0,0,0],\"gyro_bias\":[[0.1,0.1,0.1]]}}}",
    };
    for (size_t i = 0; i < sizeof none / sizeof *none; i++) {
        struct ap_vec3 w = rate_at_nothing(plug_xreal_and_answer(none[i], 56));
        if (ap_vec3_length(w) > 2e-5)
            fail_msg("'%s' gave a bias of %g %g %g", none[i], -w.x, -w.y, -w.z);
    }
    // What somebody has measured goes before.
    info.bias.gyr_rad_s.x = 0.5;
    close_to("x", rate_at_nothing(plug_xreal_and_answer(config, 56)).x, -0.5, 1e-3);
    info.bias.gyr_rad_s.x = 0;
}

// The device's clock: repeated stamps say nothing, a jump of a day begins anew.
static void test_clock_jump(void **unused) {
    (void)unused;
    struct ap_imu imu;
    const struct ap_vec3 turn = {0, 1, 0}, up = {0, 9.81, 0};
    const struct ap_imu_params params = {
        .period_s = 0.004, .bits = 16, .tick_ns_num = 16000, .tick_ns_den = 3};
    assert_true(ap_imu_init(&imu, &params));
    assert_int_equal(ap_imu_add(&imu, 65000, (struct ap_vec3){0, (double)NAN, 0}, up),
                     AP_IMU_REFUSED);
    assert_int_equal(ap_imu_add(&imu, 65000, turn, up), AP_IMU_RESET);
    assert_int_equal(ap_imu_add(&imu, 65000, turn, up), AP_IMU_REPEATED);
    for (int i = 1; i <= 1000; i++) // through five wraps
        assert_int_equal(ap_imu_add(&imu, (uint64_t)(65000 + 750 * i), turn, up), AP_IMU_OK);
    assert_int_equal(imu.device_ns, 4000000000);
    struct ap_quat q = ap_vqf_orientation(&imu.vqf);
    close_to("turned, rad", fabs(remainder(2 * atan2(q.y, q.w) - 4.004, 2 * 180 * DEGREE)), 0,
             1e-6);
    struct ap_imu_params wide = {.period_s = 0.001, .bits = 64, .tick_ns_num = 1, .tick_ns_den = 1};
    assert_true(ap_imu_init(&imu, &wide));
    assert_int_equal(ap_imu_add(&imu, UINT64_C(86400000000000), turn, up), AP_IMU_RESET);
    assert_int_equal(ap_imu_add(&imu, UINT64_C(86400001000000), turn, up), AP_IMU_OK);
    assert_int_equal(ap_imu_add(&imu, 5, turn, up), AP_IMU_RESET);
    wide.bits = 7;
    assert_false(ap_imu_init(&imu, &wide));
}

// Random bytes behind the right header: whatever comes out is a pose.
static void fuzz(const struct ap_driver *driver, uint8_t report, size_t len) {
    uint64_t seed = 7;
    uint8_t b[78];
    int poses = 0;
    for (int i = 0; i < 20000; i++) {
        for (size_t k = 0; k < len; k++) {
            seed = seed * 6364136223846793005u + 1442695040888963407u;
            b[k] = (uint8_t)(seed >> 56);
        }
        b[0] = report;
        if (report == 1 && i % 3)
            b[1] = 2;
        if (report == 0x31 || report == 0x11)
            put_crc(b, len);
        samples.count = 0;
        driver->parse(&state, &info, i, b, len, &samples);
        for (int k = 0; k < samples.count; k++, poses++) {
            struct ap_quat q = samples.at[k].pose.q;
            close_to("|q|²", q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w, 1, 1e-12);
            assert_true(isfinite(ap_vec3_length(samples.at[k].angular_velocity_rad_s)));
        }
    }
    assert_true(poses > 0);
}

static void test_random_packets(void **unused) {
    (void)unused;
    fuzz(plug(3, 0x054c, 0x0ce6), 0x01, 64);
    fuzz(plug(5, 0x054c, 0x0ce6), 0x31, 78);
    fuzz(plug(3, 0x054c, 0x05c4), 0x01, 64);
    fuzz(plug(5, 0x054c, 0x09cc), 0x11, 78);
    fuzz(plug(3, 0x3318, 0x0424), 0x01, 64);
}

static struct ap_timeline *load(const char *name) {
    char source[1024];
    snprintf(source, sizeof source, "head=%s/data/hid/%s", getenv("ANTIPODE_SHARED"), name);
    const char *sources[] = {source};
    struct ap_poselog_params params = {.sources = sources, .source_count = 1};
    struct ap_error err;
    struct ap_poselog *log = NULL;
    struct ap_timeline *timeline = NULL;
    if (ap_poselog_open(&err, &params, &log) || ap_timeline_load(&err, log, &timeline))
        fail_msg("%s", err.text);
    ap_poselog_close(log);
    return timeline;
}

// RMS of the inclination over the recording, and the heading's way from its start to its end.
static void check_recording(const char *name, int64_t count, double limit_deg,
                            double heading_limit_deg) {
    if (!getenv("ANTIPODE_SHARED")) {
        print_message("skipped: ANTIPODE_SHARED is not set\n");
        skip();
    }
    char file[128], truth_file[128];
    snprintf(file, sizeof file, "%s.hid", name);
    snprintf(truth_file, sizeof truth_file, "%s.truth.tum", name);
    struct ap_timeline *got = load(file), *truth = load(truth_file);
    double squares = 0, heading = 0, start = 0, worst = 0;
    int64_t n = ap_timeline_sample_count(got), compared = 0;
    assert_int_equal(n, count);
    for (int64_t i = 0; i < n; i++) {
        struct ap_sample s = ap_timeline_sample(got, i), want;
        enum ap_pose_state at = ap_timeline_at(truth, 0, s.t_ns, &want);
        if (at != AP_POSE_EXACT && at != AP_POSE_INTERPOLATED)
            continue;
        struct ap_quat d = ap_quat_mul(s.pose.q, ap_quat_conj(want.pose.q));
        double inclination = 2 * acos(fmin(1, hypot(d.y, d.w))) / DEGREE;
        heading = remainder(2 * atan2(d.y, d.w) / DEGREE, 360);
        if (!compared++)
            start = heading;
        squares += inclination * inclination;
        worst = fmax(worst, inclination);
    }
    double rms = sqrt(squares / (double)compared), off = fabs(remainder(heading - start, 360));
    print_message("%s: %" PRId64 " poses, inclination %.3f degrees RMS, %.3f worst; heading %.3f\n",
                  name, n, rms, worst, off);
    close_to("inclination, degrees RMS", rms, 0, limit_deg);
    close_to("heading, degrees", off, 0, heading_limit_deg);
    ap_timeline_destroy(got);
    ap_timeline_destroy(truth);
}

static void test_dualsense_recording(void **unused) {
    (void)unused;
    check_recording("dualsense_usb_vive_right", 3001, 1.5, 3);
}

static void test_xreal_recording(void **unused) {
    (void)unused;
    check_recording("xreal_air_imu_vive_head", 5000, 1.5, 3);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_crc),
        cmocka_unit_test(test_playstation_packets),
        cmocka_unit_test(test_playstation_motion),
        cmocka_unit_test(test_calibration),
        cmocka_unit_test(test_xreal_packet),
        cmocka_unit_test(test_xreal_config),
        cmocka_unit_test(test_clock_jump),
        cmocka_unit_test(test_random_packets),
        cmocka_unit_test(test_dualsense_recording),
        cmocka_unit_test(test_xreal_recording),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
