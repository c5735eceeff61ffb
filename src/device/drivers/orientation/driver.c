#include "src/device/drivers/orientation/orientation.h"
#include "src/device/drivers/sensor.h"

struct state {
    struct ap_orientation_layout layout;
};

static bool match(const struct ap_device_info *info) {
    struct ap_orientation_layout layout;
    return ap_orientation_find(&info->descriptor, &layout);
}

static void init(void *state, const struct ap_device_info *info) {
    struct state *s = state;
    ap_orientation_find(&info->descriptor, &s->layout);
}

static int start(const struct ap_device_info *info,
                 struct ap_driver_step steps[AP_DRIVER_STEPS_MAX]) {
    return ap_sensor_start(info, 0.01, 0, steps);
}

static enum ap_report_verdict parse(void *state, const struct ap_device_info *info, int64_t t_ns,
                                    const uint8_t *bytes, size_t len,
                                    struct ap_driver_samples *samples) {
    (void)t_ns;
    struct state *s = state;
    struct ap_quat q;
    enum ap_report_verdict verdict =
        ap_orientation_parse(&info->descriptor, &s->layout, bytes, len, &q);
    if (verdict == AP_REPORT_BAD)
        return ap_report_bad(samples, "a report of %zu bytes with a quaternion that is not zero",
                             ap_hid_input_bytes(&info->descriptor, bytes));
    if (verdict)
        return verdict;
    struct ap_driver_sample *sample = ap_driver_add_sample(samples);
    sample->kind = AP_SAMPLE_ORIENTATION;
    sample->pose.q = ap_y_up_quat(q);
    return AP_REPORT_OK;
}

const struct ap_driver ap_driver_orientation = {
    .name = "hid-orientation",
    .title = "HID orientation sensor",
    .degrees = 3,
    .state_bytes = sizeof(struct state),
    .match = match,
    .init = init,
    .start = start,
    .parse = parse,
};
