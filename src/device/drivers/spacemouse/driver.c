#include "src/device/drivers/sensor.h"
#include "src/device/drivers/spacemouse/spacemouse.h"

// At full deflection.
static const double FASTEST_M_S = 1.0;
static const double FASTEST_RAD_S = 1.57079632679489661923;

// What the maker has sold as a cap, under the two vendors' ids that it has used.
static const struct ap_driver_ids ids[] = {
    {.vendor = 0x046d, .first_product = 0xc603, .last_product = 0xc62b},
    {.vendor = 0x256f, .first_product = 0xc62e, .last_product = 0xc63a},
    {AP_PRODUCT(0x256f, 0xc652)},
    {0},
};

struct state {
    struct ap_spacemouse_layout layout;
    struct ap_pose pose;
    double rate[AP_SPACEMOUSE_AXES];
    bool has_before;
    int64_t before_ns; // of the pose
    double moved_s;    // how long ago, then, the rate was reported
    uint32_t buttons;
};

// By the usage, not by names: whatever has six axes of a "multi-axis controller". The maker's mice
// and keyboards that declare one, too, have no cap.
static bool match(const struct ap_device_info *info) {
    static const uint16_t others[] = {0xc650, 0xc651, 0xc654, 0xc655, 0xc656,
                                      0xc657, 0xc658, 0xc664, 0xc665, 0xc668};
    for (size_t i = 0; info->vendor == 0x256f && i < sizeof others / sizeof *others; i++)
        if (info->product == others[i])
            return false;
    struct ap_spacemouse_layout layout;
    return ap_hid_has_application(&info->descriptor, AP_HID_USAGE(1, 8)) &&
           ap_spacemouse_find(&info->descriptor, &layout);
}

static void init(void *state, const struct ap_device_info *info) {
    struct state *s = state;
    ap_spacemouse_find(&info->descriptor, &s->layout);
    s->pose = AP_POSE_IDENTITY;
}

// The cap's axes: x right, y back, z down.
static struct ap_vec3 y_up(const double *v, double scale) {
    return (struct ap_vec3){scale * v[0], -scale * v[2], scale * v[1]};
}

// Flies on as it was last told to, in its own axes; the half turned orientation is the mean one.
static void fly(struct state *s, double dt_s) {
    double t = ap_spacemouse_hold_s(s->moved_s + dt_s) - ap_spacemouse_hold_s(s->moved_s);
    struct ap_vec3 turn = y_up(s->rate + 3, FASTEST_RAD_S * t);
    struct ap_quat half = ap_quat_from_rotation_vector(ap_vec3_scale(0.5, turn));
    struct ap_quat mean = ap_quat_mul(s->pose.q, half);
    s->pose.p = ap_vec3_add(s->pose.p, ap_quat_rotate(mean, y_up(s->rate, FASTEST_M_S * t)));
    s->pose.q = ap_quat_normalize(ap_quat_mul(mean, half));
    s->moved_s += dt_s;
}

static enum ap_report_verdict parse(void *state, const struct ap_device_info *info, int64_t t_ns,
                                    const uint8_t *bytes, size_t len,
                                    struct ap_driver_samples *samples) {
    struct state *s = state;
    struct ap_spacemouse_report r;
    enum ap_report_verdict verdict =
        ap_spacemouse_parse(&info->descriptor, &s->layout, bytes, len, &r);
    if (verdict == AP_REPORT_BAD)
        return ap_report_bad(samples, "a report of %zu bytes",
                             ap_hid_input_bytes(&info->descriptor, bytes));
    if (verdict)
        return verdict;
    if (s->has_before)
        fly(s, (double)(t_ns - s->before_ns) / 1e9);
    for (int a = 0; a < AP_SPACEMOUSE_AXES; a++)
        if (r.has_axis[a]) {
            s->rate[a] = r.axis[a];
            s->moved_s = 0;
        }
    if (r.has_buttons)
        s->buttons = r.buttons;
    s->has_before = true;
    s->before_ns = t_ns;
    struct ap_driver_sample *sample = ap_driver_add_sample(samples);
    sample->kind = AP_SAMPLE_FLIGHT;
    sample->pose = s->pose;
    sample->has_rate = true;
    sample->angular_velocity_rad_s = y_up(s->rate + 3, FASTEST_RAD_S);
    sample->buttons = s->buttons;
    return AP_REPORT_OK;
}

_Static_assert(sizeof(struct state) <= AP_DRIVER_STATE_MAX, "state");

static void idle(const void *state, const struct ap_device_info *info, int64_t t_ns,
                 struct ap_driver_samples *samples) {
    (void)info;
    struct state s = *(const struct state *)state;
    if (s.has_before)
        fly(&s, (double)(t_ns - s.before_ns) / 1e9);
    struct ap_driver_sample *sample = ap_driver_add_sample(samples);
    sample->kind = AP_SAMPLE_FLIGHT;
    sample->pose = s.pose;
    sample->buttons = s.buttons;
}

const struct ap_driver ap_driver_spacemouse = {
    .name = "spacemouse",
    .title = "3Dconnexion SpaceMouse",
    .ids = ids,
    .degrees = 6,
    .recentre = 2,
    .idle = idle,
    .state_bytes = sizeof(struct state),
    .match = match,
    .init = init,
    .parse = parse,
};
