#ifndef ANTIPODE_DEVICE_LOG_POSELOG_NAMED_H
#define ANTIPODE_DEVICE_LOG_POSELOG_NAMED_H

#include "src/device/log/poselog_format.h"

// CSV whose header names a pose of every device in each line: NAME_pos_x, _y, _z and NAME_rot_x,
// _y, _z, _w (who-is-alyx, and most recorders written for Unity).

enum { AP_NAMED_DEVICES_MAX = 16 };

struct ap_named_columns {
    size_t count; // of columns
    size_t time;
    double ns_per_unit;
    double scale_m; // metres of a unit
    int device_count;
    struct ap_named_device {
        char name[AP_LOG_DEVICE_NAME_MAX];
        size_t pos[3], rot[4]; // columns
    } devices[AP_NAMED_DEVICES_MAX];
};

// Whether a header has such columns.
bool ap_named_is_header(const char *line, size_t len);

bool ap_named_parse_header(const char *line, size_t len, struct ap_named_columns *columns,
                           struct ap_bad_line *bad);

// One row for each device that the line says something of (empty fields, or zeros: it does not);
// their number in *count.
bool ap_named_parse(const char *line, size_t len, const struct ap_named_columns *columns,
                    struct ap_row rows[AP_NAMED_DEVICES_MAX], int *count, struct ap_bad_line *bad);

#endif
