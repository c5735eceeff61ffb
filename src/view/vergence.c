#include "src/geom/arc.h"
#include "src/view/view.h"

// Half the angle is the arctangent of q, whose error is at most half of q's relative error: so the
// sines need to be right relative to themselves, also next to their zeros far from the base point.
static double tourist_quotient(struct ap_space space, double a_m, double d_m) {
    struct ap_dd a = ap_quotient_dd(ap_dd_of(a_m), space.rho_m);
    struct ap_dd d = ap_quotient_dd(ap_dd_of(d_m), space.rho_m);
    if (space.kappa == 0 || (a.hi < 1e-8 && d.hi < 1e-8))
        return a_m / d_m;
    double across = ap_turn_of(space, a).s;
    if (space.kappa < 0) // sinh may overflow (the angle is pi), tanh may not be a quotient then
        return a.hi < 700 ? across / tanh(d.hi) : INFINITY;
    struct ap_turn ahead = ap_turn_of(space, d);
    return across * (ahead.c / ahead.s);
}

static bool beyond_full_turn(struct ap_space space, double d_m) {
    const struct ap_dd two_pi = {6.283185307179586, 2.4492935982947064e-16};
    return ap_dd_sub(ap_quotient_dd(ap_dd_of(d_m), space.rho_m), two_pi).hi >= 0;
}

enum ap_status ap_vergence_ahead(struct ap_error *err, struct ap_space space,
                                 enum ap_view_mode mode, double ipd_m, double d_m,
                                 double *vergence_rad) {
    if (!isfinite(ipd_m) || ipd_m <= 0)
        return ap_fail(err, AP_INPUT, "the eyes are %g m apart: give a finite length above 0",
                       ipd_m);
    if (!isfinite(d_m) || d_m <= 0)
        return ap_fail(err, AP_INPUT, "a distance of %g m: give a finite length above 0", d_m);
    if (space.kappa > 0 && beyond_full_turn(space, d_m))
        return ap_fail(err, AP_INPUT,
                       "a distance of %g m is past a full turn of s3 (%.9g m): give less", d_m,
                       6.283185307179586 * space.rho_m);
    double a_m = ipd_m / 2;
    double q = mode == AP_VIEW_TOURIST ? tourist_quotient(space, a_m, d_m) : a_m / d_m;
    *vergence_rad = 2 * atan(q);
    return AP_OK;
}
