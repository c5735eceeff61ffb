#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "src/device/handlog.h"
#include "tests/device/memory_file.h"

#define HEADER "t_ns,hand,joint,px,py,pz,qx,qy,qz,qw,radius\n"

static struct ap_handlog *read_text(const char *text) {
    struct memory_file file = memory_text(text);
    struct ap_handlog *log = NULL;
    struct ap_error err;
    if (ap_handlog_read(&err, file.path, &log))
        fail_msg("%s", err.text);
    close(file.fd);
    return log;
}

// All joints of a hand at a time, at x and above one another.
static size_t add_frame(char *text, size_t at, int64_t t_ns, const char *hand, double x,
                        int without) {
    for (int j = 0; j < AP_JOINT_COUNT; j++)
        if (j != without)
            at += (size_t)sprintf(text + at, "%lld,%s,%s,%g,%d,0,0,0,0,1,0.01\n", (long long)t_ns,
                                  hand, ap_joint_name(j), x, j);
    return at;
}

static void csv_is_read_and_interpolated(void **unused) {
    (void)unused;
    static char text[65536] = HEADER "# a comment\n\n";
    size_t at = strlen(text);
    at = add_frame(text, at, 100, "left", 1, -1);
    at = add_frame(text, at, 100, "right", -1, -1);
    at = add_frame(text, at, 50000100, "left", 2, AP_JOINT_PALM);
    add_frame(text, at, 900000000, "left", 3, -1);
    struct ap_handlog *log = read_text(text);
    assert_int_equal(ap_handlog_count(log, AP_HAND_LEFT), 3);
    assert_int_equal(ap_handlog_count(log, AP_HAND_RIGHT), 1);
    assert_int_equal(ap_handlog_count(log, 2), 0);
    struct ap_hand h;
    assert_int_equal(ap_handlog_at(log, AP_HAND_LEFT, 99, &h), AP_POSE_NONE);
    assert_int_equal(ap_handlog_at(log, 7, 100, &h), AP_POSE_NONE);
    assert_int_equal(ap_handlog_at(log, AP_HAND_LEFT, 100, &h), AP_POSE_EXACT);
    assert_true(h.joint[25].pose.p.x == 1 && h.joint[25].pose.p.y == 25);
    assert_true(h.joint[0].pose.p.y == 0 && h.joint[0].radius_m == 0.01);
    assert_int_equal(ap_handlog_at(log, AP_HAND_LEFT, 25000100, &h), AP_POSE_INTERPOLATED);
    assert_true(fabs(h.joint[7].pose.p.x - 1.5) < 1e-15);
    // Without a palm: the middle of the middle finger's metacarpal.
    assert_int_equal(ap_handlog_at(log, AP_HAND_LEFT, 50000100, &h), AP_POSE_EXACT);
    assert_true(h.joint[0].pose.p.y == 11.5);
    assert_int_equal(ap_handlog_at(log, AP_HAND_LEFT, 60000000, &h), AP_POSE_LOST);
    assert_true(h.joint[7].pose.p.x == 2);
    assert_int_equal(ap_handlog_at(log, AP_HAND_LEFT, INT64_MAX, &h), AP_POSE_LOST);
    assert_int_equal(ap_handlog_at(log, AP_HAND_RIGHT, 101, &h), AP_POSE_LOST);
    assert_int_equal(ap_handlog_at(log, AP_HAND_RIGHT, INT64_MIN, &h), AP_POSE_NONE);
    ap_handlog_destroy(log);
}

#define ROW "1,left,wrist,0,0,0,0,0,0,1,0.01\n"

static void bad(const char *text, const char *expected) {
    struct memory_file file = memory_text(text);
    struct ap_handlog *log = NULL;
    struct ap_error err = {""};
    assert_int_equal(ap_handlog_read(&err, file.path, &log), AP_INPUT);
    assert_null(log);
    if (!strstr(err.text, expected))
        fail_msg("'%s', expected '%s'", err.text, expected);
    close(file.fd);
}

