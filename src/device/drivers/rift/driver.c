#include <string.h>

#include "src/device/drivers/fused.h"
#include "src/device/drivers/rift/rift.h"

enum {
    CONFIG = 0x02,
    CONFIG_LEN = 7,
    KEEP_ALIVE = 0x08,
    COMPONENTS = 0x1d,
    USE_CALIBRATION = 0x04,
    AUTO_CALIBRATION = 0x08,
    SENSOR_AXES = 0x40,
    ALIVE_MS = 10000,
    REPEAT_MS = 3000, // two may get lost
};

struct state {
    const struct ap_rift_layout *layout;
    struct ap_imu imu;
};

static const struct ap_rift_layout *layout_of(const struct ap_device_info *info) {
    return ap_driver_ids_of(&ap_driver_rift, info)->model;
}

static void init(void *state, const struct ap_device_info *info) {
    struct state *s = state;
    s->layout = layout_of(info);
    ap_driver_begin_fused(&s->imu, &s->layout->imu, info);
}

// What the sensor's configuration was, but with its own calibration, the headset's axes and long
// enough alive. Where it is not known, 500 reports a second of two measurements.
static struct ap_driver_step configure(const struct ap_device_info *info) {
    struct ap_driver_step step = {
        .kind = AP_STEP_SET_FEATURE, .len = CONFIG_LEN, .bytes = {CONFIG, 0, 0, 0, 1}};
    const struct ap_feature_report *known = ap_device_feature(info, CONFIG);
    if (known && known->len >= CONFIG_LEN)
        memcpy(step.bytes, known->bytes, CONFIG_LEN);
    step.bytes[3] = (uint8_t)((step.bytes[3] | USE_CALIBRATION | AUTO_CALIBRATION) & ~SENSOR_AXES);
    step.bytes[5] = ALIVE_MS & 255;
    step.bytes[6] = ALIVE_MS >> 8;
    return step;
}

static int start(const struct ap_device_info *info,
                 struct ap_driver_step steps[AP_DRIVER_STEPS_MAX]) {
    int n = 0;
    steps[n++] = configure(info);
    if (layout_of(info)->has_components)
        steps[n++] = (struct ap_driver_step){
            .kind = AP_STEP_SET_FEATURE, .len = 4, .bytes = {COMPONENTS, 0, 0, 7}};
    steps[n++] = (struct ap_driver_step){.kind = AP_STEP_SET_FEATURE,
                                         .len = 5,
                                         .bytes = {KEEP_ALIVE, 0, 0, ALIVE_MS & 255, ALIVE_MS >> 8},
                                         .repeat_ms = REPEAT_MS};
    return n;
}

static enum ap_report_verdict parse(void *state, const struct ap_device_info *info, int64_t t_ns,
                                    const uint8_t *bytes, size_t len,
                                    struct ap_driver_samples *samples) {
    (void)info, (void)t_ns;
    struct state *s = state;
    struct ap_rift_packet p;
    enum ap_report_verdict verdict = ap_rift_parse(s->layout, bytes, len, &p);
    if (verdict == AP_REPORT_BAD)
        return ap_report_bad(samples, "a report %02x of %zu bytes with a measurement",
                             (unsigned)s->layout->report, s->layout->len);
    if (verdict != AP_REPORT_OK)
        return verdict;
    return ap_driver_add_series(samples, &s->imu, p.at, p.count) ? AP_REPORT_OK : AP_REPORT_IGNORED;
}

_Static_assert(sizeof(struct state) <= AP_DRIVER_STATE_MAX, "the fusion's state fits");

const struct ap_driver ap_driver_rift = {
    .name = "rift",
    .title = "Oculus Rift DK1, DK2, CV1",
    .state_bytes = sizeof(struct state),
    .init = init,
    .start = start,
    .parse = parse,
    .degrees = 3,
    .ids = ap_rift_ids,
};
