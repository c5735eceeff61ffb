#include <inttypes.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "src/device/walk.h"

static const int64_t MS = 1000000;
static const char *const names[] = {"head", "left", "right"};

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Largest values along a device's way, from differences over 1 ms.
struct motion {
    double speed, acceleration, jerk;      // m/s, m/s², m/s³
    double turn_median, turn, turn_change; // degrees/s, degrees/s², greatest
    double low_y, high_y;
    double from_anchor_m, from_anchor_across_m; // in space, and on the floor
};

static double turn_between(struct ap_quat a, struct ap_quat b) {
    struct ap_quat d = ap_quat_mul(ap_quat_conj(a), b);
    return 2 * atan2(hypot(hypot(d.x, d.y), d.z), fabs(d.w)) * 180 / M_PI;
}

static void measure_anchor(const struct ap_walk_params *params, struct ap_vec3 p,
                           struct motion *m) {
    double half = params->table_edge_m / 2, y = p.y - params->table_height_m;
    double out = fmax(fabs(p.x), fabs(p.z)), across = 0;
    if (out > 0) // where the ray from the centre crosses the square
        across = hypot(p.x, p.z) * fabs(1 - half / out);
    m->from_anchor_across_m = fmax(m->from_anchor_across_m, across);
    m->from_anchor_m = fmax(m->from_anchor_m, hypot(across, y));
}

static struct motion measure(const struct ap_walk_params *params, int device) {
    int n = (int)(ap_walk_duration_s(params) * 1000);
    struct motion m = {.low_y = INFINITY};
    double *turns = malloc((size_t)n * sizeof *turns);
    struct ap_pose p[4];
    for (int i = 0; i < n; i++) {
        p[3] = ap_walk_at(params, device, i * MS).pose;
        measure_anchor(params, p[3].p, &m);
        m.low_y = fmin(m.low_y, p[3].p.y);
        m.high_y = fmax(m.high_y, p[3].p.y);
        turns[i] = 0;
        if (i >= 3) {
            struct ap_vec3 d1 = ap_vec3_sub(p[1].p, p[0].p), d2 = ap_vec3_sub(p[2].p, p[1].p),
                           d3 = ap_vec3_sub(p[3].p, p[2].p);
            struct ap_vec3 a1 = ap_vec3_sub(d2, d1), a2 = ap_vec3_sub(d3, d2);
            m.speed = fmax(m.speed, ap_vec3_length(d3) * 1e3);
            m.acceleration = fmax(m.acceleration, ap_vec3_length(a2) * 1e6);
            m.jerk = fmax(m.jerk, ap_vec3_length(ap_vec3_sub(a2, a1)) * 1e9);
            turns[i] = turn_between(p[2].q, p[3].q) * 1e3;
            m.turn = fmax(m.turn, turns[i]);
            m.turn_change = fmax(m.turn_change, fabs(turns[i] - turns[i - 1]) * 1e3 * (i > 3));
        }
        for (int k = 0; k < 3; k++)
            p[k] = p[k + 1];
    }
    qsort(turns, (size_t)n, sizeof *turns, compare);
    m.turn_median = turns[n / 2];
    free(turns);
    print_message("%s: %.2f m/s, %.1f m/s2, %.0f m/s3; turns %.0f, at most %.0f deg/s, %.0f "
                  "deg/s2; y %.2f to %.2f; %.2f m from its anchor, %.2f across\n",
                  names[device], m.speed, m.acceleration, m.jerk, m.turn_median, m.turn,
                  m.turn_change, m.low_y, m.high_y, m.from_anchor_m, m.from_anchor_across_m);
    return m;
}

static void check_below(const char *device, const char *what, double value, double limit) {
    if (!(value < limit))
        fail_msg("%s: %s is %g, expected below %g", device, what, value, limit);
}

