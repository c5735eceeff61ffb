#ifndef ANTIPODE_APP_ROOM_FILE_H
#define ANTIPODE_APP_ROOM_FILE_H

#include <stdbool.h>

#include "src/base/status.h"

// What `antipode calibrate` has kept, for the other commands.

// $XDG_CONFIG_HOME/antipode or ~/.config/antipode, and NAME in it where that is not NULL;
// malloc'ed. AP_ENVIRONMENT where there is no home.
enum ap_status ap_config_path(struct ap_error *err, const char *name, char **path);

// A room's file into what was not given: the table's place as the text of --table-at (into
// `text`), its height and, where the radius is not given either, its edge. `file` NULL: nothing.
struct ap_room_defaults {
    const char **table_at;
    double *table_height_m, *table_edge_m; // NAN: not given
    bool radius_given;
    char text[96]; // must live as long as *table_at
};
enum ap_status ap_room_file_apply(struct ap_error *err, const char *file,
                                  struct ap_room_defaults *defaults);

#endif
