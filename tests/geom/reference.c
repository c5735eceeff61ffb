#include "tests/geom/reference.h"

#include <math.h>
#include <mpfr.h>

enum { BITS = 640, POOL = 400 };

// Numbers are taken from a pool, which each entry point starts anew.
static mpfr_t pool[POOL];
static int used, ready;

static void begin(void) {
    for (; ready < POOL; ready++)
        mpfr_init2(pool[ready], BITS);
    used = 0;
}

void ref_finish(void) {
    while (ready > 0)
        mpfr_clear(pool[--ready]);
    mpfr_free_cache();
}

static mpfr_ptr number(double value) {
    mpfr_ptr n = pool[used++];
    mpfr_set_d(n, value, MPFR_RNDN);
    return n;
}

// |v| into n.
static void length(mpfr_ptr n, const double *v, int count) {
    mpfr_ptr square = number(0);
    mpfr_set_zero(n, 1);
    for (int i = 0; i < count; i++) {
        mpfr_set_d(square, v[i], MPFR_RNDN);
        mpfr_sqr(square, square, MPFR_RNDN);
        mpfr_add(n, n, square, MPFR_RNDN);
    }
    mpfr_sqrt(n, n, MPFR_RNDN);
}

static void turn(int kappa, mpfr_ptr c, mpfr_ptr s, mpfr_ptr t) {
    if (kappa > 0) {
        mpfr_sin_cos(s, c, t, MPFR_RNDN);
    } else if (kappa < 0) {
        mpfr_sinh_cosh(s, c, t, MPFR_RNDN);
    } else {
        mpfr_set(s, t, MPFR_RNDN);
        mpfr_set_d(c, 1, MPFR_RNDN);
    }
}

// max |answer − exact| / max |exact|.
static double largest_error(int count, mpfr_ptr *exact, const double *answer) {
    mpfr_ptr worst = number(0), size = number(0), d = number(0);
    for (int i = 0; i < count; i++) {
        mpfr_sub_d(d, exact[i], answer[i], MPFR_RNDN);
        if (!mpfr_number_p(d))
            return INFINITY;
        if (mpfr_cmpabs(d, worst) > 0)
            mpfr_abs(worst, d, MPFR_RNDN);
        if (mpfr_cmpabs(exact[i], size) > 0)
            mpfr_abs(size, exact[i], MPFR_RNDN);
    }
    if (mpfr_zero_p(worst))
        return 0;
    mpfr_div(worst, worst, size, MPFR_RNDN);
    return mpfr_get_d(worst, MPFR_RNDU);
}

// The unit vector along v, c and s of |v|/rho.
static void arc(struct ap_space space, const double *v, mpfr_ptr *unit, mpfr_ptr c, mpfr_ptr s) {
    mpfr_ptr n = number(0), t = number(0);
    length(n, v, 3);
    for (int i = 0; i < 3; i++) {
        unit[i] = number(v[i]);
        if (!mpfr_zero_p(n))
            mpfr_div(unit[i], unit[i], n, MPFR_RNDN);
    }
    mpfr_div_d(t, n, space.rho_m, MPFR_RNDN);
    turn(space.kappa, c, s, t);
}

double ref_exp_error(struct ap_space space, struct ap_vec3 v, struct ap_vec4 answer) {
    begin();
    const double in[3] = {v.x, v.y, v.z}, out[4] = {answer.x, answer.y, answer.z, answer.w};
    mpfr_ptr exact[4], c = number(0), s = number(0);
    arc(space, in, exact, c, s);
    exact[3] = c;
    for (int i = 0; i < 4; i++) {
        if (i < 3)
            mpfr_mul(exact[i], exact[i], s, MPFR_RNDN);
        mpfr_mul_d(exact[i], exact[i], space.rho_m, MPFR_RNDN);
    }
    return largest_error(4, exact, out);
}

