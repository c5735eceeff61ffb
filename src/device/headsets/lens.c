#include "src/device/headsets/lens.h"

#include <math.h>

static enum ap_status read_number(struct ap_error *err, const struct ap_json_at *at,
                                  const char *key, double least, double most, double *value) {
    if (!ap_json_has(at, key))
        return AP_OK;
    double v;
    struct ap_json_at place = ap_json_member(at, key);
    enum ap_status st = ap_json_number(err, at, key, &v);
    if (st)
        return st;
    if (!(v >= least && v <= most))
        return ap_json_fail(err, &place, "expected %g to %g, not %.17g", least, most, v);
    *value = v;
    return AP_OK;
}

// The radius that is seen grows with the display's: its slope in u = r², 1 + 3·k1·u + 5·k2·u², is
// positive at both ends and where it is least.
static bool unfolded(const struct ap_lens *l, double max_radius) {
    double most = max_radius * max_radius, least = l->k2 > 0 ? -3 * l->k1 / (10 * l->k2) : 0;
    double at[2] = {most, least > 0 && least < most ? least : 0};
    for (int i = 0; i < 2; i++)
        if (!(1 + at[i] * (3 * l->k1 + at[i] * 5 * l->k2) > 0))
            return false;
    return true;
}

enum ap_status ap_lens_parse(struct ap_error *err, const struct ap_json_at *at, double max_radius,
                             struct ap_lens *lens) {
    static const char *const keys[] = {"k1", "k2", "red_scale", "blue_scale", NULL};
    struct ap_lens l = {0, 0, 1, 1};
    enum ap_status st = ap_json_check_keys(err, at, keys);
    if (!st)
        st = read_number(err, at, "k1", -10, 10, &l.k1);
    if (!st)
        st = read_number(err, at, "k2", -10, 10, &l.k2);
    if (!st)
        st = read_number(err, at, "red_scale", 0.5, 2, &l.red_scale);
    if (!st)
        st = read_number(err, at, "blue_scale", 0.5, 2, &l.blue_scale);
    if (st)
        return st;
    if (!unfolded(&l, max_radius))
        return ap_json_fail(err, at,
                            "k1 and k2 fold the picture over within the field of view (its corner "
                            "is at a tangent of %.3g)",
                            max_radius);
    *lens = l;
    return AP_OK;
}

json_t *ap_lens_to_json(const struct ap_lens *l) {
    return json_pack("{s:f, s:f, s:f, s:f}", "k1", l->k1, "k2", l->k2, "red_scale", l->red_scale,
                     "blue_scale", l->blue_scale);
}
