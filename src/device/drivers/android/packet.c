#include "src/device/drivers/android/android.h"

enum { PAGE_SENSORS = 0x20 };

static const uint32_t ROTATION_VECTOR = AP_HID_USAGE(PAGE_SENSORS, 0x0544);
static const uint32_t ANGULAR_VELOCITY = AP_HID_USAGE(PAGE_SENSORS, 0x0545);
static const uint32_t RESET_COUNTER = AP_HID_USAGE(PAGE_SENSORS, 0x0546);

bool ap_android_find(const struct ap_hid_descriptor *d, struct ap_android_layout *layout) {
    struct ap_android_layout l = {-1, -1, -1, 0, 0, 0};
    l.vector = ap_hid_find(d, AP_HID_INPUT, ROTATION_VECTOR, 0, &l.vector_at);
    l.rate = ap_hid_find(d, AP_HID_INPUT, ANGULAR_VELOCITY, 0, &l.rate_at);
    l.counter = ap_hid_find(d, AP_HID_INPUT, RESET_COUNTER, 0, &l.counter_at);
    if (l.vector < 0 || d->fields[l.vector].count - l.vector_at < 3)
        return false;
    *layout = l;
    return true;
}

static bool read_vector(const struct ap_hid_field *f, uint32_t at, const uint8_t *bytes, size_t len,
                        struct ap_vec3 *v) {
    struct ap_hid_value x, y, z;
    if (!ap_hid_extract(f, bytes, len, at, &x) || !ap_hid_extract(f, bytes, len, at + 1, &y) ||
        !ap_hid_extract(f, bytes, len, at + 2, &z))
        return false;
    *v = (struct ap_vec3){x.physical, y.physical, z.physical};
    return true;
}

enum ap_report_verdict ap_android_parse(const struct ap_hid_descriptor *d,
                                        const struct ap_android_layout *layout,
                                        const uint8_t *bytes, size_t len,
                                        struct ap_android_report *report) {
    const struct ap_hid_field *vector = &d->fields[layout->vector];
    *report = (struct ap_android_report){0};
    if (len == 0 || (vector->report_id && bytes[0] != vector->report_id))
        return AP_REPORT_IGNORED;
    if (!read_vector(vector, layout->vector_at, bytes, len, &report->rotation_rad))
        return AP_REPORT_BAD;
    // The protocol says at most π; more than a rounding beyond it is no rotation vector.
    if (!(ap_vec3_length(report->rotation_rad) < 6.3))
        return AP_REPORT_BAD;
    report->has_rate = layout->rate >= 0 && read_vector(&d->fields[layout->rate], layout->rate_at,
                                                        bytes, len, &report->rate_rad_s);
    struct ap_hid_value counter;
    report->has_counter = layout->counter >= 0 && ap_hid_extract(&d->fields[layout->counter], bytes,
                                                                 len, layout->counter_at, &counter);
    if (report->has_counter)
        report->counter = counter.raw;
    return AP_REPORT_OK;
}
