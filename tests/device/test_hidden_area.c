#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "src/device/headsets/hidden_area.h"

static double area(const struct ap_mask *m) {
    double sum = 0;
    for (uint32_t i = 0; i < m->index_count; i += 3) {
        const double *a = m->vertex[m->index[i]], *b = m->vertex[m->index[i + 1]],
                     *c = m->vertex[m->index[i + 2]];
        double twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        assert_true(twice > 0); // counterclockwise, also in float32
        float ax = (float)a[0], ay = (float)a[1];
        assert_true(((float)b[0] - ax) * ((float)c[1] - ay) >=
                    ((float)b[1] - ay) * ((float)c[0] - ax));
        sum += twice / 2;
    }
    return sum;
}

static bool covered(const struct ap_mask *m, double x, double y) {
    for (uint32_t i = 0; i < m->index_count; i += 3) {
        bool in = true;
        for (int k = 0; k < 3 && in; k++) {
            const double *a = m->vertex[m->index[i + (uint32_t)k]],
                         *b = m->vertex[m->index[i + (uint32_t)(k + 1) % 3]];
            in = (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]) >= 0;
        }
        if (in)
            return true;
    }
    return false;
}

static void check_sizes(const struct ap_mask *m) {
    assert_true(m->vertex_count <= AP_MASK_MAX_VERTICES && m->index_count <= AP_MASK_MAX_INDICES);
    for (uint32_t i = 0; i < m->index_count; i++)
        assert_true(m->index[i] < m->vertex_count);
    for (uint32_t i = 0; i < m->vertex_count; i++)
        assert_true(isfinite(m->vertex[i][0]) && isfinite(m->vertex[i][1]));
}

// Hidden and visible parts make up the picture, and nothing inside the ellipse is hidden.
static void check_eye(const struct ap_eye_profile *eye) {
    static struct ap_mask hidden, visible, outline;
    ap_hidden_area_mask(eye, AP_MASK_HIDDEN, &hidden);
    ap_hidden_area_mask(eye, AP_MASK_VISIBLE, &visible);
    ap_hidden_area_mask(eye, AP_MASK_OUTLINE, &outline);
    check_sizes(&hidden);
    check_sizes(&visible);
    check_sizes(&outline);
    double l = tan(eye->left_rad), r = tan(eye->right_rad), d = tan(eye->down_rad),
           u = tan(eye->up_rad);
    double whole = (r - l) * (u - d), sum = area(&hidden) + area(&visible);
    if (fabs(sum - whole) > 1e-6 * whole) // vertices are float32
        fail_msg("hidden and visible %.15g of %.15g, tolerance 1e-6", sum, whole);
    assert_int_equal(outline.index_count, outline.vertex_count);
    assert_true(outline.vertex_count >= 3);
    const double *s = eye->seen;
    for (int i = 0; i < 40; i++)
        for (int k = 0; k < 40; k++) {
            double x = l + (r - l) * (i + 0.4771) / 40, y = d + (u - d) * (k + 0.5227) / 40;
            double out = hypot((x - s[0]) / s[2], (y - s[1]) / s[3]);
            if (out <= 1)
                assert_true(covered(&visible, x, y) && !covered(&hidden, x, y));
            if (out > 1.002) // 1/cos(pi/64) = 1.0012
                assert_true(covered(&hidden, x, y) && !covered(&visible, x, y));
        }
}

static void parts_make_up_the_picture(void **unused) {
    (void)unused;
    struct ap_eye_profile eye = ap_headset_builtin().eye[0];
    const double seen[][4] = {
        {0, 0, 0.9, 0.9},                                               // cuts some edges
        {0, 0, 0.3, 0.5},                                               // inside
        {-1, 1, 0.2, 0.2},                                              // over a corner
        {0.1, -0.1, 10, 10},                                            // sees all
        {0.5, 0.5, 1e-3, 1e3}, {-0.05, 0, 0.5, 1000}, {0, 0, 1.2, 1.2}, // the corners only
    };
    for (size_t i = 0; i < sizeof seen / sizeof *seen; i++) {
        for (int k = 0; k < 4; k++)
            eye.seen[k] = seen[i][k];
        check_eye(&eye);
    }
    // A view that does not look straight ahead.
    eye.left_rad = 0.3;
    eye.seen[0] = 0.6;
    eye.seen[2] = eye.seen[3] = 0.4;
    check_eye(&eye);
}

static void an_eye_that_sees_all_has_no_mask(void **unused) {
    (void)unused;
    static struct ap_mask mask;
    struct ap_eye_profile eye = ap_headset_builtin().eye[1];
    for (int kind = AP_MASK_HIDDEN; kind <= AP_MASK_OUTLINE; kind++) {
        ap_hidden_area_mask(&eye, (enum ap_mask_kind)kind, &mask);
        assert_int_equal(mask.vertex_count + mask.index_count, 0);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(parts_make_up_the_picture),
        cmocka_unit_test(an_eye_that_sees_all_has_no_mask),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
