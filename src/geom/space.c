#include "src/geom/space.h"

#include <math.h>
#include <string.h>

enum ap_status ap_space_from_name(struct ap_error *err, const char *name, double rho_m,
                                  struct ap_space *space) {
    static const char *const names[] = {"h3", "e3", "s3"};
    for (int i = 0; i < 3; i++) {
        if (strcmp(name, names[i]) != 0)
            continue;
        if (!isfinite(rho_m) || rho_m <= 0)
            return ap_fail(err, AP_USAGE, "the radius is %g m: give a finite number above 0",
                           rho_m);
        *space = (struct ap_space){i - 1, rho_m};
        return AP_OK;
    }
    return ap_fail(err, AP_USAGE, "no space is named '%.40s': use s3, e3 or h3", name);
}

const char *ap_space_name(struct ap_space space) {
    return space.kappa > 0 ? "s3" : space.kappa < 0 ? "h3" : "e3";
}

double ap_space_cos(struct ap_space space, double t) {
    return space.kappa > 0 ? cos(t) : space.kappa < 0 ? cosh(t) : 1;
}

double ap_space_sin(struct ap_space space, double t) {
    return space.kappa > 0 ? sin(t) : space.kappa < 0 ? sinh(t) : t;
}
