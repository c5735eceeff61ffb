#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "src/geom/cells.h"
#include "src/track/tracker.h"
#include "tests/track/exact.h"

// Long walks through the cells of h3: what `replay` and `play` do (ap_room_follow), against 448-bit
// arithmetic where steps are given, and by cells out and back where the end is known.

static struct ap_tiling tiling;
static struct ap_pairing pairing;
static struct ap_deep_iso deep_step[AP_CELL_FACES];

static double noise(uint64_t *seed) {
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(*seed >> 11) * 0x1p-52 - 1;
}

static void open_tiling(struct ap_symbol symbol, double rho_m) {
    struct ap_error err = {""};
    struct ap_space space = {-1, rho_m};
    if (ap_tiling_init(&err, symbol, space, 0, &tiling))
        fail_msg("%s", err.text);
    ap_pairing_find(&tiling, &pairing);
    assert_true(ap_deep_steps(&tiling, &pairing, deep_step));
}

static struct ap_tracker *open_tracker(bool deep) {
    struct ap_tracker_params params = {
        .kind = AP_TRACKER_ANCHOR, .space = tiling.space, .deep = deep};
    struct ap_tracker *tracker;
    assert_int_equal(ap_tracker_create(NULL, &params, &tracker), AP_OK);
    return tracker;
}

static struct ap_iso feed(struct ap_tracker *tracker, struct ap_pose pose) {
    bool row;
    struct ap_iso m;
    assert_int_equal(ap_tracker_feed(NULL, tracker, "head", pose, &row, &m), AP_OK);
    assert_true(row);
    return m;
}

static void cross(struct ap_tracker *tracker, int back, bool deep, struct ap_iso *head) {
    const struct ap_iso *step = &pairing.cell_from_neighbour[back];
    assert_int_equal(
        ap_tracker_rebase(NULL, tracker, step, &pairing.low[back], deep ? &deep_step[back] : NULL),
        AP_OK);
    *head = ap_iso_mul(*step, *head);
}

// A step of each pairing and the one back are the identity, to a step of the arithmetic; the sum of
// two doubles is the same step.
static void steps_are_isometries_to_the_last_bit(void **state) {
    (void)state;
    static const struct ap_symbol symbols[] = {{5, 3, 4}, {4, 3, 5}, {3, 5, 3}, {5, 3, 5}};
    for (size_t s = 0; s < 4; s++) {
        open_tiling(symbols[s], 1.7);
        double open = 0, apart = 0;
        for (int f = 0; f < tiling.face_count; f++) {
            struct ap_deep_iso home = ap_deep_mul(&deep_step[f], &deep_step[pairing.to[f]]);
            struct ap_iso high, low;
            for (int i = 0; i < 4; i++)
                for (int j = 0; j < 4; j++) {
                    struct ap_fixed one = ap_fixed_of(i == j);
                    open = fmax(open, fabs(ap_fixed_round(ap_fixed_sub(home.m[i][j], one)).hi));
                }
            ap_deep_round(&deep_step[f], &high, &low);
            for (int i = 0; i < 16; i++) {
                double far = high.m[i / 4][i % 4] - pairing.cell_from_neighbour[f].m[i / 4][i % 4];
                far += low.m[i / 4][i % 4] - pairing.low[f].m[i / 4][i % 4];
                apart = fmax(apart, fabs(far));
            }
        }
        print_message("{%d,%d,%d}: there and back %.1e, from double-double %.1e\n", symbols[s].p,
                      symbols[s].q, symbols[s].r, open, apart);
        if (!(open < 1e-62) || !(apart < 1e-28))
            fail_msg("there and back %g (1e-62), from double-double %g (1e-28)", open, apart);
    }
}