double ref_log_error(struct ap_space space, struct ap_vec4 p, int image, struct ap_vec3 answer) {
    begin();
    const double in[3] = {p.x, p.y, p.z}, out[3] = {answer.x, answer.y, answer.z};
    mpfr_ptr n = number(0), f = number(0), turn_around = number(0), w = number(p.w), exact[3];
    length(n, in, 3);
    if (space.kappa == 0) {
        mpfr_set_d(f, space.rho_m, MPFR_RNDN);
        mpfr_div(f, f, w, MPFR_RNDN);
    } else {
        mpfr_set(f, n, MPFR_RNDN);
        if (space.kappa > 0) {
            mpfr_atan2(f, f, w, MPFR_RNDN);
        } else {
            mpfr_div_d(f, f, space.rho_m, MPFR_RNDN);
            mpfr_asinh(f, f, MPFR_RNDN);
        }
        if (image) {
            mpfr_const_pi(turn_around, MPFR_RNDN);
            mpfr_mul_2ui(turn_around, turn_around, 1, MPFR_RNDN);
            mpfr_sub(f, f, turn_around, MPFR_RNDN);
        }
        mpfr_div(f, f, n, MPFR_RNDN);
        mpfr_mul_d(f, f, space.rho_m, MPFR_RNDN);
    }
    for (int i = 0; i < 3; i++) {
        exact[i] = number(in[i]);
        mpfr_mul(exact[i], exact[i], f, MPFR_RNDN);
    }
    return largest_error(3, exact, out);
}

static void translation(struct ap_space space, struct ap_vec3 v, mpfr_ptr m[16]) {
    const double in[3] = {v.x, v.y, v.z};
    mpfr_ptr unit[3], c = number(0), s = number(0), less = number(0), x = number(0);
    arc(space, in, unit, c, s);
    mpfr_sub_d(less, c, 1, MPFR_RNDN);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            mpfr_mul(x, unit[i], unit[j], MPFR_RNDN);
            mpfr_mul(x, x, less, MPFR_RNDN);
            mpfr_add_d(m[4 * i + j], x, i == j, MPFR_RNDN);
        }
        mpfr_mul(m[4 * i + 3], unit[i], s, MPFR_RNDN);
        mpfr_mul_si(m[12 + i], m[4 * i + 3], -space.kappa, MPFR_RNDN);
    }
    mpfr_set(m[15], c, MPFR_RNDN);
}

static void multiply(mpfr_ptr out[16], mpfr_ptr a[16], mpfr_ptr b[16]) {
    mpfr_ptr x = number(0);
    for (int i = 0; i < 16; i++) {
        mpfr_set_zero(out[i], 1);
        for (int k = 0; k < 4; k++) {
            mpfr_mul(x, a[i / 4 * 4 + k], b[4 * k + i % 4], MPFR_RNDN);
            mpfr_add(out[i], out[i], x, MPFR_RNDN);
        }
    }
}

double ref_walk_error(struct ap_space space, const struct ap_vec3 *steps, size_t count,
                      const struct ap_iso *answer) {
    begin();
    mpfr_ptr matrix[3][16], *all = matrix[0], *step = matrix[1], *product = matrix[2];
    double out[16];
    for (int i = 0; i < 16; i++) {
        out[i] = answer->m[i / 4][i % 4];
        for (int k = 0; k < 3; k++)
            matrix[k][i] = number(k == 0 && i % 5 == 0);
    }
    int mark = used;
    for (size_t n = 0; n < count; n++) {
        used = mark;
        translation(space, steps[n], step);
        multiply(product, all, step);
        mpfr_ptr *old = all;
        all = product;
        product = old;
    }
    used = mark;
    return largest_error(16, all, out);
}

// The Lorentzian (kappa < 0) or Euclidean product of two points with w from (x, y, z) in h3.
static void form(struct ap_space space, mpfr_ptr sum, const double *p, const double *q) {
    mpfr_ptr x = number(0), wp = number(p[3]), wq = number(q[3]), rho = number(space.rho_m);
    if (space.kappa < 0) {
        length(wp, p, 3);
        length(wq, q, 3);
        mpfr_hypot(wp, wp, rho, MPFR_RNDN);
        mpfr_hypot(wq, wq, rho, MPFR_RNDN);
    }
    mpfr_mul(sum, wp, wq, MPFR_RNDN);
    for (int i = 0; i < 3; i++) {
        mpfr_set_d(x, p[i], MPFR_RNDN);
        mpfr_mul_d(x, x, q[i], MPFR_RNDN);
        if (space.kappa < 0)
            mpfr_sub(sum, sum, x, MPFR_RNDN);
        else
            mpfr_add(sum, sum, x, MPFR_RNDN);
    }
}

