#include "src/app/live_options.h"

#include <signal.h>
#include <stdlib.h>

#include "src/app/room_file.h"
#include "src/base/log.h"
#include "src/device/calibration/store.h"
#include "src/device/live/rules.h"

// What `antipode calibrate` has kept; *list and *mounts are malloc'ed.
static enum ap_status read_calibrations(struct ap_error *err, struct ap_device_calibration **list,
                                        struct ap_live_mount **mounts, int *count) {
    char *dir = NULL;
    *list = calloc(AP_CALIBRATED_MAX, sizeof **list);
    *mounts = calloc(AP_CALIBRATED_MAX, sizeof **mounts);
    enum ap_status st = *list && *mounts ? AP_OK : ap_fail(err, AP_ENVIRONMENT, "out of memory");
    // Where nobody has a home nothing has been kept.
    if (!st && ap_config_path(NULL, NULL, &dir) == AP_OK)
        st = ap_calibration_list(err, dir, AP_CALIBRATED_MAX, *list, count);
    free(dir);
    for (int i = 0; !st && i < *count; i++) {
        const struct ap_device_calibration *c = &(*list)[i];
        (*mounts)[i] = (struct ap_live_mount){.serial = c->key};
        if (c->has_mount)
            (*mounts)[i].tracker_from_body = c->tracker_from_body;
        if (c->has_bias)
            (*mounts)[i].bias = c->rest.bias;
    }
    return st;
}

enum ap_status ap_live_options_open(struct ap_error *err, const struct ap_live_options *o,
                                    const struct ap_live_params *base, struct ap_live **live) {
    struct ap_live_params params = *base;
    struct ap_live_bus way;
    struct ap_device_calibration *list = NULL;
    struct ap_live_mount *mounts = NULL;
    int count = 0;
    enum ap_status st = o->uncalibrated ? AP_OK : read_calibrations(err, &list, &mounts, &count);
    params.mounts = mounts;
    params.mount_count = (size_t)count;
    params.assign = o->device.text;
    params.assign_count = o->device.count;
    params.position = o->position.text;
    params.position_count = o->position.count;
    if (!st && o->replay.count) {
        st = ap_live_replay(err, o->replay.text, o->replay.count, &way);
        params.buses = &way;
        params.bus_count = 1;
    }
    if (!st)
        st = ap_live_open(err, &params, live);
    free(list);
    free(mounts);
    return st;
}

bool ap_live_options_given(const struct ap_live_options *o) {
    return o->device.count || o->position.count || o->replay.count;
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

json_t *ap_live_options_json(const struct ap_live_options *o, bool stats) {
    json_t *devices = texts_json(&o->device, false), *position = texts_json(&o->position, false);
    json_t *replay = texts_json(&o->replay, true);
    if (devices && position && replay)
        return json_pack("{s:o, s:o, s:o, s:b}", "devices", devices, "position", position, "replay",
                         replay, "stats", stats);
    json_decref(devices);
    json_decref(position);
    json_decref(replay);
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

bool ap_live_is_plugged(void) {
    struct ap_live_bus buses[AP_LIVE_BUSES_MAX];
    const struct ap_driver *drivers[AP_LIVE_DEVICES_MAX];
    struct ap_live_place *places = calloc(AP_LIVE_DEVICES_MAX, sizeof *places);
    int bus_count = 0;
    bool any = false;
    if (places && !ap_live_machine(NULL, buses, &bus_count)) {
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
}

bool ap_end_asked(void) {
    return end_asked;
}
