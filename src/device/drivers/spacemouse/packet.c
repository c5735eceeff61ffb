#include "src/device/drivers/spacemouse/spacemouse.h"

enum { PAGE_DESKTOP = 1, PAGE_BUTTON = 9, USAGE_X = 0x30 };

bool ap_spacemouse_find(const struct ap_hid_descriptor *d, struct ap_spacemouse_layout *layout) {
    for (uint32_t a = 0; a < AP_SPACEMOUSE_AXES; a++)
        layout->axis[a] = ap_hid_find(d, AP_HID_INPUT, AP_HID_USAGE(PAGE_DESKTOP, USAGE_X + a), 0,
                                      &layout->axis_at[a]);
    uint32_t at;
    layout->buttons = ap_hid_find(d, AP_HID_INPUT, AP_HID_USAGE(PAGE_BUTTON, 1), 0, &at);
    if (layout->buttons >= 0 && (at != 0 || !d->fields[layout->buttons].is_variable))
        layout->buttons = -1;
    return layout->axis[0] >= 0 && layout->axis[1] >= 0 && layout->axis[2] >= 0;
}

// Old caps go beyond the range they declare.
static double fraction(const struct ap_hid_field *f, int64_t raw) {
    double lmin = (double)f->logical_min, lmax = (double)f->logical_max;
    if (lmax <= lmin)
        return 0;
    bool balanced = lmin < 0 && lmax > 0;
    double centre = balanced ? 0 : (lmin + lmax) / 2;
    double half = balanced ? (lmax > -lmin ? lmax : -lmin) : (lmax - lmin) / 2;
    double v = ((double)raw - centre) / half;
    return v < -1 ? -1 : v > 1 ? 1 : v;
}

enum ap_report_verdict ap_spacemouse_parse(const struct ap_hid_descriptor *d,
                                           const struct ap_spacemouse_layout *layout,
                                           const uint8_t *bytes, size_t len,
                                           struct ap_spacemouse_report *report) {
    *report = (struct ap_spacemouse_report){0};
    bool any = false;
    for (uint32_t a = 0; a < AP_SPACEMOUSE_AXES; a++) {
        const struct ap_hid_field *f = layout->axis[a] < 0 ? NULL : &d->fields[layout->axis[a]];
        if (!f || len == 0 || (f->report_id && f->report_id != bytes[0]))
            continue;
        struct ap_hid_value value;
        if (!ap_hid_extract(f, bytes, len, layout->axis_at[a], &value))
            return AP_REPORT_BAD;
        report->has_axis[a] = any = true;
        report->axis[a] = fraction(f, value.raw);
    }
    const struct ap_hid_field *f = layout->buttons < 0 ? NULL : &d->fields[layout->buttons];
    for (uint32_t b = 0; f && b < f->count && b < 32; b++) {
        struct ap_hid_value value;
        if (!ap_hid_extract(f, bytes, len, b, &value))
            break;
        report->has_buttons = any = true;
        report->buttons |= (uint32_t)(value.raw != 0) << b;
    }
    return any ? AP_REPORT_OK : AP_REPORT_IGNORED;
}

double ap_spacemouse_hold_s(double dt_s) {
    static const double HOLD = 0.1, FALL = 0.1;
    if (!(dt_s > 0))
        return 0;
    if (dt_s <= HOLD)
        return dt_s;
    double u = dt_s - HOLD < FALL ? dt_s - HOLD : FALL;
    return HOLD + u - u * u / (2 * FALL);
}
