#include "src/app/live_options.h"

#include <signal.h>
#include <stdlib.h>

#include "src/base/log.h"
#include "src/device/live/rules.h"

enum ap_status ap_live_options_open(struct ap_error *err, const struct ap_live_options *o,
                                    const struct ap_live_params *base, struct ap_live **live) {
    struct ap_live_params params = *base;
    struct ap_live_bus way;
    params.assign = o->device.text;
    params.assign_count = o->device.count;
    params.position = o->position.text;
    params.position_count = o->position.count;
    if (o->replay.count) {
        enum ap_status st = ap_live_replay(err, o->replay.text, o->replay.count, &way);
        if (st)
            return st;
        params.buses = &way;
        params.bus_count = 1;
    }
    return ap_live_open(err, &params, live);
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
