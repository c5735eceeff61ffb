#include "src/device/drivers/fused.h"
#include "src/device/drivers/xreal/xreal.h"

// Takes commands to the screens and measures nothing; the Ultra has it elsewhere.
enum { SCREENS = 1 << 4 };

static const struct ap_driver_ids ids[] = {
    {AP_PRODUCT(0x3318, 0x0424), .not_interfaces = SCREENS},
    {AP_PRODUCT(0x3318, 0x0426)}, // the Ultra
    {AP_PRODUCT(0x3318, 0x0428), .not_interfaces = SCREENS},
    {AP_PRODUCT(0x3318, 0x0432), .not_interfaces = SCREENS},
    {0},
};

static void init(void *state, const struct ap_device_info *info) {
    const struct ap_imu_params params = {
        .period_s = 0.001, .bits = 64, .tick_ns_num = 1, .tick_ns_den = 1};
    struct ap_imu *imu = state;
    ap_driver_begin_fused(imu, &params, info);
}

// Command 0x19 turns the stream on. Reports are not numbered: a 0 stands before the command.
static int start(const struct ap_device_info *info,
                 struct ap_driver_step steps[AP_DRIVER_STEPS_MAX]) {
    (void)info;
    steps[0] = (struct ap_driver_step){.kind = AP_STEP_OUTPUT, .len = 1 + AP_XREAL_COMMAND};
    ap_xreal_command(steps[0].bytes + 1, 0x19, 1);
    return 1;
}

static enum ap_report_verdict parse(void *state, const struct ap_device_info *info, int64_t t_ns,
                                    const uint8_t *bytes, size_t len,
                                    struct ap_driver_samples *samples) {
    (void)info, (void)t_ns;
    struct ap_xreal_packet p;
    enum ap_report_verdict verdict = ap_xreal_parse(bytes, len, &p);
    if (verdict == AP_REPORT_BAD)
        return ap_report_bad(samples, "a report of %d bytes with divisors", AP_XREAL_REPORT);
    if (verdict == AP_REPORT_OK &&
        !ap_driver_add_fused(samples, state, p.device_ns, p.gyr_rad_s, p.acc_m_s2))
        return AP_REPORT_IGNORED;
    return verdict;
}

_Static_assert(sizeof(struct ap_imu) <= AP_DRIVER_STATE_MAX, "the fusion's state fits");

const struct ap_driver ap_driver_xreal = {
    .name = "xreal",
    .title = "XREAL Air, Air 2, Air 2 Pro, Air 2 Ultra",
    .ids = ids,
    .degrees = 3,
    .state_bytes = sizeof(struct ap_imu),
    .init = init,
    .start = start,
    .parse = parse,
};
