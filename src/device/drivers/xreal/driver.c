#include "src/device/drivers/bytes.h"
#include "src/device/drivers/fused.h"
#include "src/device/drivers/xreal/config.h"
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

enum { CONFIG_MAX = 1 << 18, OFF_MS = 50, CONFIG_MS = 1500 };

struct state {
    struct ap_imu imu;
    bool has_bias;  // somebody has calibrated them
    uint32_t left;  // of the factory's text
    uint8_t to_ask; // a command; 0: none
    struct ap_xreal_config config;
};

static void init(void *state, const struct ap_device_info *info) {
    const struct ap_imu_params params = {
        .period_s = 0.001, .bits = 64, .tick_ns_num = 1, .tick_ns_den = 1};
    struct state *s = state;
    struct ap_vec3 gyr = info->bias.gyr_rad_s, acc = info->bias.acc_m_s2;
    ap_driver_begin_fused(&s->imu, &params, info);
    s->has_bias = ap_vec3_dot(gyr, gyr) > 0 || ap_vec3_dot(acc, acc) > 0;
}

// Reports are not numbered: a 0 stands before the command.
static struct ap_driver_step command(uint8_t number, const uint8_t *payload, size_t len,
                                     uint32_t wait_ms) {
    struct ap_driver_step step = {
        .kind = AP_STEP_OUTPUT, .len = 1 + AP_XREAL_COMMAND, .wait_ms = wait_ms};
    ap_xreal_command(step.bytes + 1, number, payload, len);
    return step;
}

static const uint8_t on = 1, off = 0;

// The stream stands still while the factory's text is read, piece after piece, as long as there are
// answers; it begins whether there are any or not.
static int start(const struct ap_device_info *info,
                 struct ap_driver_step steps[AP_DRIVER_STEPS_MAX]) {
    (void)info;
    steps[0] = command(AP_XREAL_STREAM, &off, 1, OFF_MS);
    steps[1] = command(AP_XREAL_CONFIG_LENGTH, NULL, 0, CONFIG_MS);
    steps[2] = command(AP_XREAL_STREAM, &on, 1, 0);
    return 3;
}

static bool ask(void *state, struct ap_driver_step *step) {
    struct state *s = state;
    uint8_t number = s->to_ask;
    s->to_ask = 0;
    if (number)
        *step = command(number, &on, number == AP_XREAL_STREAM, 0);
    return number != 0;
}

static void take_answer(struct state *s, const struct ap_xreal_answer *a) {
    if (a->command == AP_XREAL_CONFIG_LENGTH && a->len >= 4) {
        s->left = ap_u32le(a->payload);
        s->config = (struct ap_xreal_config){0};
        s->to_ask = s->left > 0 && s->left <= CONFIG_MAX ? AP_XREAL_CONFIG_NEXT : AP_XREAL_STREAM;
        s->left = s->to_ask == AP_XREAL_STREAM ? 0 : s->left;
    } else if (a->command == AP_XREAL_CONFIG_NEXT && s->left > 0 && a->len > 0) {
        uint32_t n = a->len < s->left ? (uint32_t)a->len : s->left;
        ap_xreal_config_read(&s->config, (const char *)a->payload, n);
        s->left -= n;
        s->to_ask = s->left ? AP_XREAL_CONFIG_NEXT : AP_XREAL_STREAM;
        if (!s->left && !s->has_bias)
            ap_xreal_config_bias(&s->config, &s->imu.bias);
    }
}

static enum ap_report_verdict parse(void *state, const struct ap_device_info *info, int64_t t_ns,
                                    const uint8_t *bytes, size_t len,
                                    struct ap_driver_samples *samples) {
    (void)info, (void)t_ns;
    struct state *s = state;
    struct ap_xreal_packet p;
    struct ap_xreal_answer answer;
    enum ap_report_verdict verdict = ap_xreal_parse(bytes, len, &p);
    if (verdict == AP_REPORT_BAD)
        return ap_report_bad(samples, "a report of %d bytes with divisors", AP_XREAL_REPORT);
    if (verdict == AP_REPORT_IGNORED && ap_xreal_parse_answer(bytes, len, &answer))
        take_answer(s, &answer);
    if (verdict == AP_REPORT_OK &&
        !ap_driver_add_fused(samples, &s->imu, p.device_ns, p.gyr_rad_s, p.acc_m_s2))
        return AP_REPORT_IGNORED;
    return verdict;
}

_Static_assert(sizeof(struct state) <= AP_DRIVER_STATE_MAX, "the fusion's state fits");

const struct ap_driver ap_driver_xreal = {
    .name = "xreal",
    .title = "XREAL Air, Air 2, Air 2 Pro, Air 2 Ultra",
    .ids = ids,
    .degrees = 3,
    .state_bytes = sizeof(struct state),
    .init = init,
    .start = start,
    .ask = ask,
    .parse = parse,
};