// Steps that are given, out to 100 rho: each rounding made at the start is 3e43 times as large at
// the end.
static void blind_walks_are_exact_to_a_hundred_rho(void **state) {
    (void)state;
    open_tiling((struct ap_symbol){5, 3, 4}, 1.3);
    struct ap_tracker_params params = {.kind = AP_TRACKER_ANCHOR, .space = tiling.space};
    struct exact *exact = exact_create(&params);
    struct ap_tracker *tracker = open_tracker(true);
    uint64_t seed = 5;
    struct ap_pose pose = {{0.1, 0.2, 0.3}, {0.1, -0.2, 0.05, 0.9}};
    double worst = 0;
    int crossed = 0;
    for (int i = 0; i < 1010; i++) {
        struct ap_iso head = feed(tracker, pose);
        exact_feed(exact, "head", pose);
        struct ap_vec4 base = {0, 0, 0, tiling.space.rho_m};
        int face;
        while ((face = ap_cells_left_by(&tiling, ap_iso_apply(&head, base))) >= 0) {
            cross(tracker, pairing.to[face], true, &head);
            exact_cross_534(exact, tiling.face_out[face]);
            crossed++;
        }
        // The pose that the tracker holds now, as a device at the same place.
        assert_true(ap_tracker_place(tracker, pose, &head));
        worst = fmax(worst, exact_miss(exact, &head, NULL));
        pose.p.x += 0.004 * noise(&seed);
        pose.p.z -= 0.13; // 0.1 rho
        pose.q.x += 0.01 * noise(&seed);
        pose.q.y += 0.01 * noise(&seed);
    }
    print_message("%d faces crossed; at most %.1e off\n", crossed, worst);
    assert_true(crossed > 80);
    if (!(worst < 2e-14))
        fail_msg("off by %g, more than 2e-14", worst);
    exact_destroy(exact);
    ap_tracker_destroy(tracker);
}

// From where one is to the middle of the neighbour across a face, which becomes the world's frame.
static void go(struct ap_tracker *tracker, struct ap_pose pose, int face, bool deep) {
    struct ap_space space = tiling.space;
    struct ap_iso head, way;
    assert_true(ap_tracker_place(tracker, pose, &head));
    way = ap_iso_mul(ap_iso_inverse(space, head), pairing.cell_from_neighbour[face]);
    struct ap_vec4 middle = ap_iso_apply(&way, (struct ap_vec4){0, 0, 0, space.rho_m});
    struct ap_pose motion = {ap_log_unchecked(space, middle, 0), {0, 0, 0, 1}};
    assert_int_equal(ap_tracker_carry(NULL, tracker, pose, motion), AP_OK);
    cross(tracker, pairing.to[face], deep, &head);
}

// A word of cells out and back: steered walks are exact at any distance, in any arithmetic that
// keeps to the cell. What is left is one rounding of a direction a step, which nothing enlarges.
static void words_of_cells_close(void **state) {
    (void)state;
    enum { WORD = 2000 };
    static const struct ap_symbol symbols[] = {{5, 3, 4}, {3, 5, 3}};
    for (size_t s = 0; s < 2; s++)
        for (int deep = 0; deep < 2; deep++) {
            open_tiling(symbols[s], 1);
            struct ap_tracker *tracker = open_tracker(deep);
            struct ap_pose pose = {{0, 0, 0}, {0.2, 0.1, 0, 1}};
            struct ap_iso start = feed(tracker, pose), end;
            struct ap_vec4 home = {0, 0, 0, 1}; // the first cell's centre, in the current's frame
            double e_folds = 0;
            int face[WORD];
            uint64_t seed = 3;
            for (int i = 0; i < WORD; i++) {
                do
                    face[i] = (int)(fabs(noise(&seed)) * 0.999 * tiling.face_count);
                while (i > 0 && face[i] == pairing.to[face[i - 1]]);
                go(tracker, pose, face[i], deep);
                home = ap_iso_apply(&pairing.cell_from_neighbour[pairing.to[face[i]]], home);
                e_folds += log(home.w);
                home = (struct ap_vec4){home.x / home.w, home.y / home.w, home.z / home.w, 1};
            }
            for (int i = WORD; i-- > 0;)
                go(tracker, pose, pairing.to[face[i]], deep);
            assert_true(ap_tracker_place(tracker, pose, &end));
            double open = 0, defect = ap_iso_defect(tiling.space, &end);
            for (int i = 0; i < 16; i++)
                open = fmax(open, fabs(end.m[i / 4][i % 4] - start.m[i / 4][i % 4]));
            print_message("deep %d: %d cells and %.0f rho out and back: %.1e off, defect %.1e\n",
                          deep, WORD, e_folds, open, defect);
            if (!(e_folds > 1000) || !(open < 1e-13) || !(defect < 1e-15))
                fail_msg("%g rho (more than 1000), off by %g (1e-13), defect %g (1e-15)", e_folds,
                         open, defect);
            ap_tracker_destroy(tracker);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(steps_are_isometries_to_the_last_bit),
        cmocka_unit_test(blind_walks_are_exact_to_a_hundred_rho),
        cmocka_unit_test(words_of_cells_close),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
