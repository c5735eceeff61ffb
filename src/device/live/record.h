#ifndef ANTIPODE_DEVICE_LIVE_RECORD_H
#define ANTIPODE_DEVICE_LIVE_RECORD_H

#include "src/device/live/live.h"

// Raw reports of live devices into a file of hid-recorder's text (feature reports as "# F:"
// comments, packed where the name ends in .gz or .zst), and the poses they became into a pose log
// beside it. Both appear, whole, when the recording is finished.

struct ap_recorder;

struct ap_record_counts {
    int devices;
    int64_t reports, poses;
    int64_t dropped; // for want of memory, or too late to be put in order
};

// "take.hid.gz" → "take.csv". AP_USAGE where it is a CSV already.
enum ap_status ap_record_csv_path(struct ap_error *err, const char *path, char *csv, size_t size);

// start_ns, on the clock of the devices to come, is one second in both files. AP_ENVIRONMENT where
// the files cannot be made.
enum ap_status ap_recorder_create(struct ap_error *err, const char *path, int64_t start_ns,
                                  struct ap_recorder **recorder);

// What the devices are to be opened with (ap_live_params.listener).
struct ap_live_listener ap_recorder_listener(struct ap_recorder *recorder);

// Now and then, from one thread: writes what is old enough to be in order. AP_ENVIRONMENT.
enum ap_status ap_recorder_write(struct ap_error *err, struct ap_recorder *recorder,
                                 int64_t now_ns);

struct ap_record_counts ap_recorder_counts(struct ap_recorder *recorder);

// After ap_live_close: writes what is left, and the files get their names.
enum ap_status ap_recorder_finish(struct ap_error *err, struct ap_recorder *recorder);

// Without finish nothing is left behind. NULL allowed.
void ap_recorder_destroy(struct ap_recorder *recorder);

#endif
