#include "src/app/live_options.h"

#include <signal.h>
#include <stdlib.h>
#include <sys/stat.h>

#include "src/app/room_file.h"
#include "src/base/log.h"
#include "src/device/live/mounts.h"
#include "src/device/live/rules.h"

// What `antipode calibrate` has kept. Where nobody has a home that is nothing.
static enum ap_status read_mounts(struct ap_error *err, struct ap_live_mounts *mounts) {
    char *dir = NULL;
    if (ap_config_path(NULL, NULL, &dir))
        return AP_OK;
    enum ap_status st = ap_live_mounts_read(err, dir, mounts);
    free(dir);
    return st;
}

static void set_lists(const struct ap_live_options *o, struct ap_live_params *params) {
    params->assign = o->device.text;
    params->assign_count = o->device.count;
    params->position = o->position.text;
    params->position_count = o->position.count;
    params->ways = o->bus.text;
    params->way_count = o->bus.count;
}

static enum ap_status check_words(struct ap_error *err, const struct ap_live_options *o) {
    struct ap_live_params params = {.bus_count = 0};
    set_lists(o, &params);
    if (o->bus.count && o->replay.count)
        return ap_fail(err, AP_USAGE,
                       "--bus and --replay: a recording needs no bus; give one of "
                       "them");
    return ap_live_check(err, &params);
}

// A recording that cannot be read is better known before a program runs. A pipe is read once only.
static enum ap_status check_replay(struct ap_error *err, const char *path) {
    struct ap_live_bus way;
    struct stat s;
    if (stat(path, &s) == 0 && !S_ISREG(s.st_mode) && !S_ISDIR(s.st_mode))
        return AP_OK;
    enum ap_status st = ap_live_replay(err, &path, 1, &way);
    if (!st)
        way.io->destroy(way.bus);
    return st;
}

enum ap_status ap_live_options_check(struct ap_error *err, const struct ap_live_options *o) {
    enum ap_status st = check_words(err, o);
    for (size_t i = 0; i < o->replay.count && !st; i++)
        st = check_replay(err, o->replay.text[i]);
    return st;
}

enum ap_status ap_live_options_open(struct ap_error *err, const struct ap_live_options *o,
                                    const struct ap_live_params *base, struct ap_live **live) {
    struct ap_live_params params = *base;
    struct ap_live_bus way;
    struct ap_live_mounts mounts = {.count = 0};
    enum ap_status st = check_words(err, o);
    if (!st && !o->uncalibrated)
        st = read_mounts(err, &mounts);
    for (int i = 0; i < mounts.count && o->unmounted; i++)
        mounts.mounts[i].tracker_from_body = (struct ap_quat){0};
    params.mounts = mounts.mounts;
    params.mount_count = (size_t)mounts.count;
    set_lists(o, &params);
    if (!st && o->replay.count) {
        st = ap_live_replay(err, o->replay.text, o->replay.count, &way);
        params.buses = &way;
        params.bus_count = 1;
    }
    if (!st)
        st = ap_live_open(err, &params, live);
    ap_live_mounts_finish(&mounts);
    return st;
}

bool ap_live_options_given(const struct ap_live_options *o) {
    return o->device.count || o->position.count || o->replay.count || o->bus.count;
}

// Relative paths in the settings are relative to the settings file.
static json_t *texts_json(const struct ap_text_list *list, bool paths) {
    json_t *array = json_array();
    for (size_t i = 0; array && i < list->count; i++) {
        char *real = paths ? realpath(list->text[i], NULL) : NULL;
        int failed = json_array_append_new(array, json_string(real ? real : list->text[i]));
        free(real);
        if (failed) {
            json_decref(array);
            return NULL;
        }
    }
    return array;
}

// Where the runtime finds what is calibrated: it does not look for anybody's home.
static bool add_calibration(json_t *object) {
    char *dir = NULL;
    if (ap_config_path(NULL, NULL, &dir))
        return true;
    bool added = json_object_set_new(object, "calibration", json_string(dir)) == 0;
    free(dir);
    return added;
}

json_t *ap_live_options_json(const struct ap_live_options *o, bool stats) {
    json_t *devices = texts_json(&o->device, false), *position = texts_json(&o->position, false);
    json_t *replay = texts_json(&o->replay, true), *object = json_object();
    bool ok = json_object_set_new(object, "devices", devices) == 0;
    ok = json_object_set_new(object, "position", position) == 0 && ok;
    ok = json_object_set_new(object, "replay", replay) == 0 && ok;
    ok = json_object_set_new(object, "bus", texts_json(&o->bus, false)) == 0 && ok;
    ok = json_object_set_new(object, "stats", json_boolean(stats)) == 0 && ok;
    if (ok && add_calibration(object))
        return object;
    json_decref(object);
    return NULL;
}

static bool any_opens(const struct ap_live_place *places, const struct ap_driver *const *drivers,
                      int count) {
    bool any = false;
    for (int i = 0; i < count; i++) {
        char why[256];
        if (drivers[i] && places[i].denied) {
            ap_live_denied_text(&places[i], drivers[i], why, sizeof why);
            ap_log(AP_LOG_WARNING, "%s", why);
        }
        any |= drivers[i] && !places[i].denied;
    }
    return any;
}

bool ap_live_is_plugged(const struct ap_live_options *o) {
    struct ap_live_bus buses[AP_LIVE_BUSES_MAX];
    const struct ap_driver *drivers[AP_LIVE_DEVICES_MAX];
    struct ap_live_place *places = calloc(AP_LIVE_DEVICES_MAX, sizeof *places);
    int bus_count = 0;
    bool any = false;
    if (places && !ap_live_machine(NULL, o->bus.text, o->bus.count, buses, &bus_count)) {
        int n = ap_live_list(buses, bus_count, places, drivers, AP_LIVE_DEVICES_MAX);
        any = any_opens(places, drivers, n);
    }
    for (int i = 0; i < bus_count; i++)
        buses[i].io->destroy(buses[i].bus);
    free(places);
    return any;
}

static volatile sig_atomic_t end_asked;

static void on_signal(int sig) {
    (void)sig;
    end_asked = 1;
}

void ap_catch_end(void) {
    signal(SIGINT, on_signal);
    signal(SIGTERM, on_signal);
    signal(SIGHUP, on_signal); // the terminal is closed
}

bool ap_end_asked(void) {
    return end_asked;
}
