#ifndef ANTIPODE_DEVICE_LOG_POSELOG_ARGUMENT_H
#define ANTIPODE_DEVICE_LOG_POSELOG_ARGUMENT_H

#include "src/device/axes.h"
#include "src/device/log/poselog_format.h"

// How one log is named, and how it is to be read: "[ROLE=]FILE[,KEY=VALUE…]". docs/pose-logs.md has
// the keys. What begins with a comma but is none of them belongs to the file's name, and so does
// everything before two commas (or one at the end).

enum { AP_LOG_PATH_MAX = 4096 };

struct ap_log_argument {
    struct ap_field role;       // a piece of the argument; empty: none
    char path[AP_LOG_PATH_MAX]; // "-": standard input
    int64_t offset_ns;          // added to its times
    double time_scale;          // its times are multiplied by this first
    double scale_m;             // metres of one of its units; 0: what its format says
    struct ap_axes axes;        // the axes it is in
    bool invert;                // its poses are the room's in the device, not the device's in it
    bool has_up, z_up;
    bool has_frame, optical;
};

// AP_USAGE, naming the argument: no file, a name that is too long, a value that is none. The
// argument must outlive what was made of it.
enum ap_status ap_log_argument_parse(struct ap_error *err, const char *argument,
                                     struct ap_log_argument *out);

// The argument with its file in this folder (which ends with a slash or not) where its path is
// relative; malloc'ed, NULL without memory. "-" and what is no argument stay as they are.
char *ap_log_argument_in(const char *argument, const char *folder);

// How much of it is "ROLE=", a word of letters, digits, '_' and '-' that begins with neither of the
// digits nor '-': "left=x.csv" has a role, "./a=b.csv" and "2=1" have none, which is 0.
size_t ap_role_length(const char *argument);

bool ap_log_argument_is_stdin(const char *argument);

// The row as the options say, but for up and frame: time, scale, axes, inversion. False where its
// time is beyond ±4e18 ns then or its place beyond ±1e9 m. is_placed: it has a place of its own (a
// body's model puts the others, and axes and inversion were seen to before).
bool ap_log_argument_apply(const struct ap_log_argument *argument, bool is_placed,
                           struct ap_row *row);

#endif