static void check_human(const struct ap_walk_params *params) {
    for (int d = 0; d < 3; d++) {
        struct motion m = measure(params, d);
        check_below(names[d], "speed (m/s)", m.speed, d == 0 ? 1.05 : 2);
        check_below(names[d], "acceleration (m/s2)", m.acceleration, d == 0 ? 5 : 10);
        // A jump of velocity or acceleration between two milliseconds would give 1e3 times more.
        check_below(names[d], "jerk (m/s3)", m.jerk, 1200);
        check_below(names[d], "turning (deg/s)", m.turn, 250);
        check_below(names[d], "change of turning (deg/s2)", m.turn_change, 3000);
        check_below(names[d], "way across from the anchor (m)", m.from_anchor_across_m,
                    fmax(params->table_edge_m, 0.9));
        check_below(names[d], "way from the anchor (m)", m.from_anchor_m,
                    fmax(1.25, params->table_edge_m * 1.25));
        if (d == 0) {
            check_below(names[d], "lowest (m)", m.low_y, 1.3);
            check_below(names[d], "least height (m)", -m.low_y, -1.1);
            check_below(names[d], "greatest height (m)", m.high_y, 1.66);
            check_below(names[d], "median turning (deg/s)", m.turn_median, 45);
            check_below(names[d], "stillness", -m.turn_median, -5);
        }
    }
}

static void test_moves_like_a_person(void **unused) {
    (void)unused;
    const double edges[] = {0.9, 2, 0.7, 6};
    for (int i = 0; i < 4; i++) {
        struct ap_walk_params params = {
            .table_edge_m = edges[i], .table_height_m = 0.75, .seed = (uint64_t)i};
        check_human(&params);
    }
}

// The perimeter coordinate of the trackers, unwrapped: a lap has four edges, the walk visits five.
static void test_visits_five_edges(void **unused) {
    (void)unused;
    struct ap_walk_params params = {0};
    double c = 0, low = INFINITY, high = -INFINITY, stretch = 0;
    int64_t n = (int64_t)(ap_walk_duration_s(&params) * 90);
    assert_in_range(n, 20 * 90, 26 * 90);
    for (int64_t k = 0; k <= n; k++) {
        struct ap_vec3 p = ap_walk_at(&params, 0, k * 11111111).pose.p;
        double out = fmax(fabs(p.x), fabs(p.z)), x = p.x / out, z = p.z / out, at;
        if (z == -1)
            at = 0.5 - x / 2;
        else if (x == -1)
            at = 1.5 + z / 2;
        else if (z == 1)
            at = 2.5 + x / 2;
        else
            at = 3.5 - z / 2;
        double next = k == 0 ? at : c + remainder(at - c, 4);
        stretch = fmax(stretch, fabs(next - c) * (k > 0));
        c = next;
        low = fmin(low, c);
        high = fmax(high, c);
    }
    check_below("head", "step of c in a frame", stretch, 0.05);
    assert_true(floor(low) == 0 && floor(high) == 4);
}

static struct ap_vec3 shoulderward(struct ap_vec3 hand, struct ap_pose head) {
    // The shoulders' middle stands about 0.27 m under the eyes of a head held upright.
    struct ap_vec3 neck = ap_vec3_add(head.p, (struct ap_vec3){0, -0.27, 0});
    return ap_vec3_sub(hand, neck);
}

