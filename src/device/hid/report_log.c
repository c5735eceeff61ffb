#include "src/device/hid/report_log.h"

#include <inttypes.h>
#include <stdalign.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/device/hid/body_model.h"
#include "src/device/hid/driver.h"
#include "src/device/hid/recording.h"

enum { NAMES_MAX = 256, NAME_MAX_BYTES = 24, TRACKERS_MAX = 256 };

struct device {
    int64_t number; // of its D: line
    bool sought;    // for a driver
    bool has_flown;
    int64_t last_flight_ns;
    const struct ap_driver *driver;
    uint16_t names[TRACKERS_MAX]; // by tracker: index of its name + 1, 0: none yet
    struct ap_device_info info;
    alignas(max_align_t) unsigned char state[AP_DRIVER_STATE_MAX];
};

struct ap_report_log {
    struct ap_field role;
    struct ap_axes axes;
    bool invert;
    struct ap_hid_line line;
    int64_t last_t_ns;
    int64_t report_count, pose_count;
    int name_count;
    char names[NAMES_MAX][NAME_MAX_BYTES];
    struct ap_driver_samples samples; // of the newest report
    int given;                        // how many of them have been taken
    int current, device_count;
    bool is_numbered; // a D: line has been seen
    struct device *devices[AP_REPORT_LOG_DEVICES_MAX];
    struct device first;
};

struct ap_report_log *ap_report_log_create(void) {
    struct ap_report_log *log = calloc(1, sizeof *log);
    if (!log)
        return NULL;
    log->last_t_ns = INT64_MIN;
    log->devices[0] = &log->first; // of the lines before the first D:, too
    log->device_count = 1;
    return log;
}

void ap_report_log_destroy(struct ap_report_log *log) {
    for (int i = 1; log && i < log->device_count; i++)
        free(log->devices[i]);
    free(log);
}

void ap_report_log_set_role(struct ap_report_log *log, struct ap_field role,
                            const struct ap_axes *axes, bool invert) {
    log->role = role;
    log->axes = *axes;
    log->invert = invert;
}

// What stood before the first D: line belongs to its device.
static bool choose_device(struct ap_report_log *log, const char *line, struct ap_bad_line *bad) {
    int64_t number = log->line.device;
    if (!log->is_numbered) {
        log->is_numbered = true;
        log->first.number = number;
    }
    for (int i = 0; i < log->device_count; i++)
        if (log->devices[i]->number == number) {
            log->current = i;
            return true;
        }
    if (log->device_count == AP_REPORT_LOG_DEVICES_MAX)
        return ap_bad_line_at(bad, line, line, "at most %d devices in a recording",
                              AP_REPORT_LOG_DEVICES_MAX);
    struct device *d = calloc(1, sizeof *d);
    if (!d)
        return ap_bad_line_at(bad, line, line, "memory for another device");
    d->number = number;
    log->current = log->device_count++;
    log->devices[log->current] = d;
    return true;
}

static bool take_descriptor(struct ap_report_log *log, struct device *d, const char *line,
                            struct ap_bad_line *bad) {
    struct ap_error err;
    d->sought = false;
    d->driver = NULL;
    if (ap_hid_parse_descriptor(&err, log->line.bytes, log->line.byte_count, &d->info.descriptor) ==
        AP_OK)
        return true;
    return ap_bad_line_at(bad, line, line + log->line.bytes_column - 1,
                          "a descriptor without fault (%s)", err.text);
}

static bool take_feature(struct ap_report_log *log, struct device *d, const char *line,
                         struct ap_bad_line *bad) {
    struct ap_device_info *info = &d->info;
    size_t n = log->line.byte_count;
    if (n > AP_DEVICE_FEATURE_BYTES)
        return ap_bad_line_at(bad, line, line, "a feature report of at most %d bytes",
                              AP_DEVICE_FEATURE_BYTES);
    if (n == 0)
        return true;
    struct ap_feature_report *f = NULL;
    for (int i = 0; i < info->feature_count; i++)
        if (info->features[i].bytes[0] == log->line.bytes[0])
            f = &info->features[i];
    if (!f && info->feature_count == AP_DEVICE_FEATURES_MAX)
        return ap_bad_line_at(bad, line, line, "at most %d feature reports of a device",
                              AP_DEVICE_FEATURES_MAX);
    if (!f)
        f = &info->features[info->feature_count++];
    f->len = n;
    memcpy(f->bytes, log->line.bytes, n);
    return true;
}

