#include "src/device/drivers/fused.h"
#include "src/device/drivers/joycon/joycon.h"

enum { USB = 3 };

struct state {
    const struct ap_joycon_model *model;
    struct ap_joycon_calibration calibration;
    struct ap_imu imu;
};

static const struct ap_joycon_model *model_of(const struct ap_device_info *info) {
    return ap_driver_ids_of(&ap_driver_joycon, info)->model;
}

static const char *side(const struct ap_device_info *info) {
    return model_of(info)->side;
}

static void init(void *state, const struct ap_device_info *info) {
    struct state *s = state;
    s->model = model_of(info);
    s->calibration = ap_joycon_usual_calibration();
    // Reports come a tick or two early now and then, and may be out of order, by up to 0.16 s; the
    // timer goes round in 1.28.
    const struct ap_imu_params params = {
        .period_s = 0.005, .bits = 8, .tick_ns_num = 5000000, .tick_ns_den = 1, .late_ticks = 31};
    ap_driver_begin_fused(&s->imu, &params, info);
}

// A command within an output report, after a counter and a rumble that is none.
static struct ap_driver_step command(uint8_t count, const uint8_t *bytes, size_t len) {
    struct ap_driver_step step = {
        .kind = AP_STEP_OUTPUT,
        .len = 49,
        .bytes = {0x01, count & 15, 0x00, 0x01, 0x40, 0x40, 0x00, 0x01, 0x40, 0x40},
        .wait_ms = 50};
    for (size_t i = 0; i < len; i++)
        step.bytes[10 + i] = bytes[i];
    return step;
}

// On a cable: a handshake, 3 Mbit/s, the handshake again, no timeout. Then the two
// calibrations, the sensor, full reports.
static int start(const struct ap_device_info *info,
                 struct ap_driver_step steps[AP_DRIVER_STEPS_MAX]) {
    static const uint8_t handshake[] = {2, 3, 2, 4};
    static const uint8_t makers[] = {0x10, 0x20, 0x60, 0, 0, 24},
                         users[] = {0x10, 0x26, 0x80, 0, 0, 26}, sensor[] = {0x40, 1},
                         full[] = {0x03, 0x30};
    int n = 0;
    for (size_t i = 0; i < sizeof handshake && info->bus == USB; i++)
        steps[n++] = (struct ap_driver_step){
            .kind = AP_STEP_OUTPUT, .len = 2, .bytes = {0x80, handshake[i]}, .wait_ms = 50};
    steps[n++] = command(0, makers, sizeof makers);
    steps[n++] = command(1, users, sizeof users);
    steps[n++] = command(2, sensor, sizeof sensor);
    steps[n++] = command(3, full, sizeof full);
    return n;
}

// The three measurements are three ticks, from the report's timer on. One pose comes out: the
// newest.
static enum ap_report_verdict parse(void *state, const struct ap_device_info *info, int64_t t_ns,
                                    const uint8_t *bytes, size_t len,
                                    struct ap_driver_samples *samples) {
    (void)info, (void)t_ns;
    struct state *s = state;
    struct ap_joycon_packet p;
    if (ap_joycon_read_calibration(bytes, len, &s->calibration))
        return AP_REPORT_OK;
    enum ap_report_verdict verdict = ap_joycon_parse(s->model, &s->calibration, bytes, len, &p);
    if (verdict == AP_REPORT_BAD)
        return ap_report_bad(samples, "a report of at least %d bytes", AP_JOYCON_REPORT);
    if (verdict != AP_REPORT_OK)
        return verdict;
    struct ap_driver_sample *sample =
        ap_driver_add_series(samples, &s->imu, p.at, AP_JOYCON_MEASUREMENTS);
    return ap_driver_add_controls(sample, p.buttons, p.trigger, p.battery);
}

_Static_assert(sizeof(struct state) <= AP_DRIVER_STATE_MAX, "the fusion's state fits");

const struct ap_driver ap_driver_joycon = {
    .name = "joycon",
    .title = "Joy-Con, Pro Controller",
    .hands_first = true,
    .ids = ap_joycon_ids,
    .side = side,
    .degrees = 3,
    .recentre = AP_JOYCON_HOME,
    .state_bytes = sizeof(struct state),
    .init = init,
    .start = start,
    .parse = parse,
};
