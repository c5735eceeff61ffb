#include "src/app/calibrate.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "src/base/file.h"
#include "src/base/log.h"
#include "src/device/calibration/store.h"

// antipode calibrate: what is asked for, what is known, and where it is kept.

static const char help[] =
    "Measures what the devices cannot know and keeps it in the user's folder\n"
    "($XDG_CONFIG_HOME/antipode, or ~/.config/antipode), from where everything that uses devices\n"
    "takes it. WHAT is\n"
    "    rest          biases of gyroscopes and accelerometers: lay the devices down and let go;\n"
    "                  --poses 6: on six sides, for all axes of the accelerometer\n"
    "    mount         how a tracker sits on a head or in a hand: look level ahead, then nod\n"
    "    table [LOG]   where the table stands: touch three of its corners with a controller and\n"
    "                  press trigger, or the button that selects, at each; live or from a log\n"
    "    show          what is known\n"
    "    forget table|SERIAL|all\n"
    "Measurements of something that moves, nods that are none and corners of no square are refused.\n"
    "Exit status: 0; 1 measured and kept, but with a doubt; 2 usage; 3 what was measured is of no\n"
    "use, or a file is wrong; 4 no device, or the folder cannot be written.";

static void show_device(const struct ap_device_calibration *c) {
    const struct ap_imu_bias *b = &c->rest.bias;
    struct ap_quat q = c->tracker_from_body;
    double degrees = 180 / M_PI;
    printf("device %s\n", c->key);
    if (c->has_bias)
        printf("  gyroscope bias      %9.4f %9.4f %9.4f deg/s (within %.4f, %.1f s at rest)\n"
               "  accelerometer bias  %9.4f %9.4f %9.4f m/s2 (%d pose%s)\n",
               degrees * b->gyr_rad_s.x, degrees * b->gyr_rad_s.y, degrees * b->gyr_rad_s.z,
               degrees * c->rest.gyr_sigma_rad_s, c->rest.seconds, b->acc_m_s2.x, b->acc_m_s2.y,
               b->acc_m_s2.z, c->rest.poses, c->rest.poses == 1 ? "" : "s");
    if (c->has_mount)
        printf("  mount               %9.5f %9.5f %9.5f %9.5f (quaternion, tracker from body)\n",
               q.x, q.y, q.z, q.w);
}

static enum ap_status show_room(struct ap_error *err, const char *path) {
    struct ap_room_calibration room;
    if (!ap_file_exists(path))
        return AP_OK;
    enum ap_status st = ap_room_file_read(err, path, &room);
    const struct ap_table_place *t = &room.table;
    if (!st)
        printf("table at %.4f, %.4f m, turned by %.3f degrees, %.4f m high, edge %.4f m (touched "
               "within %.1f mm)\n",
               t->x_m, t->z_m, 180 / M_PI * t->yaw_rad, t->height_m, t->edge_m, 1e3 * room.rms_m);
    return st;
}

static enum ap_status show(struct ap_error *err, const char *dir, const char *room) {
    struct ap_device_calibration *all = calloc(AP_CALIBRATED_MAX, sizeof *all);
    int count = 0;
    if (!all)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    enum ap_status st = ap_calibration_list(err, dir, AP_CALIBRATED_MAX, all, &count);
    for (int i = 0; i < count; i++)
        show_device(&all[i]);
    free(all);
    if (!st)
        st = show_room(err, room);
    if (!st && count == 0 && !ap_file_exists(room))
        printf("nothing is calibrated in %s\n", dir);
    return st;
}

static enum ap_status forget_room(struct ap_error *err, const char *room, bool *found) {
    *found = unlink(room) == 0;
    return *found || errno == ENOENT
               ? AP_OK
               : ap_fail(err, AP_ENVIRONMENT, "%s: %s", room, strerror(errno));
}

static enum ap_status forget_all(struct ap_error *err, const char *dir, bool *found) {
    struct ap_device_calibration *all = calloc(AP_CALIBRATED_MAX, sizeof *all);
    int count = 0;
    if (!all)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    enum ap_status st = ap_calibration_list(err, dir, AP_CALIBRATED_MAX, all, &count);
    for (int i = 0; i < count && !st; i++) {
        bool one = false;
        st = ap_calibration_forget(err, dir, all[i].key, &one);
        *found |= one;
    }
    free(all);
    return st;
}

static enum ap_status forget(struct ap_error *err, const char *dir, const char *room,
                             const char *what) {
    bool found = false, devices = false, all = strcmp(what, "all") == 0;
    enum ap_status st = AP_OK;
    if (all || strcmp(what, "table") == 0)
        st = forget_room(err, room, &found);
    if (!st && all)
        st = forget_all(err, dir, &devices);
    if (!st && !all && strcmp(what, "table") != 0)
        st = ap_calibration_forget(err, dir, what, &found);
    if (!st && !found && !devices && !all)
        return ap_fail(err, AP_USAGE, "nothing is known of '%s' (antipode calibrate show)", what);
    return st;
}

