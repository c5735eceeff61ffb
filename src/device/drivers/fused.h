#ifndef ANTIPODE_DEVICE_DRIVERS_FUSED_H
#define ANTIPODE_DEVICE_DRIVERS_FUSED_H

#include "src/device/fusion/imu.h"
#include "src/device/hid/driver.h"

// For a fused driver's init: the fusion, and what was found of the device's biases. The parameters
// are a driver's own and right.
void ap_driver_begin_fused(struct ap_imu *imu, const struct ap_imu_params *params,
                           const struct ap_device_info *info);

// For drivers of devices that only measure rates and forces: one measurement into the fusion, and
// the orientation out of it as the next sample (axes x right, y up, z back). NULL where there is
// none: a repeated or impossible measurement, or no room.
struct ap_driver_sample *ap_driver_add_fused(struct ap_driver_samples *samples, struct ap_imu *imu,
                                             uint64_t raw_ticks, struct ap_vec3 gyr_rad_s,
                                             struct ap_vec3 acc_m_s2);

// The same for several measurements of one report, the oldest first: one sample, of the newest,
// which is a new beginning where any of them was.
struct ap_driver_sample *ap_driver_add_series(struct ap_driver_samples *samples, struct ap_imu *imu,
                                              const struct ap_imu_reading *readings, int count);

// What is pressed and how full the battery is (0…1), onto such a sample; AP_REPORT_IGNORED where it
// is NULL.
enum ap_report_verdict ap_driver_add_controls(struct ap_driver_sample *sample, uint32_t buttons,
                                              double trigger, double battery);

// zlib's CRC-32 of more bytes; begin with 0.
uint32_t ap_crc32(uint32_t crc, const uint8_t *bytes, size_t len);

#endif
