#include "tests/geom/check.h"

// What composing does over many steps: a walk of small steps held within 1.7 rho, against the same
// walk in double-double. The number of steps is the first argument; the figures in docs/accuracy.md
// come from `test_drift 1000000`.
static long step_count = 20000;

struct drift {
    double defect, position, whole;
};

// Small steps in the walker's own frame, of no fixed length (its cosine would be wrong by the same
// last bit each time); beyond 1.7 rho she turns home.
static struct ap_vec3 *make_walk(struct ap_space s, long count) {
    struct ap_vec3 *steps = malloc((size_t)count * sizeof *steps);
    assert_non_null(steps);
    struct ref_random r = {11};
    struct ap_iso pose = AP_ISO_IDENTITY;
    for (long i = 0; i < count; i++) {
        struct ap_iso back = ap_iso_inverse(s, pose);
        struct ap_vec3 home = ap_log_unchecked(s, ap_iso_apply(&back, base_point(s)), 0);
        struct ap_vec3 u = ref_direction(&r);
        if (ap_vec3_length(home) > 1.69 * s.rho_m)
            u = ap_vec3_normalize(home);
        steps[i] = ap_vec3_scale(ref_uniform(&r, 0.005, 0.015) * s.rho_m, u);
        pose = ap_iso_mul(pose, ap_iso_translate(s, steps[i]));
    }
    return steps;
}

// period 0: never back onto the group.
static struct drift run(struct ap_space s, const struct ap_vec3 *steps, const struct ap_iso *truth,
                        long period) {
    struct ap_iso pose = AP_ISO_IDENTITY;
    for (long i = 0; i < step_count; i++) {
        pose = ap_iso_mul(pose, ap_iso_translate(s, steps[i]));
        if (period && (i + 1) % period == 0)
            pose = ap_iso_orthonormalize(s, pose);
    }
    struct drift d = {ap_iso_defect(s, &pose), 0, iso_difference(&pose, truth)};
    for (int i = 0; i < 4; i++)
        d.position = fmax(d.position, fabs(pose.m[i][3] - truth->m[i][3]));
    return d;
}

static void check_drift(int kappa) {
    struct ap_space s = {kappa, 0.85};
    struct ap_vec3 *steps = make_walk(s, step_count);
    struct ap_iso truth = ap_iso_walk(s, steps, (size_t)step_count);
    const long periods[] = {0, 1, 64};
    for (int i = 0; i < 3; i++) {
        struct drift d = run(s, steps, &truth, periods[i]);
        printf("%s, %ld steps, Gram-Schmidt every %ld: defect %.2g, position off by %.2g rho, "
               "largest entry off by %.2g\n",
               ap_space_name(s), step_count, periods[i], d.defect, d.position, d.whole);
        double share = (double)step_count / 1e6;
        check_near(d.defect, 0, periods[i] ? 1e-14 : 1e-14 + 2e-11 * share);
        check_near(d.position, 0, 1e-14 + 2e-11 * share);
    }
    free(steps);
}

static void test_drift(void **state) {
    (void)state;
    for (int kappa = -1; kappa <= 1; kappa++)
        check_drift(kappa);
}

// Why the domain of ap_iso_orthonormalize ends at m33 = 10: what one call does to a matrix that is
// exact to the last bit.
static void test_gram_schmidt_far_away(void **state) {
    (void)state;
    struct ap_space s = {-1, 1};
    struct ref_random r = {12};
    for (int distance = 1; distance <= 14; distance++) {
        double worst = 0, m33 = cosh(distance);
        for (int i = 0; i < 200; i++) {
            struct ap_vec3 v = ap_vec3_scale(distance, ref_direction(&r));
            struct ap_iso m = ap_iso_from_pose(s, (struct ap_pose){v, random_quat(&r)});
            struct ap_iso changed = ap_iso_orthonormalize(s, m);
            worst = fmax(worst, iso_difference(&changed, &m) / largest_entry(&m));
        }
        printf("h3, %2d rho: one Gram-Schmidt moves a correct matrix by %.2g of its largest entry "
               "(%.2g·m33²)\n",
               distance, worst, worst / m33 / m33);
        if (m33 < 10.1)
            check_near(worst, 0, 1e-15 * m33 * m33);
    }
}

int main(int argc, char **argv) {
    if (argc > 1)
        step_count = atol(argv[1]);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_drift),
        cmocka_unit_test(test_gram_schmidt_far_away),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
