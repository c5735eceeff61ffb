#ifndef ANTIPODE_APP_LIVE_OPTIONS_H
#define ANTIPODE_APP_LIVE_OPTIONS_H

#include <jansson.h>

#include "src/app/command.h"
#include "src/device/live/live.h"

// Options about live devices that `devices`, `record` and others share.
struct ap_live_options {
    struct ap_text_list device, position, replay, bus;
    bool uncalibrated; // as the devices say, without what `calibrate` has found
    bool unmounted;    // without their mountings only
};

#define AP_LIVE_OPTION_TABLE(o)                                                                    \
    {"device", AP_OPTION_LIST, &(o).device, "ROLE=WHICH",                                          \
     "a role's device: serial, driver or path; may be repeated"},                                  \
        {"position", AP_OPTION_LIST, &(o).position, "ROLE=WHICH",                                  \
         "another device that tells where the role is"},                                           \
        {"replay", AP_OPTION_LIST, &(o).replay, "FILE",                                            \
         "a raw recording as if it was plugged in, instead of devices"},                           \
    {                                                                                              \
        "bus", AP_OPTION_LIST, &(o).bus, "hidraw|libusb|hidapi",                                   \
            "the way to devices (hidraw and libusb); may be repeated"                              \
    }

// The machine's buses or, with --replay, those recordings alone. `base` says the rest.
enum ap_status ap_live_options_open(struct ap_error *err, const struct ap_live_options *options,
                                    const struct ap_live_params *base, struct ap_live **live);

// What can be said of them before a device is opened or a program runs. AP_USAGE; AP_INPUT for a
// recording that cannot be read.
enum ap_status ap_live_options_check(struct ap_error *err, const struct ap_live_options *options);

// Whether any of them is given.
bool ap_live_options_given(const struct ap_live_options *options);

// The simulated headset's setting "poses" that says the same; NULL without memory, or for a path
// that is not UTF-8. stats: it says at its end how old poses were.
json_t *ap_live_options_json(const struct ap_live_options *options, bool stats);

// Whether a tracker is plugged in that a driver knows and that we may open; one that we may not is
// said on standard error.
bool ap_live_is_plugged(const struct ap_live_options *options);

// From now on Ctrl-C, SIGTERM and SIGHUP only set this.
void ap_catch_end(void);
bool ap_end_asked(void);

#endif
