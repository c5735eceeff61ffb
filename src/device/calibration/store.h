#ifndef ANTIPODE_DEVICE_CALIBRATION_STORE_H
#define ANTIPODE_DEVICE_CALIBRATION_STORE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "src/base/status.h"
#include "src/device/calibration/rest.h"
#include "src/device/calibration/table_corners.h"

// Calibrations as JSON in a folder: room.json, and devices/KEY.json for each device. Strict: an
// unknown key, another version or a number out of its range is an error, and nothing is lost by it.
// Files are written whole or not at all. Grammar: docs/calibration.md.

enum { AP_CALIBRATION_KEY_MAX = 64, AP_CALIBRATED_MAX = 128 };

// What a device is known by: its serial, or "VVVV:PPPP", its ids, where it has none.
void ap_device_key(char *key, size_t size, const char *serial, uint16_t vendor, uint16_t product);

struct ap_device_calibration {
    char key[AP_CALIBRATION_KEY_MAX];
    bool has_bias, has_mount;
    struct ap_rest_result rest;
    struct ap_quat tracker_from_body; // unit
};

// A device that has no file gives none, which is no error (*found false). AP_INPUT where the file
// is wrong.
enum ap_status ap_calibration_read(struct ap_error *err, const char *dir, const char *key,
                                   struct ap_device_calibration *calibration, bool *found);

// Replaces the device's file; makes the folders. AP_ENVIRONMENT; AP_USAGE for a key that is empty
// or too long.
enum ap_status ap_calibration_write(struct ap_error *err, const char *dir,
                                    const struct ap_device_calibration *calibration);

// All devices' files in the order of their keys. AP_INPUT where one is wrong, or where there are
// more than `max`.
enum ap_status ap_calibration_list(struct ap_error *err, const char *dir, int max,
                                   struct ap_device_calibration *all, int *count);

// *found false: there was none.
enum ap_status ap_calibration_forget(struct ap_error *err, const char *dir, const char *key,
                                     bool *found);

// The room's file, which may stand anywhere. rms_m tells how well the touches agreed.
struct ap_room_calibration {
    struct ap_table_place table;
    double rms_m;
};
enum ap_status ap_room_file_read(struct ap_error *err, const char *path,
                                 struct ap_room_calibration *room);
enum ap_status ap_room_file_write(struct ap_error *err, const char *path,
                                  const struct ap_room_calibration *room);

#endif
