#include "src/device/drivers/hydra/hydra.h"

// Where the base stands in the room as long as nobody has said: on a table before the person.
static const struct ap_vec3 BASE_M = {0, 0.8, -0.5};

enum { REPORTS = 0, COMMANDS = 1 }; // interfaces
enum { RETRY_MS = 5000 };

static const struct ap_driver_ids ids[] = {
    {AP_PRODUCT(0x1532, 0x0300)},
    {0},
};

// Each interface is a device of its own here: the first one reports, the second one is told.
static bool is_interface(const struct ap_device_info *info, int number) {
    return !info->interface_known || info->interface_number == number;
}

// From mouse to motion mode; the answer must be fetched. It does not always take.
static int start(const struct ap_device_info *info,
                 struct ap_driver_step steps[AP_DRIVER_STEPS_MAX]) {
    if (!is_interface(info, COMMANDS))
        return 0;
    steps[0] = (struct ap_driver_step){
        .kind = AP_STEP_SET_FEATURE, .len = 91, .repeat_ms = RETRY_MS, .if_silent = true};
    steps[0].bytes[6] = 1;
    steps[0].bytes[8] = 4;
    steps[0].bytes[9] = 3;
    steps[0].bytes[89] = 6;
    steps[1] = (struct ap_driver_step){
        .kind = AP_STEP_GET_FEATURE, .len = 91, .repeat_ms = RETRY_MS, .if_silent = true};
    return 2;
}

static enum ap_report_verdict parse(void *state, const struct ap_device_info *info, int64_t t_ns,
                                    const uint8_t *bytes, size_t len,
                                    struct ap_driver_samples *samples) {
    (void)state, (void)t_ns;
    struct ap_hydra_controller c[2];
    if (!is_interface(info, REPORTS))
        return AP_REPORT_IGNORED;
    if (ap_hydra_parse(bytes, len, c) != AP_REPORT_OK)
        return ap_report_bad(samples, "a report of %d bytes with two unit quaternions",
                             AP_HYDRA_REPORT);
    for (int i = 0; i < 2; i++) {
        struct ap_driver_sample *sample = ap_driver_add_sample(samples);
        sample->kind = AP_SAMPLE_POSE;
        sample->tracker = i;
        sample->pose = (struct ap_pose){ap_vec3_add(BASE_M, c[i].p_m), c[i].q};
        sample->buttons = c[i].buttons;
        sample->trigger = (float)c[i].trigger;
    }
    return AP_REPORT_OK;
}

const struct ap_driver ap_driver_hydra = {
    .name = "hydra",
    .title = "Razer Hydra",
    .hands_first = true,
    .ids = ids,
    .degrees = 6,
    .start = start,
    .parse = parse,
};
