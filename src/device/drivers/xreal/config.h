#ifndef ANTIPODE_DEVICE_DRIVERS_XREAL_CONFIG_H
#define ANTIPODE_DEVICE_DRIVERS_XREAL_CONFIG_H

#include "src/device/fusion/imu.h"

// What the factory has written into the glasses, a JSON text of many kilobytes that comes in
// pieces. Of it "IMU", "device_1", "gyro_bias" and "accel_bias" are kept and nothing else; nothing
// is allocated, and a text that is no JSON finds nothing.

struct ap_xreal_config {
    unsigned depth;                      // of objects and arrays that are open
    unsigned matched;                    // of the path's objects
    bool in_string, is_escaped, is_next; // is_next: the object that begins next is the path's
    unsigned length;                     // of text; more than fits: it is too long for any of ours
    char text[24];                       // the string or number that is being read
    unsigned vector, index;              // 0 none, 1 rates, 2 forces; which of its three numbers
    unsigned found;                      // bit 1, bit 2
    double value[3][3];
};

// Zeroed at first.
void ap_xreal_config_read(struct ap_xreal_config *config, const char *text, size_t len);

// False where the two biases have not been there, or cannot be right. In the driver's axes; what is
// to be taken away from what is measured.
bool ap_xreal_config_bias(const struct ap_xreal_config *config, struct ap_imu_bias *bias);

#endif