static void csv_errors_name_their_place(void **unused) {
    (void)unused;
    bad("", "holds no hand");
    bad(HEADER, "holds no hand");
    bad("t_ns,hand\n", ":1:1: expected the header");
    bad(HEADER "1,left\n", ":2:7: expected 11 fields");
    bad(HEADER "1.5,left,wrist,0,0,0,0,0,0,1,0.01\n", ":2:1: expected");
    bad(HEADER "1,both,wrist,0,0,0,0,0,0,1,0.01\n", ":2:3: expected left or right");
    bad(HEADER "1,left,elbow,0,0,0,0,0,0,1,0.01\n", ":2:8: expected a joint");
    bad(HEADER "1,left,wrist,nan,0,0,0,0,0,1,0.01\n", ":2:14: expected");
    bad(HEADER "1,left,wrist,0,0,0,0,0,0,0,0.01\n", ":2:20: expected");
    bad(HEADER "1,left,wrist,0,0,0,0,0,0,1,-1\n", "expected a radius");
    bad(HEADER ROW ROW, ":3:1: expected each joint once");
    bad(HEADER ROW, "there is no thumb_metacarpal");
    static char text[65536] = HEADER;
    size_t at = add_frame(text, strlen(text), 7, "right", 0, -1);
    add_frame(text, at, 6, "right", 0, -1);
    bad(text, "expected a time after the right hand's last one");
    struct ap_handlog *log;
    struct ap_error err;
    assert_int_equal(ap_handlog_read(&err, "/nowhere/hands.csv", &log), AP_INPUT);
}

// Two frames of a right hand; its ray is turned by a quarter about y and lifted by one.
static char *iwer(const char *ray, const char *joint, int joints) {
    static char text[65536];
    size_t at = (size_t)sprintf(
        text, "{\"schema\": [[4, {\"handedness\": \"right\", \"hasGrip\": true, "
              "\"hasHand\": true}], [1, {\"handedness\": \"left\"}]], \"frames\": [");
    for (int k = 0; k < 2; k++) {
        at += (size_t)sprintf(text + at,
                              "%s[%d.5, 0,0,0,0,0,0,1, [1, 0,0,0,0,0,0,1], [4, %s, "
                              "[0,0,0,0,0,0,1], [",
                              k ? "," : "", 1000 + 11 * k, ray);
        for (int j = 0; j < joints; j++)
            at += (size_t)sprintf(text + at, "%s%s", j ? "," : "", joint);
        at += (size_t)sprintf(text + at, "]]]");
    }
    sprintf(text + at, "]}");
    return text;
}

static void iwer_joints_stand_against_the_ray(void **unused) {
    (void)unused;
    struct ap_handlog *log =
        read_text(iwer("0,1,0,0,0.7071,0,0.7071", "0.1,0,-0.2,0,0,0,1,0.02", 25));
    assert_int_equal(ap_handlog_count(log, AP_HAND_LEFT), 0);
    assert_int_equal(ap_handlog_count(log, AP_HAND_RIGHT), 2);
    struct ap_hand h;
    assert_int_equal(ap_handlog_at(log, AP_HAND_RIGHT, 11000000, &h), AP_POSE_EXACT);
    assert_int_equal(ap_handlog_at(log, AP_HAND_RIGHT, 0, &h), AP_POSE_EXACT);
    for (int j = 0; j < AP_JOINT_COUNT; j++) {
        struct ap_vec3 p = h.joint[j].pose.p; // a quarter about +y: x goes to -z, z to x
        if (!(fabs(p.x + 0.2) < 1e-12 && fabs(p.y - 1) < 1e-12 && fabs(p.z + 0.1) < 1e-12))
            fail_msg("joint %d at %.15g %.15g %.15g, expected -0.2 1 -0.1", j, p.x, p.y, p.z);
        assert_true(h.joint[j].radius_m == 0.02);
    }
    ap_handlog_destroy(log);
}

