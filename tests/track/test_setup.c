#include <string.h>

#include "tests/track/support.h"

// Radius, edge and table place, as the command line's rules have them.

static enum ap_status setup(struct ap_error *err, const char *space, double radius_m,
                            enum ap_tracker_kind kind, double edge_m,
                            struct ap_tracker_params *params) {
    const struct ap_track_setup s = {.space = space,
                                     .radius_m = radius_m,
                                     .tracker = kind,
                                     .table_edge_m = edge_m,
                                     .table_height_m = 0.75};
    *err = (struct ap_error){""};
    return ap_track_setup(err, &s, params);
}

static void check(const char *space, double radius_m, enum ap_tracker_kind kind, double edge_m,
                  double expected_radius_m, double expected_edge_m) {
    struct ap_error err;
    struct ap_tracker_params p;
    if (setup(&err, space, radius_m, kind, edge_m, &p))
        fail_msg("%s", err.text);
    if (!(fabs(p.space.rho_m - expected_radius_m) <= 1e-14 &&
          fabs(p.table_edge_m - expected_edge_m) <= 1e-14))
        fail_msg("%s radius %g edge %g: radius %.17g, edge %.17g, expected %.17g, %.17g", space,
                 radius_m, edge_m, p.space.rho_m, p.table_edge_m, expected_radius_m,
                 expected_edge_m);
}

static void rules(void **state) {
    (void)state;
    const double s3_m = 0.572957795130823, h3_m = 0.848036510331695;
    for (int kind = 0; kind < 3; kind++) {
        enum ap_tracker_kind k = (enum ap_tracker_kind)kind;
        // The table's radius for its edge; in e3 1 m.
        check("s3", NAN, k, NAN, s3_m, 0.9);
        check("h3", NAN, k, NAN, h3_m, 0.9);
        check("h3", NAN, k, 1.8, 2 * h3_m, 1.8);
        check("e3", NAN, k, NAN, 1, 0.9);
        check("e3", 2, k, 1.2, 2, 1.2);
        check("e3", 2, k, NAN, 2, 0.9);
        // A given radius sets the edge.
        check("s3", 2, k, NAN, 2, 3.141592653589793);
        check("h3", 2, k, NAN, 2, 2 * 1.0612750619050357);
    }
    check("h3", h3_m, AP_TRACKER_BILLIARDS, 0.9 + 5e-10, h3_m, 0.9);
    check("h3", 3, AP_TRACKER_ANCHOR, 0.9, 3, 0.9);
}

static void refusals(void **state) {
    (void)state;
    struct ap_error err;
    struct ap_tracker_params p;
    assert_int_equal(setup(&err, "h3", 0.85, AP_TRACKER_BILLIARDS, 0.9, &p), AP_USAGE);
    assert_non_null(strstr(err.text, "--table-edge 0.9"));
    assert_int_equal(setup(&err, "s3", 0.5729577951, AP_TRACKER_BILLIARDS, 0.9, &p), AP_OK);
    assert_int_equal(setup(&err, "s3", 0.572957, AP_TRACKER_BILLIARDS, 0.9, &p), AP_USAGE);
    assert_int_equal(setup(&err, "h3", 0, AP_TRACKER_NAIVE, NAN, &p), AP_USAGE);
    assert_int_equal(setup(&err, "h3", -1, AP_TRACKER_NAIVE, NAN, &p), AP_USAGE);
    assert_int_equal(setup(&err, "h3", INFINITY, AP_TRACKER_NAIVE, NAN, &p), AP_USAGE);
    assert_int_equal(setup(&err, "h3", NAN, AP_TRACKER_NAIVE, 0, &p), AP_USAGE);
    assert_int_equal(setup(&err, "h3", NAN, AP_TRACKER_NAIVE, -0.9, &p), AP_USAGE);
    assert_int_equal(setup(&err, "e3", NAN, AP_TRACKER_BILLIARDS, INFINITY, &p), AP_USAGE);
    assert_int_equal(setup(&err, "h4", NAN, AP_TRACKER_NAIVE, NAN, &p), AP_USAGE);
    const struct ap_track_setup no_height = {
        .space = "h3", .radius_m = NAN, .table_edge_m = NAN, .table_height_m = NAN};
    assert_int_equal(ap_track_setup(&err, &no_height, &p), AP_USAGE);
    struct ap_track_setup anchored = {.space = "h3",
                                      .radius_m = NAN,
                                      .tracker = AP_TRACKER_ANCHOR,
                                      .table_edge_m = NAN,
                                      .anchor = "left"};
    assert_int_equal(ap_track_setup(&err, &anchored, &p), AP_OK);
    assert_string_equal(p.anchor, "left");
    anchored.anchor =
        "a name of more than sixty-three bytes, which no device in any log will ever have";
    assert_int_equal(ap_track_setup(&err, &anchored, &p), AP_USAGE);
    anchored.anchor = "";
    assert_int_equal(ap_track_setup(&err, &anchored, &p), AP_USAGE);
    anchored.anchor = "head";
    anchored.tracker = AP_TRACKER_NAIVE;
    assert_int_equal(ap_track_setup(&err, &anchored, &p), AP_USAGE);
}

static void names(void **state) {
    (void)state;
    for (int kind = 0; kind < 3; kind++) {
        enum ap_tracker_kind again;
        const char *name = ap_tracker_kind_name((enum ap_tracker_kind)kind);
        assert_int_equal(ap_tracker_kind_from_name(NULL, name, &again), AP_OK);
        assert_int_equal(again, kind);
    }
    enum ap_tracker_kind none;
    assert_int_equal(ap_tracker_kind_from_name(NULL, "Anchor", &none), AP_USAGE);
}

static void table_at(void **state) {
    (void)state;
    double x, z, yaw;
    assert_int_equal(ap_table_at_parse(NULL, "1.5,-2e-1,3", &x, &z, &yaw), AP_OK);
    assert_true(x == 1.5 && z == -0.2 && yaw == 3);
    static const char *const bad[] = {"",        "1",         "1,2",     "1,2,",    "1,2,3,",
                                      "1,2,3,4", "1, 2,3",    "nan,0,0", "1,2,0x1", ",,",
                                      "1,,2",    "1e999,0,0", "1;2;3"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        if (ap_table_at_parse(NULL, bad[i], &x, &z, &yaw) != AP_USAGE)
            fail_msg("'%s' was taken for a table's place", bad[i]);
    assert_true(x == 1.5 && z == -0.2 && yaw == 3);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rules),
        cmocka_unit_test(refusals),
        cmocka_unit_test(names),
        cmocka_unit_test(table_at),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