static enum ap_status dispatch(struct ap_error *err, const struct ap_calibrate_options *o,
                               char **operand, int count) {
    const char *what = operand[0];
    char *dir = NULL, *room = NULL;
    bool is_table = strcmp(what, "table") == 0, is_forget = strcmp(what, "forget") == 0;
    if (is_forget && count != 2)
        return ap_fail(err, AP_USAGE, "forget what? table, a serial or all");
    if (!is_forget && !is_table && count > 1)
        return ap_fail(err, AP_USAGE, "%s takes no '%s' (see antipode calibrate --help)", what,
                       operand[1]);
    enum ap_status st = ap_config_path(err, NULL, &dir);
    if (!st)
        st = ap_config_path(err, "room.json", &room);
    if (st)
        goto out;
    if (is_table)
        st = ap_calibrate_table(err, o, operand + 1, count - 1);
    else if (is_forget)
        st = forget(err, dir, room, operand[1]);
    else if (strcmp(what, "show") == 0)
        st = show(err, dir, room);
    else if (strcmp(what, "rest") == 0)
        st = ap_calibrate_rest(err, o);
    else if (strcmp(what, "mount") == 0)
        st = ap_calibrate_mount(err, o);
    else
        st = ap_fail(err, AP_USAGE, "'%s': expected rest, mount, table, show or forget", what);
out:
    free(dir);
    free(room);
    return st;
}

// What one kind of calibration takes and another does not.
static enum ap_status check_what(struct ap_error *err, const struct ap_calibrate_options *o,
                                 const char *what) {
    const struct {
        const char *name, *takers;
        bool given;
    } rows[] = {{"only", "rest, mount", o->only},
                {"poses", "rest", !isnan(o->poses)},
                {"corners", "table", !isnan(o->corners)},
                {"table-edge", "table", !isnan(o->table_edge)},
                {"tip", "table", o->tip},
                {"out", "table", o->out},
                {"device, --position, --replay, --bus", "rest, mount, table",
                 ap_live_options_given(&o->live)}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        if (rows[i].given && !strstr(rows[i].takers, what))
            return ap_fail(err, AP_USAGE, "--%s: for calibrate %s, not %s", rows[i].name,
                           rows[i].takers, what);
    return AP_OK;
}

static enum ap_status check_values(struct ap_error *err, const struct ap_calibrate_options *o) {
    if (o->corners != 3 && o->corners != 4)
        return ap_fail(err, AP_USAGE, "--corners: expected 3 or 4, not %g", o->corners);
    if (!(o->poses >= 1 && o->poses <= AP_RESTS_MAX) || o->poses != floor(o->poses))
        return ap_fail(err, AP_USAGE, "--poses: expected a whole number from 1 to %d, not %g",
                       AP_RESTS_MAX, o->poses);
    if (!(o->seconds > 0 && o->seconds <= 1e6))
        return ap_fail(err, AP_USAGE, "--seconds: expected more than 0, at most 1000000, not %g",
                       o->seconds);
    return AP_OK;
}

static enum ap_status run(struct ap_error *err, int argc, char **argv) {
    struct ap_calibrate_options o = {.seconds = 60,
                                     .table_edge = NAN,
                                     .poses = NAN,
                                     .corners = NAN,
                                     .live = {.uncalibrated = true}};
    const struct ap_option options[] = {
        {"only", AP_OPTION_TEXT, &o.only, "SERIAL", "this device alone (rest, mount)"},
        {"poses", AP_OPTION_NUMBER, &o.poses, "N", "so many ways up (rest; 1)"},
        {"corners", AP_OPTION_NUMBER, &o.corners, "N", "so many corners, 3 or 4 (table; 3)"},
        {"table-edge", AP_OPTION_NUMBER, &o.table_edge, "M", "its edge, where it is known (table)"},
        {"tip", AP_OPTION_TEXT, &o.tip, "X,Y,Z", "what touches, in the controller's axes (table)"},
        {"out", AP_OPTION_TEXT, &o.out, "FILE", "the room's file (table; the user's room.json)"},
        {"seconds", AP_OPTION_NUMBER, &o.seconds, "S", "give up after so long (60)"},
        AP_LIVE_OPTION_TABLE(o.live),
    };
    const struct ap_usage usage = {.command = "calibrate",
                                   .operands = "WHAT [LOG...]",
                                   .text = help,
                                   .options = options,
                                   .option_count = sizeof options / sizeof options[0],
                                   .min_operands = 1,
                                   .max_operands = -1};
    int operands;
    bool done;
    enum ap_status st = ap_parse_options(err, &usage, argc, argv, &operands, &done);
    if (st || done)
        return st;
    st = check_what(err, &o, argv[1]);
    o.poses = isnan(o.poses) ? 1 : o.poses;
    o.corners = isnan(o.corners) ? 3 : o.corners;
    if (!st)
        st = check_values(err, &o);
    if (!st)
        st = ap_live_options_check(err, &o.live);
    return st ? st : dispatch(err, &o, argv + 1, operands);
}

const struct ap_command ap_command_calibrate = {
    "calibrate", "biases at rest, a tracker's mounting, where the table stands", run};
