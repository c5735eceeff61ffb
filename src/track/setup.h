#ifndef ANTIPODE_TRACK_SETUP_H
#define ANTIPODE_TRACK_SETUP_H

#include "src/track/tracker.h"

// From what a person asked for to what a tracker needs; shared by the commands, so that the rules
// for radius and table stand in one place.

enum { AP_TABLE_EDGE_DEFAULT_MM = 900, AP_TABLE_HEIGHT_DEFAULT_MM = 750 };

struct ap_track_setup {
    const char *space; // "s3", "e3", "h3"
    double radius_m;   // NAN: not given (neither on the command line nor by the scene)
    enum ap_tracker_kind tracker;
    double table_edge_m; // NAN: not given
    double table_height_m;
    const char *anchor; // of the anchor tracker: a device, or "hands"; NULL: the head
};

// The radius: the given one, else the table's for the edge (s3, h3), else 1 m. The edge: the given
// one, else, in s3 and h3, the one that fits a given radius, else 0.9 m; with billiards in s3 and
// h3 a given radius sets it, and a given edge that differs by more than 1e-9 m is AP_USAGE, as is a
// number that is not finite or not > 0 (the height may be any finite number), and an anchor for
// another tracker or of more than 63 bytes.
enum ap_status ap_track_setup(struct ap_error *err, const struct ap_track_setup *setup,
                              struct ap_tracker_params *params);

// "X,Z,YAW" of --table-at, metres and radians. AP_USAGE where it is anything else.
enum ap_status ap_table_at_parse(struct ap_error *err, const char *text, double *x_m, double *z_m,
                                 double *yaw_rad);

#endif