static bool take_report(struct ap_report_log *log, struct device *d, const char *line,
                        struct ap_bad_line *bad) {
    const struct ap_hid_line *l = &log->line;
    const char *time_at = line + l->t_column - 1;
    if (l->t_ns < log->last_t_ns)
        return ap_bad_line_at(bad, line, time_at,
                              "a time not before the line before (%" PRId64 " ns), not %" PRId64
                              " ns",
                              log->last_t_ns, l->t_ns);
    log->report_count++;
    if (!d->sought) {
        d->sought = true;
        d->driver = ap_driver_find(&d->info);
        memset(d->state, 0, sizeof d->state);
        if (d->driver && d->driver->init)
            d->driver->init(d->state, &d->info);
    }
    if (!d->driver)
        return true;
    enum ap_report_verdict verdict =
        d->driver->parse(d->state, &d->info, l->t_ns, l->bytes, l->byte_count, &log->samples);
    if (verdict != AP_REPORT_OK)
        log->samples.count = 0;
    if (verdict == AP_REPORT_BAD)
        return ap_bad_line_at(bad, line, line + (l->bytes_column ? l->bytes_column - 1 : 0), "%s",
                              log->samples.why);
    log->last_t_ns = l->t_ns;
    return true;
}

bool ap_report_log_feed(struct ap_report_log *log, const char *line, size_t len,
                        struct ap_bad_line *bad) {
    struct ap_hid_line *l = &log->line;
    log->samples.count = log->given = 0;
    l->bytes_column = 1;
    if (!ap_hid_parse_line(line, len, l, bad))
        return false;
    struct device *d = log->devices[log->current];
    switch (l->kind) {
    case AP_HID_LINE_DEVICE:
        return choose_device(log, line, bad);
    case AP_HID_LINE_DESCRIPTOR:
        return take_descriptor(log, d, line, bad);
    case AP_HID_LINE_FEATURE:
        return take_feature(log, d, line, bad);
    case AP_HID_LINE_REPORT:
        return take_report(log, d, line, bad);
    case AP_HID_LINE_NAME: {
        size_t n = l->text.len < sizeof d->info.name ? l->text.len : sizeof d->info.name - 1;
        memcpy(d->info.name, l->text.text, n);
        d->info.name[n] = 0;
        return true;
    }
    case AP_HID_LINE_IDS:
        d->info.bus = l->bus;
        d->info.vendor = l->vendor;
        d->info.product = l->product;
        return true;
    case AP_HID_LINE_NOTHING:
        break;
    }
    return true;
}

static bool is_taken(const struct ap_report_log *log, const char *name) {
    for (int i = 0; i < log->name_count; i++)
        if (strcmp(log->names[i], name) == 0)
            return true;
    return false;
}

// The first free one of head, left, right (left, right, head for what is held), then numbers.
static const char *name_of(struct ap_report_log *log, struct device *d, int tracker) {
    static const char *const parts[2][3] = {{"head", "left", "right"}, {"left", "right", "head"}};
    if (tracker < 0 || tracker >= TRACKERS_MAX)
        return NULL;
    if (d->names[tracker])
        return log->names[d->names[tracker] - 1];
    if (log->name_count == NAMES_MAX)
        return NULL;
    char *name = log->names[log->name_count];
    snprintf(name, NAME_MAX_BYTES, "tracker%d", log->name_count + 1);
    for (int i = 0; i < 3; i++) {
        const char *part = parts[d->driver->hands_first][i];
        if (is_taken(log, part))
            continue;
        memcpy(name, part, strlen(part) + 1);
        break;
    }
    d->names[tracker] = (uint16_t)++log->name_count;
    return name;
}

