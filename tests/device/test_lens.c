// The lens of a headset profile: read, written, refused, and what it does to tangents.

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "src/device/headset.h"

#define EYE(more)                                                                                  \
    "{\"resolution_px\": [10, 20], \"fov_rad\": {\"left\": -0.8, \"right\": 0.7, \"up\": 0.8, "    \
    "\"down\": -0.9}" more "}"
#define PROFILE(left, more)                                                                        \
    "{\"name\": \"x\", \"refresh_hz\": 90, \"ipd_m\": 0.06, \"eyes\": {\"left\": " EYE(            \
        left) ", \"right\": " EYE("") "}" more "}"

static enum ap_status parse(const char *text, struct ap_error *err, struct ap_headset_profile *p) {
    json_t *root = json_loads(text, 0, NULL);
    assert_non_null(root);
    struct ap_json_at at = ap_json_root(root, "file");
    enum ap_status st = ap_headset_parse(err, &at, p);
    json_decref(root);
    return st;
}

static void check(const struct ap_lens *l, double k1, double k2, double red, double blue) {
    if (l->k1 != k1 || l->k2 != k2 || l->red_scale != red || l->blue_scale != blue)
        fail_msg("lens %g %g %g %g, expected %g %g %g %g", l->k1, l->k2, l->red_scale,
                 l->blue_scale, k1, k2, red, blue);
}

static void read_and_written(void **state) {
    (void)state;
    struct ap_error err;
    struct ap_headset_profile p, back;
    assert_int_equal(parse(PROFILE("", ""), &err, &p), AP_OK);
    check(&p.eye[0].lens, 0, 0, 0, 0);
    const char *text = PROFILE(", \"lens\": {\"k1\": 0.3, \"k2\": -0.01}",
                               ", \"lens\": {\"k1\": 0.1, \"red_scale\": 0.99, "
                               "\"blue_scale\": 1.0123456789012345}");
    assert_int_equal(parse(text, &err, &p), AP_OK);
    check(&p.eye[0].lens, 0.3, -0.01, 1, 1); // its own, whole
    check(&p.eye[1].lens, 0.1, 0, 0.99, 1.0123456789012345);
    json_t *json = ap_headset_to_json(&p);
    assert_non_null(json);
    struct ap_json_at at = ap_json_root(json, "again");
    assert_int_equal(ap_headset_parse(&err, &at, &back), AP_OK);
    assert_memory_equal(p.eye, back.eye, sizeof p.eye);
    json_decref(json);
}

static void refusals(void **state) {
    (void)state;
    static const struct {
        const char *text, *error;
    } cases[] = {
        {PROFILE("", ", \"lens\": 1"), "/lens: expected an object"},
        {PROFILE("", ", \"lens\": {\"k3\": 1}"), "/lens/k3: unknown key"},
        {PROFILE("", ", \"lens\": {\"k1\": 11}"), "/lens/k1: expected -10 to 10"},
        {PROFILE("", ", \"lens\": {\"k1\": \"x\"}"), "/lens/k1: expected a number"},
        {PROFILE("", ", \"lens\": {\"red_scale\": 0}"), "/lens/red_scale: expected 0.5 to 2"},
        {PROFILE("", ", \"lens\": {\"blue_scale\": 2.1}"), "/lens/blue_scale: expected"},
        {PROFILE("", ", \"lens\": {\"k1\": -0.4}"), "/lens: k1 and k2 fold"},
        {PROFILE("", ", \"lens\": {\"k1\": -1, \"k2\": 0.4}"), "/lens: k1 and k2 fold"},
        {PROFILE(", \"lens\": {\"k2\": -1}", ""), "/eyes/left/lens: k1 and k2 fold"},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        struct ap_error err = {{0}};
        struct ap_headset_profile p;
        assert_int_equal(parse(cases[k].text, &err, &p), AP_INPUT);
        if (!strstr(err.text, cases[k].error))
            fail_msg("'%s', expected '%s'", err.text, cases[k].error);
    }
}

// Whatever is let through grows with the radius, for every k1 and k2 of a grid.
static void never_folds(void **state) {
    (void)state;
    int let = 0, refused = 0;
    double corner = hypot(tan(0.8), tan(0.9));
    for (double k1 = -2; k1 <= 2; k1 += 0.125)
        for (double k2 = -2; k2 <= 2; k2 += 0.125) {
            char text[700];
            snprintf(text, sizeof text, PROFILE("", ", \"lens\": {\"k1\": %g, \"k2\": %g}"), k1,
                     k2);
            struct ap_error err;
            struct ap_headset_profile p;
            bool ok = parse(text, &err, &p) == AP_OK, grows = true;
            struct ap_lens l = {k1, k2, 1, 1};
            for (int i = 1; i <= 2000; i++) {
                double r = corner * i / 2000, s = corner * (i - 1) / 2000;
                grows &= r * ap_lens_factor(&l, 1, r * r) > s * ap_lens_factor(&l, 1, s * s);
            }
            if (ok != grows)
                fail_msg("k1 %g k2 %g: let through %d, grows %d", k1, k2, ok, grows);
            let += ok;
            refused += !ok;
        }
    assert_true(let > 100 && refused > 100);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(read_and_written),
        cmocka_unit_test(refusals),
        cmocka_unit_test(never_folds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
