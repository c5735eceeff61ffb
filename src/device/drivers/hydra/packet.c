#include "src/device/drivers/bytes.h"
#include "src/device/drivers/hydra/hydra.h"
#include "src/device/unit_quat.h"

static bool read_controller(const uint8_t *b, struct ap_hydra_controller *c) {
    c->p_m = (struct ap_vec3){ap_i16le(b) / 1e3, -ap_i16le(b + 4) / 1e3, ap_i16le(b + 2) / 1e3};
    c->q = (struct ap_quat){ap_i16le(b + 8) / 32768.0, -ap_i16le(b + 10) / 32768.0,
                            -ap_i16le(b + 12) / 32768.0, ap_i16le(b + 6) / 32768.0};
    c->buttons = b[14];
    c->trigger = b[19] / 255.0;
    return ap_quat_make_unit(&c->q);
}

enum ap_report_verdict ap_hydra_parse(const uint8_t *bytes, size_t len,
                                      struct ap_hydra_controller controllers[2]) {
    if (len < AP_HYDRA_REPORT)
        return AP_REPORT_BAD;
    bool ok = read_controller(bytes + 8, &controllers[0]);
    return read_controller(bytes + 30, &controllers[1]) && ok ? AP_REPORT_OK : AP_REPORT_BAD;
}
