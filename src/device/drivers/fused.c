#include "src/device/drivers/fused.h"

void ap_driver_begin_fused(struct ap_imu *imu, const struct ap_imu_params *params,
                           const struct ap_device_info *info) {
    ap_imu_init(imu, params);
    imu->bias = info->bias;
}

struct ap_driver_sample *ap_driver_add_fused(struct ap_driver_samples *samples, struct ap_imu *imu,
                                             uint64_t raw_ticks, struct ap_vec3 gyr_rad_s,
                                             struct ap_vec3 acc_m_s2) {
    enum ap_imu_event event = ap_imu_add(imu, raw_ticks, gyr_rad_s, acc_m_s2);
    if (event != AP_IMU_OK && event != AP_IMU_RESET)
        return NULL;
    struct ap_driver_sample *sample = ap_driver_add_sample(samples);
    if (!sample)
        return NULL;
    sample->kind = AP_SAMPLE_ORIENTATION;
    sample->pose.q = ap_vqf_orientation(&imu->vqf);
    sample->has_rate = true;
    sample->angular_velocity_rad_s =
        ap_vqf_rate(&imu->vqf, ap_vec3_sub(gyr_rad_s, imu->bias.gyr_rad_s));
    sample->has_imu = true;
    sample->gyro_rad_s = gyr_rad_s;
    sample->acceleration_m_s2 = acc_m_s2;
    sample->has_device_time = true;
    sample->device_ns = imu->device_ns;
    sample->reset = event == AP_IMU_RESET;
    return sample;
}

struct ap_driver_sample *ap_driver_add_series(struct ap_driver_samples *samples, struct ap_imu *imu,
                                              const struct ap_imu_reading *readings, int count) {
    struct ap_driver_sample *newest = NULL;
    bool reset = false;
    for (int i = 0; i < count; i++) {
        const struct ap_imu_reading *r = &readings[i];
        struct ap_driver_sample *s =
            ap_driver_add_fused(samples, imu, r->ticks, r->gyr_rad_s, r->acc_m_s2);
        reset |= s && s->reset;
        if (s && newest) {
            *newest = *s;
            samples->count--;
        } else if (s) {
            newest = s;
        }
    }
    if (newest)
        newest->reset = reset;
    return newest;
}

enum ap_report_verdict ap_driver_add_controls(struct ap_driver_sample *sample, uint32_t buttons,
                                              double trigger, double battery) {
    if (!sample)
        return AP_REPORT_IGNORED;
    sample->buttons = buttons;
    sample->trigger = (float)trigger;
    sample->has_battery = true;
    sample->battery = (float)battery;
    return AP_REPORT_OK;
}

uint32_t ap_crc32(uint32_t crc, const uint8_t *bytes, size_t len) {
    crc = ~crc;
    for (size_t i = 0; i < len; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++)
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320 : 0);
    }
    return ~crc;
}
