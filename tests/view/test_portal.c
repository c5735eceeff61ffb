#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "src/view/portal.h"
#include "tests/samples.h"
#include "tests/view/random.h"

// Whatever an eye sees lies in a cell that the walk visits: points of random lines of sight are
// put through exp, and the cell they are in is found by stepping, which shares nothing with it.

static struct ap_tiling tiling;
static struct ap_pairing pairing;

static bool is_seen(const struct ap_portal *portal, int32_t cell, int image) {
    for (size_t i = 0; i < portal->count; i++)
        if (portal->seen[i].cell == cell && portal->seen[i].image == image)
            return true;
    return false;
}

// The cell that a point of cell 0's frame is in.
static int32_t cell_of(struct ap_cells *cells, struct ap_vec4 p) {
    int32_t cell = 0;
    for (int step = 0; step < 60; step++) {
        struct ap_iso back = ap_iso_inverse(tiling.space, cells->cells[cell].base_from_cell);
        int face = ap_cells_left_by(&tiling, ap_iso_apply(&back, p));
        if (face < 0)
            return cell;
        cell = ap_cells_across(cells, cell, face);
        if (cell < 0)
            return -1;
    }
    return -1;
}

// A point that eye e sees at a distance from it, in tangent space (native) or its own space.
static bool look(struct dice *dice, const struct ap_viewer *v, double most_m, int *image,
                 struct ap_vec4 *world) {
    const struct ap_view_eye *eye = &v->eye[roll(dice, 0, 1) < 0.5];
    const struct ap_frustum *f = &eye->frustum;
    struct ap_vec3 d = {roll(dice, f->left, f->right), roll(dice, f->down, f->up), -1};
    d = ap_vec3_scale(roll(dice, 0.01, most_m), ap_vec3_normalize(d));
    struct ap_iso m = v->world_from_nose;
    *image = 0;
    if (v->mode == AP_VIEW_TOURIST) {
        m = ap_iso_mul(m, ap_iso_from_pose(v->space, eye->view_from_eye));
    } else {
        d = ap_pose_apply(eye->view_from_eye, d);
        double t = ap_vec3_length(d) / v->space.rho_m / M_PI;
        if (v->space.kappa > 0 && t > 1.99)
            return false;
        *image = v->space.kappa > 0 && t > 1;
    }
    *world = ap_iso_apply(&m, ap_exp(v->space, d));
    return true;
}

static void whatever_is_seen_is_visited(void **state) {
    (void)state;
    static const struct ap_symbol symbols[] = {{5, 3, 4}, {4, 3, 5}, {3, 5, 3}, {5, 3, 5},
                                               {4, 3, 4}, {5, 3, 3}, {3, 3, 5}, {3, 4, 3}};
    struct dice dice = {2026};
    long tried = 0, cells_seen = 0, cells_out = 0;
    for (size_t i = 0; i < 8; i++)
        for (int round = 0; round < test_samples(24); round++) {
            int kappa;
            ap_symbol_space(NULL, symbols[i], &kappa);
            enum ap_view_mode mode = round % 2 ? AP_VIEW_TOURIST : AP_VIEW_NATIVE;
            struct ap_viewer v = roll_viewer(&dice, kappa, mode);
            ap_tiling_init(NULL, symbols[i], v.space, 1.1 * v.space.rho_m, &tiling);
            ap_pairing_find(&tiling, &pairing);
            struct ap_vec3 at =
                ap_vec3_scale(roll(&dice, 0, 0.95) * tiling.inradius_m, roll_direction(&dice));
            v.world_from_nose =
                ap_iso_mul(ap_iso_translate(v.space, at), ap_iso_rotate(roll_turn(&dice, M_PI)));
            struct ap_cells *cells;
            ap_cells_create(NULL, &tiling, &pairing, 64 << 20, &cells);
            double horizon = kappa > 0 ? INFINITY : 3.2 * v.space.rho_m;
            struct ap_portal_params params = {.viewer = &v, .horizon_m = horizon};
            struct ap_portal portal = {0};
            struct ap_portal_stats stats;
            assert_int_equal(ap_portal_walk(NULL, cells, &params, &portal, &stats), AP_OK);
            cells_seen += stats.visited;
            cells_out += stats.cone;
            double most = kappa > 0 ? (mode == AP_VIEW_NATIVE ? 6.2 : 3.1) * v.space.rho_m
                                    : horizon - tiling.circumradius_m;
            for (int n = 0; n < 1500; n++) {
                int image;
                struct ap_vec4 p;
                if (!look(&dice, &v, most, &image, &p))
                    continue;
                int32_t cell = cell_of(cells, p);
                assert_true(cell >= 0);
                tried++;
                if (!is_seen(&portal, cell, image))
                    fail_msg("{%d,%d,%d} %s: a point that is seen lies in cell %d, image %d, which "
                             "is not visited (rho %g m, round %d)",
                             symbols[i].p, symbols[i].q, symbols[i].r, ap_view_mode_name(mode),
                             cell, image, v.space.rho_m, round);
            }
            ap_portal_finish(&portal);
            ap_cells_destroy(cells);
        }
    print_message("%ld points; %ld cells visited, %ld beside them left out\n", tried, cells_seen,
                  cells_out);
    assert_true(tried > test_samples(200000));
    assert_true(cells_out > cells_seen / 20);
}

static void an_endless_world_costs_what_is_seen(void **state) {
    (void)state;
    struct dice dice = {7};
    struct ap_viewer v = roll_viewer(&dice, -1, AP_VIEW_NATIVE);
    ap_tiling_init(NULL, (struct ap_symbol){5, 3, 4}, v.space, 0, &tiling);
    ap_pairing_find(&tiling, &pairing);
    struct ap_cells *cells;
    ap_cells_create(NULL, &tiling, &pairing, 64 << 20, &cells);
    struct ap_portal_params params = {.viewer = &v, .horizon_m = 3.5 * v.space.rho_m};
    struct ap_portal portal = {0};
    struct ap_portal_stats culled, all, few;
    ap_portal_walk(NULL, cells, &params, &portal, &culled);
    params.no_cull = true;
    ap_portal_walk(NULL, cells, &params, &portal, &all);
    params.no_cull = false;
    params.most_cells = 20;
    ap_portal_walk(NULL, cells, &params, &portal, &few);
    print_message("visited %u of %u\n", culled.visited, all.visited);
    assert_true(culled.visited * 2 < all.visited);
    assert_int_equal(few.visited, 20);
    assert_true(few.budget > 0);
    ap_portal_finish(&portal);
    ap_cells_destroy(cells);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whatever_is_seen_is_visited),
        cmocka_unit_test(an_endless_world_costs_what_is_seen),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
