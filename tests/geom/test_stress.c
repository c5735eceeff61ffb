#include "tests/geom/check.h"

#include "src/view/view.h"

// Numbers as large and as small as they come, each quantity in two independent ways; the spaces
// against one another as the radius grows; and random compositions by the million (first argument;
// docs/accuracy.md has the figures of 100000000).
static long composition_count = 300000;

static const double RADII[] = {1e-3, 0.85, 40, 1e9};
static const double LENGTHS[] = {0,    5e-324, 1e-310, 3e-308, 1e-160, 1e-18, 1e-12,
                                 1e-6, 0.3,    1.57,   3.1415, 10,     38,    80};
enum { LENGTH_COUNT = sizeof LENGTHS / sizeof *LENGTHS };

static bool iso_is_finite(const struct ap_iso *m) {
    for (int i = 0; i < 16; i++)
        if (!isfinite(m->m[i / 4][i % 4]))
            return false;
    return true;
}

// What exp, log, distance and translation say of one vector, against each other. Below the normal
// doubles the error is of the last bit there is.
static void check_vector(struct ap_space s, struct ap_vec3 v) {
    double length = hypot(hypot(v.x, v.y), v.z), rho = s.rho_m;
    struct ap_vec4 p = ap_exp(s, v);
    struct ap_iso there = ap_iso_translate(s, v), back = ap_iso_inverse(s, there);
    struct ap_vec4 moved = ap_iso_apply(&there, base_point(s));
    double size = fmax(fmax(fabs(p.x), fabs(p.y)), fmax(fabs(p.z), fabs(p.w)));
    // The matrix holds v/rho, which at 1e9 m is below all doubles where v is.
    double lost = 2e-323 * fmax(1, rho);
    assert_true(iso_is_finite(&there) && iso_is_finite(&back));
    check_near(moved.x, p.x, 3e-15 * size + lost);
    check_near(moved.y, p.y, 3e-15 * size + lost);
    check_near(moved.z, p.z, 3e-15 * size + lost);
    check_near(moved.w, p.w, 3e-15 * size);
    if (s.kappa <= 0 || length < 3.14 * rho) {
        struct ap_vec3 again;
        assert_int_equal(ap_log_map(NULL, s, p, 0, &again), AP_OK);
        // Near s3's half turn a rounding of sin is worth 1/|tan| of the angle.
        double wide = s.kappa > 0 && length > rho ? 1 / fabs(sin(length / rho)) : 1;
        check_near(again.x, v.x, 2e-15 * wide * length + 2e-323);
        check_near(again.y, v.y, 2e-15 * wide * length + 2e-323);
        check_near(again.z, v.z, 2e-15 * wide * length + 2e-323);
        double d;
        assert_int_equal(ap_distance(NULL, s, base_point(s), p, &d), AP_OK);
        check_near(d, length, 1.2e-15 * fmax(length, rho) * (s.kappa < 0 ? p.w / rho : 1));
    }
    if (there.m[3][3] < 10) {
        struct ap_iso home = ap_iso_mul(there, back), again = ap_iso_orthonormalize(s, there);
        check_iso(&home, &AP_ISO_IDENTITY,
                  1e-14 * fabs(there.m[3][3]) * fabs(there.m[3][3]) + 1e-14);
        check_near(ap_iso_defect(s, &again), 0, 1e-13);
    }
}

static void from_nothing_to_eighty_radii(void **state) {
    (void)state;
    struct ref_random random = {21};
    int count = 0;
    for (int kappa = -1; kappa <= 1; kappa++)
        for (int r = 0; r < 4; r++)
            for (int i = 0; i < LENGTH_COUNT; i++)
                for (int k = 0; k < 20; k++) {
                    struct ap_space s = {kappa, RADII[r]};
                    double length = LENGTHS[i] < 1e-300 ? LENGTHS[i] : LENGTHS[i] * s.rho_m;
                    struct ap_vec3 u = k == 0 ? (struct ap_vec3){0, 0, -1} : ref_direction(&random);
                    struct ap_vec3 v = ap_vec3_scale(length, u);
                    if (k % 4 == 1) // components of very different size
                        v.y = length > 0 ? 5e-324 : -0.0;
                    check_vector(s, v);
                    count++;
                }
    printf("%d vectors\n", count);
}

