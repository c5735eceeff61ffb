#include <string.h>

#include "src/device/drivers/android/android.h"
#include "src/device/drivers/sensor.h"

// Any maker may build one; these are the known ones, and a bus that udev has rules for.
static const struct ap_driver_ids ids[] = {
    {.bus = 5, .vendor = 0x054c, .first_product = 0, .last_product = 0xffff},
    {0},
};

struct state {
    struct ap_android_layout layout;
    bool has_before;
    int64_t before_ns, counter;
    struct ap_quat before;
};

// The description begins with the protocol's name. A recording made without feature reports has
// none; then the fields, which nothing else has, must do.
static bool match(const struct ap_device_info *info) {
    static const char magic[] = "#AndroidHeadTracker#";
    const struct ap_hid_descriptor *d = &info->descriptor;
    struct ap_android_layout layout;
    if (!ap_hid_has_application(d, AP_HID_USAGE(AP_SENSOR_PAGE, 0xe1)) ||
        !ap_android_find(d, &layout))
        return false;
    uint32_t at;
    int f = ap_hid_find(d, AP_HID_FEATURE, AP_HID_USAGE(AP_SENSOR_PAGE, 0x0308), 0, &at);
    const struct ap_feature_report *text =
        f >= 0 ? ap_device_feature(info, d->fields[f].report_id) : NULL;
    if (!text)
        return true;
    for (uint32_t i = 0; i < sizeof magic - 1; i++) {
        struct ap_hid_value c;
        if (!ap_hid_extract(&d->fields[f], text->bytes, text->len, at + i, &c) || c.raw != magic[i])
            return false;
    }
    return true;
}

static void init(void *state, const struct ap_device_info *info) {
    struct state *s = state;
    ap_android_find(&info->descriptor, &s->layout);
}

// Reporting on, full power, every 10 ms, and in version 2 over the classic (ACL) link.
static int start(const struct ap_device_info *info,
                 struct ap_driver_step steps[AP_DRIVER_STEPS_MAX]) {
    static const uint32_t LE_TRANSPORT_ACL = AP_HID_USAGE(AP_SENSOR_PAGE, 0xf800);
    return ap_sensor_start(info, 0.01, LE_TRANSPORT_ACL, steps);
}

// Some devices send no angular velocity but zeros: then it is what led from the pose before here.
static void find_rate(struct state *s, const struct ap_android_report *r, int64_t t_ns,
                      struct ap_driver_sample *sample) {
    struct ap_vec3 w = ap_y_up_vec3(r->rate_rad_s);
    bool zero = w.x == 0 && w.y == 0 && w.z == 0;
    if (r->has_rate && !zero) {
        sample->has_rate = true;
        sample->angular_velocity_rad_s = w;
    } else if (s->has_before && !sample->reset && t_ns > s->before_ns &&
               t_ns - s->before_ns <= 200000000) {
        struct ap_quat d = ap_quat_mul(ap_quat_conj(s->before), sample->pose.q);
        sample->has_rate = true;
        sample->angular_velocity_rad_s =
            ap_vec3_scale(1e9 / (double)(t_ns - s->before_ns), ap_rotation_vector_from_quat(d));
    }
}

static enum ap_report_verdict parse(void *state, const struct ap_device_info *info, int64_t t_ns,
                                    const uint8_t *bytes, size_t len,
                                    struct ap_driver_samples *samples) {
    struct state *s = state;
    struct ap_android_report r;
    enum ap_report_verdict verdict =
        ap_android_parse(&info->descriptor, &s->layout, bytes, len, &r);
    if (verdict == AP_REPORT_BAD)
        return ap_report_bad(samples, "a report of %zu bytes with a rotation vector below 2 pi",
                             ap_hid_input_bytes(&info->descriptor, bytes));
    if (verdict)
        return verdict;
    struct ap_driver_sample *sample = ap_driver_add_sample(samples);
    sample->kind = AP_SAMPLE_ORIENTATION;
    sample->pose.q = ap_quat_from_rotation_vector(ap_y_up_vec3(r.rotation_rad));
    sample->reset = s->has_before && r.has_counter && r.counter != s->counter;
    sample->has_reset_count = r.has_counter;
    sample->reset_count = (uint32_t)r.counter;
    find_rate(s, &r, t_ns, sample);
    s->has_before = true;
    s->before_ns = t_ns;
    s->before = sample->pose.q;
    s->counter = r.counter;
    return AP_REPORT_OK;
}

_Static_assert(sizeof(struct state) <= AP_DRIVER_STATE_MAX, "state");

const struct ap_driver ap_driver_android = {
    .name = "android-head-tracker",
    .title = "Android head tracker",
    .ids = ids,
    .degrees = 3,
    .state_bytes = sizeof(struct state),
    .match = match,
    .init = init,
    .start = start,
    .parse = parse,
};