static void iwer_errors_name_their_place(void **unused) {
    (void)unused;
    const char *ray = "0,0,0,0,0,0,1", *joint = "0,0,0,0,0,0,1,0.01";
    bad("{}", "/schema: expected a list");
    bad("{\"schema\": [3]}", "/schema/0: expected [index, {");
    bad("{\"schema\": [[0, {\"hasHand\": true}]]}", "/schema/0/1/handedness");
    bad("{\"schema\": [[0, {\"hasHand\": true, \"handedness\": \"left\", "
        "\"jointSequence\": [\"wrist\"]}]]}",
        "/schema/0/1/jointSequence: expected WebXR's 25 joints");
    bad("{\"schema\": [[0, {}]]}", "/frames: expected");
    bad("{\"schema\": [[0, {}]], \"frames\": []}", "holds no hand");
    bad("{\"schema\": [[0, {}]], \"frames\": [[\"x\"]]}", "/frames/0/0: expected a time");
    bad("{\"schema\": [[0, {}]], \"frames\": [[1,0,0,0,0,0,0,1,[3]]]}", "/frames/0/8/0: expected");
    bad(iwer(ray, joint, 24), "/frames/0/9/9: expected 200 numbers");
    bad(iwer("0,0,0,0,0,0,3", joint, 25), "/frames/0/9/4: expected a unit quaternion");
    bad(iwer(ray, "0,0,null,0,0,0,1,0.01", 25), "/frames/0/9/9/2: expected a number");
    bad(iwer(ray, "0,0,0,0,0,0,1,5", 25), "/frames/0/9/9/7: expected a radius");
}

static void a_real_recording(void **unused) {
    (void)unused;
    const char *shared = getenv("ANTIPODE_SHARED");
    if (!shared) {
        fprintf(stderr, "skipped: ANTIPODE_SHARED is not set\n");
        skip();
    }
    char path[1024];
    snprintf(path, sizeof path, "%s/data/poses/quest3_iwer.json", shared);
    struct ap_handlog *log = NULL;
    struct ap_error err;
    if (ap_handlog_read(&err, path, &log))
        fail_msg("%s", err.text);
    assert_int_equal(ap_handlog_count(log, AP_HAND_LEFT), 667);
    assert_int_equal(ap_handlog_count(log, AP_HAND_RIGHT), 756);
    // Bare hands from 10.65 s on; bones keep their lengths, and the head is 1.3 m up.
    struct ap_hand h;
    assert_int_equal(ap_handlog_at(log, AP_HAND_LEFT, 10000000000, &h), AP_POSE_NONE);
    for (int64_t t = 10700000000; t < 14000000000; t += 100000000) {
        enum ap_pose_state st = ap_handlog_at(log, AP_HAND_RIGHT, t, &h);
        assert_true(st == AP_POSE_EXACT || st == AP_POSE_INTERPOLATED);
        double bone = ap_vec3_length(
            ap_vec3_sub(h.joint[AP_JOINT_INDEX + 2].pose.p, h.joint[AP_JOINT_INDEX + 1].pose.p));
        if (fabs(bone - 0.038) > 0.003)
            fail_msg("index finger's first bone %.4f m, expected 0.038 within 0.003", bone);
        assert_true(h.joint[0].pose.p.y > 0.5 && h.joint[0].pose.p.y < 2);
        // -z leads to the tip.
        struct ap_vec3 on =
            ap_quat_rotate(h.joint[AP_JOINT_INDEX + 1].pose.q, (struct ap_vec3){0, 0, -bone});
        on = ap_vec3_add(on, h.joint[AP_JOINT_INDEX + 1].pose.p);
        double off = ap_vec3_length(ap_vec3_sub(on, h.joint[AP_JOINT_INDEX + 2].pose.p));
        if (off > 0.003)
            fail_msg("the bone's -z misses the next joint by %.4f m, tolerance 0.003", off);
    }
    ap_handlog_destroy(log);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(csv_is_read_and_interpolated),
        cmocka_unit_test(csv_errors_name_their_place),
        cmocka_unit_test(iwer_joints_stand_against_the_ray),
        cmocka_unit_test(iwer_errors_name_their_place),
        cmocka_unit_test(a_real_recording),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