// Three numbers that the curvature changes: a distance, where the walk right, up, left, down ends,
// and what vergence a tourist has straight ahead.
enum { LIMITS = 3 };

static void limits_of(struct ap_space s, double is[LIMITS]) {
    const struct ap_vec3 u = {0.3, 0.2, -1}, v = {-0.8, 0.5, 0.4};
    assert_int_equal(ap_distance(NULL, s, ap_exp(s, u), ap_exp(s, v), &is[0]), AP_OK);
    const struct ap_vec3 square[4] = {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
    struct ap_iso loop = ap_iso_walk(s, square, 4);
    is[1] = loop.m[1][0];
    assert_int_equal(ap_vergence_ahead(NULL, s, AP_VIEW_TOURIST, 0.064, 2, &is[2]), AP_OK);
}

// To first order in curvature: d² = |u−v|² − kappa/(3·rho²)·|u×v|²; a turn of kappa times the area;
// tan of half the vergence is a/d·(1 − kappa·(a²/6 + d²/3)/rho²).
static void first_order(double by[LIMITS]) {
    const struct ap_vec3 u = {0.3, 0.2, -1}, v = {-0.8, 0.5, 0.4};
    double a = 0.032, d = 2;
    struct ap_vec3 area = ap_vec3_cross(u, v);
    by[0] = -ap_vec3_dot(area, area) / (6 * ap_vec3_length(ap_vec3_sub(u, v)));
    by[1] = 1;
    by[2] = -2 * a / d * (a * a / 6 + d * d / 3) / (1 + a * a / d / d);
}

static void spaces_agree_as_the_radius_grows(void **state) {
    (void)state;
    static const char *const names[LIMITS] = {"a distance", "a loop's turn",
                                              "a tourist's vergence"};
    double slope[LIMITS], flat[LIMITS], bowl[LIMITS], saddle[LIMITS], before[LIMITS] = {0};
    first_order(slope);
    for (double rho = 10; rho < 2e9; rho *= 10) {
        limits_of((struct ap_space){0, rho}, flat);
        limits_of((struct ap_space){1, rho}, bowl);
        limits_of((struct ap_space){-1, rho}, saddle);
        for (int i = 0; i < LIMITS; i++) {
            double up = bowl[i] - flat[i], down = saddle[i] - flat[i], small = 1 / (rho * rho);
            // What is left is of the second order; and a rounding or two.
            check_near(up, slope[i] * small, 3 * small * small + 2e-15);
            check_near(down, -slope[i] * small, 3 * small * small + 2e-15);
            if (fabs(down) > 1e-10 && before[i] != 0) {
                double order = log10(fabs(before[i] / up));
                printf("%s: from rho %g to %g the order is %.5f\n", names[i], rho / 10, rho, order);
                check_near(order, 2, 0.02);
            }
            before[i] = up;
        }
    }
}

// The i-th random motion: up to 0.4 rho, any turn.
static struct ap_iso motion(struct ap_space s, uint64_t i, struct ap_vec3 *v) {
    struct ref_random r = {i * 0x9e3779b97f4a7c15u + 77};
    *v = ap_vec3_scale(ref_uniform(&r, 0, 0.4) * s.rho_m, ref_direction(&r));
    return ap_iso_from_pose(s, (struct ap_pose){*v, random_quat(&r)});
}

// A side of a triangle by the other two and the angle between them (the unit vectors u, w).
static double side(struct ap_space s, double a, struct ap_vec3 u, double b, struct ap_vec3 w) {
    struct ap_vec3 apart = ap_vec3_sub(u, w);
    double half = ap_vec3_dot(apart, apart) / 4; // sin² of half the angle
    a /= s.rho_m;
    b /= s.rho_m;
    if (s.kappa == 0)
        return s.rho_m * sqrt((a - b) * (a - b) + 4 * a * b * half);
    if (s.kappa > 0) {
        double h = pow(sin((a - b) / 2), 2) + sin(a) * sin(b) * half;
        return s.rho_m * 2 * atan2(sqrt(h), sqrt(1 - h));
    }
    return s.rho_m * 2 * asinh(sqrt(pow(sinh((a - b) / 2), 2) + sinh(a) * sinh(b) * half));
}

struct composed {
    double worst_side, worst_defect, farthest;
};

static struct ap_iso compose(struct ap_space s, struct ap_iso m, struct ap_iso by, struct ap_vec3 v,
                             struct composed *is) {
    struct ap_iso back = ap_iso_inverse(s, m), next = ap_iso_mul(m, by);
    struct ap_vec3 home = ap_log_unchecked(s, ap_iso_apply(&back, base_point(s)), 0);
    double a = ap_vec3_length(home), b = ap_vec3_length(v);
    struct ap_vec3 at = ap_log_unchecked(s, ap_iso_apply(&next, base_point(s)), 0);
    double d = ap_vec3_length(at);
    if (a > 0 && b > 0) {
        double by_side = side(s, a, ap_vec3_normalize(home), b, ap_vec3_normalize(v));
        double miss = fabs(d - by_side) / s.rho_m;
        is->worst_side = miss <= is->worst_side ? is->worst_side : miss; // keeps NaN
    }
    is->farthest = fmax(is->farthest, d / s.rho_m);
    return next;
}

// Out by half of them and back by their inverses, put back onto the group every 64: each step by
// the law of cosines too, and the end is where it began. A motion that would lead beyond 2 rho is
// left out, there and back.
static void compositions(int kappa, long count) {
    struct ap_space s = {kappa, 0.85};
    struct composed is = {0};
    struct ap_iso m = AP_ISO_IDENTITY;
    unsigned char *left_out = calloc((size_t)count / 16 + 1, 1);
    assert_non_null(left_out);
    struct ap_vec3 v;
    for (long i = 0; i < count; i++) {
        long k = i < count / 2 ? i : count / 2 * 2 - 1 - i;
        if (k < 0)
            break;
        struct ap_iso by = motion(s, (uint64_t)k, &v);
        if (i >= count / 2) {
            by = ap_iso_inverse(s, by);
            v = ap_log_unchecked(s, ap_iso_apply(&by, base_point(s)), 0);
        } else {
            struct ap_iso ahead = ap_iso_mul(m, by);
            struct ap_vec3 to = ap_log_unchecked(s, ap_iso_apply(&ahead, base_point(s)), 0);
            if (ap_vec3_length(to) > 2 * s.rho_m)
                left_out[k / 8] |= (unsigned char)(1u << k % 8);
        }
        if (left_out[k / 8] >> k % 8 & 1)
            continue;
        m = compose(s, m, by, v, &is);
        if (i % 64 == 63) {
            is.worst_defect = fmax(is.worst_defect, ap_iso_defect(s, &m));
            m = ap_iso_orthonormalize(s, m);
        }
    }
    free(left_out);
    double open = iso_difference(&m, &AP_ISO_IDENTITY);
    printf("%s: %ld compositions within %.2f rho: a side off by %.2g rho, defect %.2g, end off by "
           "%.2g\n",
           ap_space_name(s), count, is.farthest, is.worst_side, is.worst_defect, open);
    assert_true(is.farthest > 1.5);
    check_near(is.worst_side, 0, kappa < 0 ? 1e-11 : 1e-13);
    // S'DS of two places 4 rho apart: cosh(4)² = 750 times a rounding or two.
    check_near(is.worst_defect, 0, kappa < 0 ? 1e-11 : 1e-13);
    check_near(open, 0, 3e-14 * sqrt((double)count));
}

static void random_compositions_close(void **state) {
    (void)state;
    for (int kappa = -1; kappa <= 1; kappa++)
        compositions(kappa, composition_count / 3);
}

int main(int argc, char **argv) {
    if (argc > 1)
        composition_count = atol(argv[1]);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(from_nothing_to_eighty_radii),
        cmocka_unit_test(spaces_agree_as_the_radius_grows),
        cmocka_unit_test(random_compositions_close),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
