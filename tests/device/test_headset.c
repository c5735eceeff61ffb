#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "src/device/headset.h"
#include "tests/device/memory_file.h"

static void check_equal(const struct ap_headset_profile *a, const struct ap_headset_profile *b) {
    assert_string_equal(a->name, b->name);
    assert_true(a->refresh_hz == b->refresh_hz && a->ipd_m == b->ipd_m);
    assert_memory_equal(a->eye, b->eye, sizeof a->eye);
    assert_memory_equal(&a->grip_from_aim, &b->grip_from_aim, sizeof a->grip_from_aim);
}

static struct ap_headset_profile read_shipped(const char *name) {
    const char *source = getenv("ANTIPODE_SOURCE");
    char path[1024];
    snprintf(path, sizeof path, "%s/src/device/headsets/%s.json", source ? source : ".", name);
    struct ap_error err;
    struct ap_headset_profile profile = {0};
    if (ap_headset_read(&err, path, &profile))
        fail_msg("%s", err.text);
    return profile;
}

static void check_round_trip(const struct ap_headset_profile *profile) {
    json_t *json = ap_headset_to_json(profile);
    assert_non_null(json);
    // Through the text, as between two processes.
    char *text = json_dumps(json, 0);
    json_t *again = json_loads(text, 0, NULL);
    struct ap_json_at at = ap_json_root(again, "again");
    struct ap_error err;
    struct ap_headset_profile back = {0};
    if (ap_headset_parse(&err, &at, &back))
        fail_msg("%s", err.text);
    check_equal(profile, &back);
    free(text);
    json_decref(json);
    json_decref(again);
}

static void test_shipped_profiles(void **unused) {
    (void)unused;
    const char *const names[] = {"standard", "wide", "ci"};
    for (int i = 0; i < 3; i++) {
        struct ap_headset_profile p = read_shipped(names[i]);
        assert_string_equal(p.name, names[i]);
        check_round_trip(&p);
        // The eyes mirror each other, and pixels are square within 2 %.
        const struct ap_eye_profile *l = &p.eye[0], *r = &p.eye[1];
        assert_true(l->left_rad == -r->right_rad && l->right_rad == -r->left_rad);
        assert_true(l->yaw_rad == -r->yaw_rad);
        double across = l->width_px / (tan(l->right_rad) - tan(l->left_rad));
        double down = l->height_px / (tan(l->up_rad) - tan(l->down_rad));
        if (fabs(across / down - 1) > 0.02)
            fail_msg("%s: %g and %g pixels per unit of tangent (2 %%)", names[i], across, down);
    }
    struct ap_headset_profile standard = read_shipped("standard"), ci = read_shipped("ci");
    struct ap_headset_profile builtin = ap_headset_builtin();
    check_equal(&standard, &builtin);
    assert_true(ci.eye[0].width_px <= 400 && ci.eye[0].height_px <= 400);
    assert_true(read_shipped("wide").eye[0].yaw_rad > 0);
}

static void test_odd_numbers_survive(void **unused) {
    (void)unused;
    struct ap_headset_profile p = ap_headset_builtin();
    p.refresh_hz = 59.94005994005994;
    p.ipd_m = 0.1 + 0.2;
    p.eye[0].left_rad = -1e-300;
    p.eye[1].yaw_rad = -1.0 / 3;
    p.eye[1].width_px = 16384;
    p.grip_from_aim = (struct ap_pose){{0.1, -0.2, 1.0 / 3}, {0.6, 0, 0, 0.8}};
    check_round_trip(&p);
}

#define EYE                                                                                        \
    "{\"resolution_px\": [10, 20], \"fov_rad\": {\"left\": -1, \"right\": 1, \"up\": 1, "          \
    "\"down\": -1}}"
#define EYES "\"eyes\": {\"left\": " EYE ", \"right\": " EYE "}"
#define FOV(left, right, up, down)                                                                 \
    "{\"name\": \"x\", \"refresh_hz\": 90, \"ipd_m\": 0.06, \"eyes\": {\"left\": "                 \
    "{\"resolution_px\": [1, 1], \"fov_rad\": {\"left\": " left ", \"right\": " right              \
    ", \"up\": " up ", \"down\": " down "}}, \"right\": " EYE "}}"
#define SIZE(size)                                                                                 \
    "{\"name\": \"x\", \"refresh_hz\": 90, \"ipd_m\": 0.06, \"eyes\": {\"right\": "                \
    "{\"resolution_px\": " size "}, \"left\": " EYE "}}"
#define HIDDEN(ellipse) FOV("-1", "1", "1", "-1}, \"hidden_area\": {\"outside_ellipse\": " ellipse)
#define AIM(aim)                                                                                   \
    "{\"name\": \"x\", \"refresh_hz\": 90, \"ipd_m\": 0.06, " EYES ", \"grip_from_aim\": " aim "}"