static void distance_e3(mpfr_ptr d, struct ap_space space, const double *p, const double *q) {
    mpfr_ptr a = number(0), b = number(0);
    mpfr_set_zero(d, 1);
    for (int i = 0; i < 3; i++) {
        mpfr_set_d(a, p[i], MPFR_RNDN);
        mpfr_div_d(a, a, p[3], MPFR_RNDN);
        mpfr_set_d(b, q[i], MPFR_RNDN);
        mpfr_div_d(b, b, q[3], MPFR_RNDN);
        mpfr_sub(a, a, b, MPFR_RNDN);
        mpfr_hypot(d, d, a, MPFR_RNDN);
    }
    mpfr_mul_d(d, d, space.rho_m, MPFR_RNDN);
}

double ref_dist_error(struct ap_space space, struct ap_vec4 p, struct ap_vec4 q, double answer) {
    begin();
    const double a[4] = {p.x, p.y, p.z, p.w}, b[4] = {q.x, q.y, q.z, q.w};
    mpfr_ptr d = number(0), x = number(0), y = number(0);
    double scale = space.rho_m;
    if (space.kappa == 0) {
        distance_e3(d, space, a, b);
        scale = fmax(mpfr_get_d(d, MPFR_RNDN), scale);
    } else {
        form(space, d, a, b);
        if (space.kappa > 0) {
            length(x, a, 4);
            length(y, b, 4);
            mpfr_mul(x, x, y, MPFR_RNDN);
            mpfr_div(d, d, x, MPFR_RNDN);
            if (mpfr_cmpabs(d, number(1)) > 0)
                mpfr_setsign(d, number(1), mpfr_signbit(d), MPFR_RNDN);
            mpfr_acos(d, d, MPFR_RNDN);
        } else {
            mpfr_div_d(d, d, space.rho_m, MPFR_RNDN);
            mpfr_div_d(d, d, space.rho_m, MPFR_RNDN);
            if (mpfr_cmp_d(d, 1) < 0) // the same point, but for the last of the bits
                mpfr_set_d(d, 1, MPFR_RNDN);
            mpfr_acosh(d, d, MPFR_RNDN);
            scale = (p.w / space.rho_m) * (q.w / space.rho_m) * space.rho_m;
        }
        mpfr_mul_d(d, d, space.rho_m, MPFR_RNDN);
    }
    mpfr_sub_d(d, d, answer, MPFR_RNDN);
    mpfr_div_d(d, d, scale, MPFR_RNDN);
    return fabs(mpfr_get_d(d, MPFR_RNDA));
}

double ref_vergence_error(struct ap_space space, int tourist, double ipd, double d, double answer) {
    begin();
    mpfr_ptr a = number(ipd), far = number(d), s = number(0), c = number(0), t = number(0);
    mpfr_div_2ui(a, a, 1, MPFR_RNDN);
    if (tourist && space.kappa) {
        mpfr_div_d(a, a, space.rho_m, MPFR_RNDN);
        mpfr_div_d(far, far, space.rho_m, MPFR_RNDN);
        turn(space.kappa, c, s, far);
        mpfr_div(t, s, c, MPFR_RNDN);
        turn(space.kappa, c, s, a);
        mpfr_div(t, s, t, MPFR_RNDN);
    } else {
        mpfr_div(t, a, far, MPFR_RNDN);
    }
    mpfr_atan(t, t, MPFR_RNDN);
    mpfr_mul_2ui(t, t, 1, MPFR_RNDN);
    mpfr_sub_d(t, t, answer, MPFR_RNDN);
    return fabs(mpfr_get_d(t, MPFR_RNDA));
}

static uint64_t next(struct ref_random *r) {
    uint64_t z = r->state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

double ref_uniform(struct ref_random *r, double low, double high) {
    return low + (high - low) * ((double)(next(r) >> 11) * 0x1p-53);
}

struct ap_vec3 ref_direction(struct ref_random *r) {
    double z = ref_uniform(r, -1, 1), a = ref_uniform(r, 0, 6.283185307179586);
    double s = sqrt(1 - z * z);
    return (struct ap_vec3){s * cos(a), s * sin(a), z};
}
