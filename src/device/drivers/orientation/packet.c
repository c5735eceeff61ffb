#include "src/device/drivers/orientation/orientation.h"
#include "src/device/drivers/sensor.h"

static const uint32_t QUATERNION = AP_HID_USAGE(AP_SENSOR_PAGE, 0x0483);

// What stands for something to steer a head with, best first.
static int rank(const struct ap_hid_descriptor *d, const struct ap_hid_field *f) {
    if (ap_hid_is_within(d, f->collection, AP_HID_USAGE(AP_SENSOR_PAGE, 0x8e)))
        return 3;
    return ap_hid_is_within(d, f->collection, AP_HID_USAGE(AP_SENSOR_PAGE, 0x8a)) ? 2 : 1;
}

bool ap_orientation_find(const struct ap_hid_descriptor *d, struct ap_orientation_layout *layout) {
    int best = 0;
    uint32_t at;
    for (int i = ap_hid_find(d, AP_HID_INPUT, QUATERNION, 0, &at); i >= 0;
         i = ap_hid_find(d, AP_HID_INPUT, QUATERNION, i + 1, &at)) {
        const struct ap_hid_field *f = &d->fields[i];
        if (!f->is_variable || f->count - at < 4 || f->size_bits > 32 || rank(d, f) <= best)
            continue;
        best = rank(d, f);
        *layout = (struct ap_orientation_layout){i, at};
    }
    return best > 0;
}

enum ap_report_verdict ap_orientation_parse(const struct ap_hid_descriptor *d,
                                            const struct ap_orientation_layout *layout,
                                            const uint8_t *bytes, size_t len, struct ap_quat *q) {
    const struct ap_hid_field *f = &d->fields[layout->field];
    if (len == 0 || (f->report_id && bytes[0] != f->report_id))
        return AP_REPORT_IGNORED;
    double v[4];
    for (uint32_t k = 0; k < 4; k++) {
        struct ap_hid_value value;
        if (!ap_hid_extract(f, bytes, len, layout->at + k, &value))
            return AP_REPORT_BAD;
        v[k] = (double)value.raw;
    }
    if (v[0] == 0 && v[1] == 0 && v[2] == 0 && v[3] == 0)
        return AP_REPORT_BAD;
    *q = ap_quat_normalize((struct ap_quat){v[0], v[1], v[2], v[3]});
    return AP_REPORT_OK;
}