static void test_hands_are_on_arms(void **unused) {
    (void)unused;
    struct ap_walk_params params = {0};
    int on_edge = 0, along_cue = 0, trigger = 0, select = 0;
    for (int64_t t = 0; t < (int64_t)(ap_walk_duration_s(&params) * 1e9); t += 10 * MS) {
        struct ap_pose head = ap_walk_at(&params, 0, t).pose;
        struct ap_sample left = ap_walk_at(&params, 1, t), right = ap_walk_at(&params, 2, t);
        // 0.72 from the shoulder, which is at most 0.4 from where it is taken to be (bent over).
        check_below("left", "arm (m)", ap_vec3_length(shoulderward(left.pose.p, head)), 1.1);
        check_below("right", "arm (m)", ap_vec3_length(shoulderward(right.pose.p, head)), 1.1);
        struct ap_vec3 p = left.pose.p;
        on_edge += fabs(fmax(fabs(p.x), fabs(p.z)) - 0.45) < 0.12 && fabs(p.y - 0.78) < 0.05;
        struct ap_vec3 cue = ap_vec3_normalize(ap_vec3_sub(p, right.pose.p));
        struct ap_vec3 forward = ap_quat_rotate(right.pose.q, (struct ap_vec3){0, 0, -1});
        along_cue += ap_vec3_dot(cue, forward) > 0.998 && head.p.y < 1.25;
        trigger += right.trigger > 0.9f;
        select += right.select;
        assert_true(left.trigger == 0 && !left.select);
    }
    print_message("hundredths of seconds: %d at the edge, %d aiming, %d trigger, %d select\n",
                  on_edge, along_cue, trigger, select);
    assert_in_range(on_edge, 400, 2000);
    assert_in_range(along_cue, 200, 800);
    assert_in_range(trigger, 100, 400);
    assert_int_equal(select, 40);
}

static void test_is_a_function_of_its_arguments(void **unused) {
    (void)unused;
    struct ap_walk_params a = {0}, one = {.seed = 1, .table_edge_m = 0.9, .table_height_m = 0.75},
                          other = {.seed = 2};
    double apart = 0;
    for (int64_t t = 0; t < 20000 * MS; t += 777 * MS)
        for (int d = 0; d < 3; d++) {
            struct ap_pose p = ap_walk_at(&a, d, t).pose, q = ap_walk_at(&one, d, t).pose;
            assert_memory_equal(&p, &q, sizeof p);
            q = ap_walk_at(&other, d, t).pose;
            apart = fmax(apart, ap_vec3_length(ap_vec3_sub(p.p, q.p)));
        }
    assert_true(apart > 1e-4 && apart < 0.05);
    // Its ends hold, and a shorter walk is the beginning of the longer one.
    struct ap_walk_params brief = {.duration_s = 2};
    struct ap_pose end = ap_walk_at(&a, 0, 2000 * MS).pose;
    struct ap_pose held = ap_walk_at(&brief, 0, 9000 * MS).pose;
    assert_memory_equal(&end, &held, sizeof end);
    struct ap_pose before = ap_walk_at(&a, 0, INT64_MIN).pose, start = ap_walk_at(&a, 0, 0).pose;
    assert_memory_equal(&before, &start, sizeof start);
}

static void test_goes_on_for_ever(void **unused) {
    (void)unused;
    double round_s = ap_walk_duration_s(&(struct ap_walk_params){0});
    struct ap_walk_params params = {.duration_s = 100};
    for (int d = 0; d < 3; d++) {
        // Where the script begins again: no step, and the same place but for the sway.
        int64_t t = (int64_t)(round_s * 1e9);
        struct ap_pose a = ap_walk_at(&params, d, t - MS).pose;
        struct ap_pose b = ap_walk_at(&params, d, t + MS).pose;
        struct ap_pose start = ap_walk_at(&params, d, 0).pose;
        check_below(names[d], "step (m)", ap_vec3_length(ap_vec3_sub(a.p, b.p)), 1e-4);
        check_below(names[d], "way to the start", ap_vec3_length(ap_vec3_sub(b.p, start.p)), 0.03);
        check_below(names[d], "turn (deg)", turn_between(a.q, b.q), 0.05);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_moves_like_a_person),
        cmocka_unit_test(test_visits_five_edges),
        cmocka_unit_test(test_hands_are_on_arms),
        cmocka_unit_test(test_is_a_function_of_its_arguments),
        cmocka_unit_test(test_goes_on_for_ever),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