static void test_refusals(void **unused) {
    (void)unused;
    const struct {
        const char *text, *error;
    } cases[] = {
        {"[]", ": /: expected an object"},
        {"{\"name\": 1}", ": /name: expected a string"},
        {"{\"name\": \"\"}", ": /name: expected a name"},
        {"{\"name\": \"a\\nb\"}", ": /name: expected a name without control"},
        {"{\"nam\": \"x\"}", ": /nam: unknown key"},
        {"{\"name\": \"x\", \"refresh_hz\": 0}", ": /refresh_hz: expected a rate above 0"},
        {"{\"name\": \"x\", \"refresh_hz\": -90}", ": /refresh_hz: expected a rate above 0"},
        {"{\"name\": \"x\", \"refresh_hz\": 90}", ": /ipd_m: expected a number"},
        {"{\"name\": \"x\", \"refresh_hz\": 90, \"ipd_m\": 0}", ": /ipd_m: expected metres"},
        {"{\"name\": \"x\", \"refresh_hz\": 90, \"ipd_m\": 0.06}", ": /eyes: expected an object"},
        {SIZE("[0, 5]"), ": /eyes/right/resolution_px/0: expected a whole number"},
        {SIZE("[5, 16385]"), ": /eyes/right/resolution_px/1: expected a whole number"},
        {SIZE("[5, 5.5]"), ": /eyes/right/resolution_px/1: expected a whole number"},
        {SIZE("[5]"), ": /eyes/right/resolution_px: expected [width, height]"},
        {SIZE("7"), ": /eyes/right/resolution_px: expected [width, height]"},
        {SIZE("[5, 5]"), ": /eyes/right/fov_rad: expected an object"},
        {FOV("-1.5708", "1", "1", "-1"), ": /eyes/left/fov_rad/left: expected an angle"},
        {FOV("-1", "1", "1e400", "-1"), ""},
        {FOV("1", "1", "1", "-1"), ": /eyes/left/fov_rad: expected left < right"},
        {FOV("-1", "1", "-1", "1"), ": /eyes/left/fov_rad: expected down < up"},
        {FOV("-1", "1", "1", "-1, \"x\": 0"), ": /eyes/left/fov_rad/x: unknown key"},
        {HIDDEN("[0, 0, 1]"), ": /eyes/left/hidden_area/outside_ellipse: expected an array of 4"},
        {HIDDEN("[0, 0, 0, 1]"), ": /eyes/left/hidden_area/outside_ellipse: expected radii"},
        {HIDDEN("[0, 0, 1, 1e9]"), ": /eyes/left/hidden_area/outside_ellipse: expected radii"},
        {HIDDEN("[0, 2, 1, 1]"), ": /eyes/left/hidden_area/outside_ellipse: expected a center"},
        {AIM("{\"rotate\": [0, 0, 0, 2]}"), ": /grip_from_aim/rotate: expected a unit quaternion"},
        {AIM("{\"rotate\": [0, 0, 1]}"), ": /grip_from_aim/rotate: expected an array of 4"},
        {AIM("{\"position_m\": [0, 0, 3]}"), ": /grip_from_aim/position_m: expected an offset"},
        {AIM("1"), ": /grip_from_aim: expected an object"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct memory_file file = memory_text(cases[i].text);
        struct ap_error err = {""};
        struct ap_headset_profile profile;
        memset(&profile, 0x5a, sizeof profile);
        assert_int_equal(ap_headset_read(&err, file.path, &profile), AP_INPUT);
        if (!strstr(err.text, cases[i].error))
            fail_msg("'%s', expected '%s'", err.text, cases[i].error);
        assert_int_equal(profile.name[0], 0x5a); // untouched
        close(file.fd);
    }
}

static void test_eyes_and_aim(void **unused) {
    (void)unused;
    struct ap_headset_profile p = ap_headset_builtin();
    p.eye[1].yaw_rad = M_PI_2 / 3;
    struct ap_pose left = ap_headset_view_from_eye(&p, 0), right = ap_headset_view_from_eye(&p, 1);
    assert_true(left.p.x == -0.032 && left.p.y == 0 && left.p.z == 0 && left.q.w == 1);
    // Counterclockwise from above: the right eye, turned by +30°, looks toward −x.
    struct ap_vec3 ahead = ap_quat_rotate(right.q, (struct ap_vec3){0, 0, -1});
    assert_true(right.p.x == 0.032 && fabs(ahead.x + 0.5) < 1e-15 && ahead.z < 0);

    struct ap_pose grip = {{1, 2, 3}, {0, 0.6, 0, 0.8}};
    struct ap_pose aim = ap_headset_aim(&p, grip);
    assert_memory_equal(&aim, &grip, sizeof aim);
    p.grip_from_aim.p.z = -0.05; // 5 cm ahead of the grip, along its −z
    aim = ap_headset_aim(&p, grip);
    struct ap_vec3 way = ap_vec3_sub(aim.p, grip.p);
    struct ap_vec3 forward = ap_quat_rotate(grip.q, (struct ap_vec3){0, 0, -1});
    assert_true(fabs(ap_vec3_dot(way, forward) - 0.05) < 1e-15);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_shipped_profiles),
        cmocka_unit_test(test_odd_numbers_survive),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_eyes_and_aim),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
