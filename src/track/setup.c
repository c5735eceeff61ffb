#include "src/track/setup.h"

#include <math.h>
#include <string.h>

#include "src/base/number.h"

static enum ap_status check_length(struct ap_error *err, const char *what, double value_m) {
    if (isfinite(value_m) && value_m > 0)
        return AP_OK;
    return ap_fail(err, AP_USAGE, "the %s must be finite and > 0 m, not %g", what, value_m);
}

static enum ap_status edge_of_given_radius(struct ap_error *err, const struct ap_track_setup *setup,
                                           struct ap_space space, double *edge_m) {
    double fits_m = ap_table_edge_of_radius(space);
    bool asked = !isnan(setup->table_edge_m);
    if (asked && setup->tracker != AP_TRACKER_BILLIARDS)
        return AP_OK;
    if (asked && !(fabs(setup->table_edge_m - fits_m) <= 1e-9))
        return ap_fail(err, AP_USAGE,
                       "--table-edge %.12g does not fit the radius %.12g m, which sets the edge of "
                       "both tables to %.12g m: leave one of the two out",
                       setup->table_edge_m, space.rho_m, fits_m);
    *edge_m = fits_m;
    return check_length(err, "table's edge", fits_m);
}

static enum ap_status check_anchor(struct ap_error *err, const struct ap_track_setup *setup) {
    if (!setup->anchor)
        return AP_OK;
    if (setup->tracker != AP_TRACKER_ANCHOR)
        return ap_fail(err, AP_USAGE,
                       "--anchor %.64s goes with --tracker anchor: '%s' has no anchor to choose",
                       setup->anchor, ap_tracker_kind_name(setup->tracker));
    size_t length = strlen(setup->anchor);
    if (length == 0 || length >= sizeof((struct ap_tracker_params *)0)->anchor)
        return ap_fail(err, AP_USAGE,
                       "--anchor: expected head, left, right, hands or the name of "
                       "a device, at most 63 bytes");
    return AP_OK;
}

enum ap_status ap_track_setup(struct ap_error *err, const struct ap_track_setup *setup,
                              struct ap_tracker_params *params) {
    bool has_radius = !isnan(setup->radius_m), has_edge = !isnan(setup->table_edge_m);
    double edge_m = has_edge ? setup->table_edge_m : AP_TABLE_EDGE_DEFAULT_MM / 1000.0;
    struct ap_space space;
    enum ap_status status =
        ap_space_from_name(err, setup->space, has_radius ? setup->radius_m : 1, &space);
    if (!status)
        status = check_length(err, "table's edge", edge_m);
    if (!status)
        status = check_anchor(err, setup);
    if (!status && !isfinite(setup->table_height_m))
        status = ap_fail(err, AP_USAGE, "the table's height must be finite");
    if (status)
        return status;
    if (space.kappa != 0 && has_radius)
        status = edge_of_given_radius(err, setup, space, &edge_m);
    else if (space.kappa != 0)
        space = ap_table_from_edge(space.kappa, edge_m, 1).space;
    if (!status)
        status = check_length(err, "radius", space.rho_m);
    if (status)
        return status;
    *params = (struct ap_tracker_params){.kind = setup->tracker,
                                         .space = space,
                                         .table_height_m = setup->table_height_m,
                                         .table_edge_m = edge_m};
    if (setup->anchor)
        memcpy(params->anchor, setup->anchor, strlen(setup->anchor));
    return AP_OK;
}

enum ap_status ap_table_at_parse(struct ap_error *err, const char *text, double *x_m, double *z_m,
                                 double *yaw_rad) {
    double v[3];
    const char *at = text;
    for (int i = 0; i < 3; i++) {
        size_t len = strcspn(at, ",");
        if (!ap_parse_double(at, len, &v[i]) || at[len] != (i < 2 ? ',' : '\0'))
            return ap_fail(err, AP_USAGE,
                           "--table-at '%.64s': expected X,Z,YAW, three numbers (metres, metres, "
                           "radians) with commas between them",
                           text);
        at += len + 1;
    }
    *x_m = v[0];
    *z_m = v[1];
    *yaw_rad = v[2];
    return AP_OK;
}