// Where the tracker is, by what its driver knows and what the body it is worn on tells.
static struct ap_pose place(const struct ap_report_log *log, const struct ap_driver_sample *s,
                            enum ap_body_part part) {
    struct ap_pose pose = {ap_axes_vec3(&log->axes, s->pose.p),
                           ap_axes_quat(&log->axes, s->pose.q)};
    if (log->invert && s->kind == AP_SAMPLE_ORIENTATION)
        pose.q = ap_quat_conj(pose.q);
    else if (log->invert)
        pose = ap_pose_inverse(pose);
    if (s->kind == AP_SAMPLE_ORIENTATION)
        pose.p = ap_body_place(part, pose.q);
    else if (s->kind == AP_SAMPLE_FLIGHT)
        pose.p = ap_vec3_add(ap_body_place(part, AP_QUAT_IDENTITY), pose.p);
    return pose;
}

// A report may hold several measurements of one tracker; its newest pose is the report's.
static bool is_overtaken(const struct ap_driver_samples *samples, int index) {
    for (int i = index + 1; i < samples->count; i++)
        if (samples->at[i].tracker == samples->at[index].tracker &&
            samples->at[i].kind != AP_SAMPLE_IMU)
            return true;
    return false;
}

bool ap_report_log_take(struct ap_report_log *log, struct ap_row *row) {
    while (log->given < log->samples.count) {
        const struct ap_driver_sample *s = &log->samples.at[log->given++];
        struct device *d = log->devices[log->current];
        if (s->kind == AP_SAMPLE_IMU || is_overtaken(&log->samples, log->given - 1))
            continue;
        // A cap's two reports may come at one time; in no time nothing flies.
        if (s->kind == AP_SAMPLE_FLIGHT && d->has_flown && d->last_flight_ns == log->line.t_ns)
            continue;
        const char *name = name_of(log, d, s->tracker);
        if (!name)
            continue;
        log->pose_count++;
        d->has_flown = true;
        d->last_flight_ns = log->line.t_ns;
        struct ap_field device = {name, strlen(name)};
        struct ap_field role = log->role.len ? log->role : device;
        *row = (struct ap_row){
            .t_ns = log->line.t_ns,
            .device = device,
            .pose = place(log, s, ap_body_part_of(role.text, role.len)),
            .trigger = s->trigger,
            .select = s->buttons & 1,
            .reset = s->reset,
            .t_column = log->line.t_column,
            .device_column = log->line.t_column,
        };
        return true;
    }
    return false;
}

static void list_drivers(char *text, size_t size) {
    size_t n = 0;
    for (int i = 0; i < ap_driver_count() && n < size; i++)
        n += (size_t)snprintf(text + n, size - n, "%s%s", i ? ", " : "", ap_driver_at(i)->name);
}

enum ap_status ap_report_log_check_end(struct ap_error *err, const struct ap_report_log *log,
                                       const char *file) {
    if (!log->report_count)
        return ap_fail(err, AP_INPUT, "%s: no report in this HID recording", file);
    const struct ap_device_info *info = &log->first.info;
    for (int i = 0; i < log->device_count; i++) {
        const struct ap_driver *driver = log->devices[i]->driver;
        if (driver && log->pose_count)
            return AP_OK;
        if (driver)
            return ap_fail(err, AP_INPUT,
                           "%s: none of %" PRId64 " reports says where a tracker is (%s, driver "
                           "%s): is it switched on, and are these its reports?",
                           file, log->report_count, log->devices[i]->info.name, driver->name);
        if (log->devices[i]->sought)
            info = &log->devices[i]->info;
    }
    char drivers[256] = "";
    list_drivers(drivers, sizeof drivers);
    return ap_fail(
        err, AP_INPUT, "%s: no driver for '%s' (bus %x, %04x:%04x); there is one for: %s", file,
        info->name, (unsigned)info->bus, (unsigned)info->vendor, (unsigned)info->product, drivers);
}
