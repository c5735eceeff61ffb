#include <stdarg.h>
#include <stdio.h>

#include "src/device/hid/driver.h"

// The table of drivers: the first that matches takes the device, so those that look closer stand
// before those that take whole classes.

extern const struct ap_driver ap_driver_android, ap_driver_slimevr, ap_driver_spacemouse,
    ap_driver_hydra, ap_driver_playstation, ap_driver_joycon, ap_driver_xreal, ap_driver_rift,
    ap_driver_orientation;

static const struct ap_driver *const drivers[] = {
    &ap_driver_android, &ap_driver_slimevr,     &ap_driver_spacemouse,
    &ap_driver_hydra,   &ap_driver_playstation, &ap_driver_joycon,
    &ap_driver_xreal,   &ap_driver_rift,        &ap_driver_orientation,
};

int ap_driver_count(void) {
    return (int)(sizeof drivers / sizeof *drivers);
}

const struct ap_driver *ap_driver_at(int index) {
    return index >= 0 && index < ap_driver_count() ? drivers[index] : NULL;
}

static bool is_other_interface(const struct ap_driver_ids *id, const struct ap_device_info *info) {
    int number = info->interface_number;
    return info->interface_known && number >= 0 && number < 32 && id->not_interfaces >> number & 1;
}

const struct ap_driver_ids *ap_driver_ids_of(const struct ap_driver *driver,
                                             const struct ap_device_info *info) {
    for (const struct ap_driver_ids *id = driver->ids; id && id->vendor; id++)
        if (id->vendor == info->vendor && info->product >= id->first_product &&
            info->product <= id->last_product && (!id->bus || id->bus == info->bus))
            return is_other_interface(id, info) ? NULL : id;
    return NULL;
}

bool ap_driver_names(const struct ap_driver *driver, const struct ap_device_info *info) {
    return ap_driver_ids_of(driver, info) != NULL;
}

static bool matches(const struct ap_driver *driver, const struct ap_device_info *info) {
    return driver->match ? driver->match(info) : ap_driver_names(driver, info);
}

const struct ap_driver *ap_driver_find(const struct ap_device_info *info) {
    for (int i = 0; i < ap_driver_count(); i++)
        if (matches(drivers[i], info))
            return drivers[i];
    return NULL;
}

const struct ap_feature_report *ap_device_feature(const struct ap_device_info *info, uint8_t id) {
    for (int i = info->feature_count; i-- > 0;)
        if (info->features[i].len && info->features[i].bytes[0] == id)
            return &info->features[i];
    return NULL;
}

enum ap_report_verdict ap_report_bad(struct ap_driver_samples *samples, const char *format, ...) {
    va_list args;
    va_start(args, format);
    vsnprintf(samples->why, sizeof samples->why, format, args);
    va_end(args);
    return AP_REPORT_BAD;
}

struct ap_driver_sample *ap_driver_add_sample(struct ap_driver_samples *samples) {
    if (samples->count == AP_DRIVER_SAMPLES_MAX)
        return NULL;
    struct ap_driver_sample *s = &samples->at[samples->count++];
    *s = (struct ap_driver_sample){.pose = AP_POSE_IDENTITY};
    return s;
}
