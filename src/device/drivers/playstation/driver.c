#include "src/device/drivers/fused.h"
#include "src/device/drivers/playstation/playstation.h"

struct state {
    const struct ap_playstation_layout *layout;
    struct ap_playstation_calibration calibration;
    struct ap_imu imu;
};

static const struct ap_playstation_layout *layout_of(const struct ap_device_info *info) {
    return ap_driver_ids_of(&ap_driver_playstation, info)->model;
}

static void init(void *state, const struct ap_device_info *info) {
    struct state *s = state;
    s->layout = layout_of(info);
    s->calibration =
        ap_playstation_calibrate(s->layout, ap_device_feature(info, s->layout->calibration));
    ap_driver_begin_fused(&s->imu, &s->layout->imu, info);
}

static int start(const struct ap_device_info *info,
                 struct ap_driver_step steps[AP_DRIVER_STEPS_MAX]) {
    const struct ap_playstation_layout *layout = layout_of(info);
    steps[0] = (struct ap_driver_step){.kind = AP_STEP_GET_FEATURE,
                                       .len = layout->calibration_len,
                                       .bytes = {layout->calibration}};
    return 1;
}

static enum ap_report_verdict parse(void *state, const struct ap_device_info *info, int64_t t_ns,
                                    const uint8_t *bytes, size_t len,
                                    struct ap_driver_samples *samples) {
    (void)info, (void)t_ns;
    struct state *s = state;
    struct ap_playstation_packet p;
    enum ap_report_verdict verdict =
        ap_playstation_parse(s->layout, &s->calibration, bytes, len, &p);
    if (verdict == AP_REPORT_BAD)
        return ap_report_bad(samples, "a report %02x of %zu bytes%s", (unsigned)s->layout->report,
                             s->layout->len, s->layout->has_crc ? " with a right check sum" : "");
    if (verdict != AP_REPORT_OK)
        return verdict;
    struct ap_driver_sample *sample =
        ap_driver_add_fused(samples, &s->imu, p.ticks, p.gyr_rad_s, p.acc_m_s2);
    return ap_driver_add_controls(sample, p.buttons, p.trigger, p.battery);
}

_Static_assert(sizeof(struct state) <= AP_DRIVER_STATE_MAX, "the fusion's state fits");

const struct ap_driver ap_driver_playstation = {
    .name = "playstation",
    .title = "DualSense, DualShock 4",
    .hands_first = true,
    .ids = ap_playstation_ids,
    .degrees = 3,
    .recentre = AP_PLAYSTATION_HOME,
    .state_bytes = sizeof(struct state),
    .init = init,
    .start = start,
    .parse = parse,
};
