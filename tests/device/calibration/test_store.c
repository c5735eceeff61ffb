#include "tests/device/calibration/noise.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "src/base/file.h"
#include "src/device/calibration/store.h"

static char dir[] = "/tmp/antipode-calibration-XXXXXX";

static struct ap_device_calibration some_device(const char *key) {
    struct ap_device_calibration c = {
        .has_bias = true,
        .has_mount = true,
        .rest = {.bias = {{0.01, -1.0 / 3e3, 1e-17}, {0.1, 0.2, -1.0 / 3}},
                 .gyr_sigma_rad_s = 1e-5,
                 .seconds = 4.75,
                 .poses = 3},
        .tracker_from_body = ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, 1)};
    snprintf(c.key, sizeof c.key, "%s", key);
    return c;
}

// Read back bit for bit, whatever a device calls itself.
static void test_devices(void **state) {
    (void)state;
    static const char *const keys[] = {"SN-1",    "../../etc/passwd", "a b/c:d%",
                                       ".hidden", "\xc3\xa9",         "054c:0ce6"};
    enum { COUNT = sizeof keys / sizeof *keys };
    struct ap_error err = {""};
    bool found = false;
    for (int i = 0; i < COUNT; i++) {
        struct ap_device_calibration c = some_device(keys[i]), back;
        c.has_mount = i != 1;
        if (ap_calibration_write(&err, dir, &c) ||
            ap_calibration_read(&err, dir, keys[i], &back, &found))
            fail_msg("%s", err.text);
        assert_true(found);
        assert_string_equal(back.key, keys[i]);
        assert_memory_equal(&back.rest.bias, &c.rest.bias, sizeof c.rest.bias);
        assert_true(back.rest.gyr_sigma_rad_s == c.rest.gyr_sigma_rad_s);
        assert_true(back.rest.seconds == c.rest.seconds);
        assert_int_equal(back.rest.poses, c.rest.poses);
        assert_int_equal(back.has_mount, c.has_mount);
        if (c.has_mount)
            check_near("mount", back.tracker_from_body.y, c.tracker_from_body.y, 2e-16);
    }
    struct ap_device_calibration all[COUNT];
    int count = 0;
    assert_int_equal(ap_calibration_list(&err, dir, COUNT - 1, all, &count), AP_INPUT);
    assert_int_equal(ap_calibration_list(&err, dir, COUNT, all, &count), AP_OK);
    assert_int_equal(count, COUNT);
    assert_int_equal(ap_calibration_forget(&err, dir, keys[1], &found), AP_OK);
    assert_true(found);
    assert_int_equal(ap_calibration_forget(&err, dir, keys[1], &found), AP_OK);
    assert_false(found);
    assert_int_equal(ap_calibration_read(&err, dir, keys[1], &all[0], &found), AP_OK);
    assert_false(found);
    struct ap_device_calibration nobody = some_device("");
    assert_int_equal(ap_calibration_write(&err, dir, &nobody), AP_USAGE);
    struct ap_device_calibration bytes = some_device("\xff\xfe");
    assert_int_equal(ap_calibration_write(&err, dir, &bytes), AP_USAGE);
    char nowhere[64];
    snprintf(nowhere, sizeof nowhere, "%s/nowhere", dir);
    assert_int_equal(ap_calibration_list(&err, nowhere, COUNT, all, &count), AP_OK);
    assert_int_equal(count, 0);
}

static void refuse_room(const char *text, const char *what) {
    struct ap_error err = {""};
    struct ap_room_calibration room = {.rms_m = -1};
    char path[64];
    snprintf(path, sizeof path, "%s/room.json", dir);
    assert_int_equal(ap_file_write(&err, path, text, strlen(text)), AP_OK);
    assert_int_equal(ap_room_file_read(&err, path, &room), AP_INPUT);
    if (!strstr(err.text, what))
        fail_msg("'%s' says nothing of '%s'", err.text, what);
    assert_true(room.rms_m == -1);
}

#define TABLE "\"x_m\":0,\"z_m\":0,\"yaw_rad\":0,\"height_m\":0.7,\"edge_m\":0.9"

static void test_room(void **state) {
    (void)state;
    struct ap_error err = {""};
    const struct ap_room_calibration room = {{1.0 / 3, -2, -0.5, 0.74, 0.91}, 0.001};
    struct ap_room_calibration back;
    char path[64];
    snprintf(path, sizeof path, "%s/room.json", dir);
    if (ap_room_file_write(&err, path, &room) || ap_room_file_read(&err, path, &back))
        fail_msg("%s", err.text);
    assert_memory_equal(&back, &room, sizeof room);
    struct ap_room_calibration low = room;
    low.table.height_m = -0.2;
    assert_int_equal(ap_room_file_write(&err, path, &low), AP_INPUT);
    assert_int_equal(ap_room_file_read(&err, path, &back), AP_OK); // the old one is still there
    refuse_room("", "room.json");
    refuse_room("{\"version\":2,\"table\":{" TABLE ",\"rms_m\":0}}", "/version");
    refuse_room("{\"version\":1}", "/table");
    refuse_room("{\"version\":1,\"table\":{" TABLE "}}", "/table/rms_m");
    refuse_room("{\"version\":1,\"table\":{" TABLE ",\"rms_m\":0,\"more\":1}}", "/table/more");
    refuse_room("{\"version\":1,\"table\":{" TABLE ",\"rms_m\":1e999}}", "room.json");
    refuse_room("{\"version\":1,\"table\":{" TABLE ",\"rms_m\":2}}", "0 to 1");
}

static void test_bad_device_file(void **state) {
    (void)state;
    static const char *const texts[][2] = {
        {"{\"version\":1,\"device\":\"x\",\"mount\":{\"tracker_from_body\":[0,0,0,2]}}", "unit"},
        {"{\"version\":1,\"device\":\"x\",\"bias\":{}}", "/bias/gyro_rad_s"},
        {"{\"version\":1,\"device\":\"\"}", "/device"},
        {"{\"version\":7,\"device\":\"x\"}", "version 1, not 7"},
        {"[1]", "bad.json"},
    };
    char path[64];
    snprintf(path, sizeof path, "%s/devices/bad.json", dir);
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        struct ap_error err = {""};
        struct ap_device_calibration c = {.key = "untouched"};
        bool found;
        assert_int_equal(ap_file_write(&err, path, texts[i][0], strlen(texts[i][0])), AP_OK);
        assert_int_equal(ap_calibration_read(&err, dir, "bad", &c, &found), AP_INPUT);
        if (!strstr(err.text, texts[i][1]))
            fail_msg("'%s' says nothing of '%s'", err.text, texts[i][1]);
        assert_string_equal(c.key, "untouched");
    }
}

static int make(void **state) {
    (void)state;
    return mkdtemp(dir) ? 0 : -1;
}

static int clean(void **state) {
    (void)state;
    char command[80];
    snprintf(command, sizeof command, "rm -rf %s", dir);
    return system(command);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_devices),
        cmocka_unit_test(test_room),
        cmocka_unit_test(test_bad_device_file),
    };
    return cmocka_run_group_tests(tests, make, clean);
}
