#include "src/app/room_file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/file.h"
#include "src/device/calibration/store.h"

enum ap_status ap_config_path(struct ap_error *err, const char *name, char **path) {
    const char *config = getenv("XDG_CONFIG_HOME"), *home = getenv("HOME");
    char dir[4096];
    int n;
    if (config && config[0] == '/')
        n = snprintf(dir, sizeof dir, "%s/antipode", config);
    else if (home && *home)
        n = snprintf(dir, sizeof dir, "%s/.config/antipode", home);
    else
        return ap_fail(err, AP_ENVIRONMENT,
                       "neither XDG_CONFIG_HOME nor HOME says where to keep calibrations");
    char *whole = (size_t)n >= sizeof dir ? NULL : name ? ap_path_join(dir, name) : strdup(dir);
    if (!whole)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    *path = whole;
    return AP_OK;
}

enum ap_status ap_room_file_apply(struct ap_error *err, const char *file,
                                  struct ap_room_defaults *d) {
    struct ap_room_calibration room;
    if (!file)
        return AP_OK;
    enum ap_status st = ap_room_file_read(err, file, &room);
    if (st)
        return st;
    const struct ap_table_place *t = &room.table;
    snprintf(d->text, sizeof d->text, "%.17g,%.17g,%.17g", t->x_m, t->z_m, t->yaw_rad);
    if (!*d->table_at)
        *d->table_at = d->text;
    if (isnan(*d->table_height_m))
        *d->table_height_m = t->height_m;
    if (isnan(*d->table_edge_m) && !d->radius_given)
        *d->table_edge_m = t->edge_m;
    return AP_OK;
}
