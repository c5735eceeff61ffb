#include "src/device/fusion/imu.h"

static const int64_t GAP_NS = 500000000;

bool ap_imu_init(struct ap_imu *imu, const struct ap_imu_params *params) {
    struct ap_imu fresh = {.params = *params};
    if (params->bits < 8 || params->bits > 64 || params->tick_ns_num < 1 ||
        params->tick_ns_den < 1 ||
        !ap_vqf_init(&fresh.vqf, &(struct ap_vqf_params){.period_s = params->period_s}))
        return false;
    *imu = fresh;
    return true;
}

// Nanoseconds of so many ticks; GAP_NS + 1 for anything over the gap.
static int64_t duration(const struct ap_imu *imu, uint64_t ticks, int64_t *remainder) {
    double ns = (double)ticks * imu->params.tick_ns_num / imu->params.tick_ns_den;
    if (ns > (double)GAP_NS)
        return GAP_NS + 1;
    int64_t den = imu->params.tick_ns_den;
    int64_t parts = (int64_t)(ticks * imu->params.tick_ns_num) + imu->remainder;
    *remainder = parts % den;
    return parts / den;
}

static enum ap_imu_event restart(struct ap_imu *imu, uint64_t raw, struct ap_vec3 gyr,
                                 struct ap_vec3 acc) {
    struct ap_vqf fresh = imu->vqf;
    ap_vqf_restart(&fresh);
    if (!ap_vqf_update(&fresh, gyr, acc, imu->params.period_s)) {
        imu->vqf.rejected++;
        return AP_IMU_REFUSED;
    }
    imu->vqf = fresh;
    imu->started = true;
    imu->raw = raw;
    imu->remainder = 0;
    return AP_IMU_RESET;
}

enum ap_imu_event ap_imu_add(struct ap_imu *imu, uint64_t raw, struct ap_vec3 gyr,
                             struct ap_vec3 acc) {
    int bits = imu->params.bits;
    gyr = ap_vec3_sub(gyr, imu->bias.gyr_rad_s);
    acc = ap_vec3_sub(acc, imu->bias.acc_m_s2);
    uint64_t mask = bits == 64 ? UINT64_MAX : (UINT64_C(1) << bits) - 1;
    raw &= mask;
    if (!imu->started)
        return restart(imu, raw, gyr, acc);
    uint64_t ticks = (raw - imu->raw) & mask;
    if (ticks == 0 || ((imu->raw - raw) & mask) <= imu->params.late_ticks)
        return AP_IMU_REPEATED;
    int64_t remainder = 0, ns = duration(imu, ticks, &remainder);
    if (ns > GAP_NS)
        return restart(imu, raw, gyr, acc);
    double dt_s = 1e-9 * (double)(ns > 0 ? ns : 1);
    if (!ap_vqf_update(&imu->vqf, gyr, acc, dt_s))
        return AP_IMU_REFUSED;
    imu->raw = raw;
    imu->remainder = remainder;
    imu->device_ns += ns;
    return AP_IMU_OK;
}
