#include "src/device/drivers/sensor.h"

#include <math.h>
#include <string.h>

struct ap_vec3 ap_y_up_vec3(struct ap_vec3 v) {
    return (struct ap_vec3){v.x, v.z, -v.y};
}

struct ap_quat ap_y_up_quat(struct ap_quat q) {
    return (struct ap_quat){q.x, q.z, -q.y, q.w};
}

struct ap_quat ap_quat_from_rotation_vector(struct ap_vec3 v) {
    double angle = ap_vec3_length(v);
    return angle > 0 ? ap_quat_from_axis_angle(ap_vec3_scale(1 / angle, v), angle)
                     : AP_QUAT_IDENTITY;
}

struct ap_vec3 ap_rotation_vector_from_quat(struct ap_quat q) {
    if (q.w < 0)
        q = (struct ap_quat){-q.x, -q.y, -q.z, -q.w};
    struct ap_vec3 v = {q.x, q.y, q.z};
    double sine = ap_vec3_length(v);
    double angle = 2 * atan2(sine, q.w);
    return ap_vec3_scale(sine > 1e-9 ? angle / sine : 2, v);
}

// The step that sends this report, made of what the device is known to have in it.
static struct ap_driver_step *step_of(const struct ap_device_info *info, uint8_t id, int *count,
                                      struct ap_driver_step steps[AP_DRIVER_STEPS_MAX]) {
    for (int i = 0; i < *count; i++)
        if (steps[i].bytes[0] == id)
            return &steps[i];
    // Unnumbered reports are sent with a leading zero that is not in their layout; no head tracker
    // or sensor hub that can be switched on is built so.
    size_t len = ap_hid_report_bytes(&info->descriptor, AP_HID_FEATURE, id);
    if (id == 0 || len < 2 || len > AP_DRIVER_STEP_BYTES || *count == AP_DRIVER_STEPS_MAX)
        return NULL;
    struct ap_driver_step *step = &steps[(*count)++];
    *step = (struct ap_driver_step){.kind = AP_STEP_SET_FEATURE, .len = len};
    const struct ap_feature_report *known = ap_device_feature(info, id);
    if (known)
        memcpy(step->bytes, known->bytes, known->len < len ? known->len : len);
    step->bytes[0] = id;
    return step;
}

// An array is set to one of its choices; which number that is stands in the descriptor.
static void choose(const struct ap_device_info *info, uint32_t usage, int *count,
                   struct ap_driver_step *steps) {
    uint32_t at;
    int n = ap_hid_find(&info->descriptor, AP_HID_FEATURE, usage, 0, &at);
    if (n < 0 || info->descriptor.fields[n].is_variable)
        return;
    const struct ap_hid_field *f = &info->descriptor.fields[n];
    struct ap_driver_step *step = step_of(info, f->report_id, count, steps);
    if (step)
        ap_hid_insert(f, step->bytes, step->len, 0, f->logical_min + at);
}

int ap_sensor_start(const struct ap_device_info *info, double interval_s, uint32_t transport,
                    struct ap_driver_step steps[AP_DRIVER_STEPS_MAX]) {
    static const uint32_t INTERVAL = AP_HID_USAGE(AP_SENSOR_PAGE, 0x030e);
    int count = 0;
    choose(info, AP_HID_USAGE(AP_SENSOR_PAGE, 0x0841), &count, steps); // all events
    choose(info, AP_HID_USAGE(AP_SENSOR_PAGE, 0x0851), &count, steps); // full power
    if (transport)
        choose(info, transport, &count, steps);
    uint32_t at;
    int n = ap_hid_find(&info->descriptor, AP_HID_FEATURE, INTERVAL, 0, &at);
    if (n < 0)
        return count;
    // By the standard the interval is in milliseconds where no unit says otherwise; Android's is in
    // units of 10^−3 of a second, which comes to the same.
    struct ap_hid_field f = info->descriptor.fields[n];
    if (f.exponent == 0)
        f.exponent = -3;
    struct ap_driver_step *step = step_of(info, f.report_id, &count, steps);
    if (step)
        ap_hid_insert(&f, step->bytes, step->len, at, ap_hid_raw_from_physical(&f, interval_s));
    return count;
}
