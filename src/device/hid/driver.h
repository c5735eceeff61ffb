#ifndef ANTIPODE_DEVICE_HID_DRIVER_H
#define ANTIPODE_DEVICE_HID_DRIVER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "src/device/fusion/imu.h"
#include "src/device/hid/descriptor.h"
#include "src/geom/pose.h"

// Drivers of trackers. A driver is a table of pure functions over bytes: it opens nothing, sends
// nothing and knows no clock, so that a recording and a device drive the same code. How to add one:
// docs/new-driver.md.

enum {
    AP_DRIVER_STATE_MAX = 2048, // bytes of a driver's state
    AP_DRIVER_SAMPLES_MAX = 16, // of one report
    AP_DRIVER_STEPS_MAX = 8,
    AP_DRIVER_STEP_BYTES = 96,
    AP_DEVICE_FEATURES_MAX = 16,
    AP_DEVICE_FEATURE_BYTES = 256,
};

// A feature report as it was read from the device: the id's byte first (0 where not numbered).
struct ap_feature_report {
    size_t len;
    uint8_t bytes[AP_DEVICE_FEATURE_BYTES];
};

// What is known of a device before its first report.
struct ap_device_info {
    uint16_t bus, vendor, product; // as on hid-recorder's I: line
    char name[128];
    bool interface_known; // of a USB device with several
    int interface_number;
    struct ap_hid_descriptor descriptor; // empty where unknown
    int feature_count;
    struct ap_feature_report features[AP_DEVICE_FEATURES_MAX];
    struct ap_imu_bias bias; // as calibrated; zero where nothing is known
};

// The newest feature report of that id, or NULL.
const struct ap_feature_report *ap_device_feature(const struct ap_device_info *info, uint8_t id);

// What a sample says of where its tracker is.
enum ap_sample_kind {
    AP_SAMPLE_ORIENTATION, // pose.q; where it stands is a model's to say (body_model.h)
    AP_SAMPLE_FLIGHT,      // pose, counted from wherever the device is put at first
    AP_SAMPLE_POSE,        // pose in the room
    AP_SAMPLE_IMU,         // gyro and acceleration, to be fused
};

// Axes are OpenXR's: x right, y up, z back, of the room and of the tracker.
struct ap_driver_sample {
    enum ap_sample_kind kind;
    int tracker; // 0, 1, …: in the order in which the device introduces them
    struct ap_pose pose;
    bool has_rate; // angular_velocity_rad_s is known, in the tracker's axes
    struct ap_vec3 angular_velocity_rad_s;
    struct ap_vec3 acceleration_m_s2; // AP_SAMPLE_IMU, or has_imu: as measured
    bool has_imu;                     // what was fused is known, too
    struct ap_vec3 gyro_rad_s;        // as measured, no bias taken away
    bool has_device_time;
    int64_t device_ns; // the device's own clock, unwrapped
    bool reset;        // the reference has changed: no interpolation from the sample before
    uint32_t buttons;  // bit 0 is the one that selects
    float trigger;     // 0…1
    bool has_battery;  // battery is known
    float battery;     // 0 empty … 1 full
    bool has_reset_count;
    uint32_t reset_count; // how often the device says that it has begun a new reference
};

struct ap_driver_samples {
    int count;
    struct ap_driver_sample at[AP_DRIVER_SAMPLES_MAX];
    char why[128]; // AP_REPORT_BAD: what was expected
};

enum ap_report_verdict {
    AP_REPORT_OK,      // samples (perhaps none: a report that only introduces a tracker)
    AP_REPORT_IGNORED, // not one that says anything about a pose
    AP_REPORT_BAD,     // one that cannot be right: too short, a quaternion of no length
};

// What to send to a device so that it begins to report, as data.
enum ap_step_kind { AP_STEP_SET_FEATURE, AP_STEP_GET_FEATURE, AP_STEP_OUTPUT };

struct ap_driver_step {
    enum ap_step_kind kind;
    size_t len; // of bytes, the id's byte first; AP_STEP_GET_FEATURE: of the answer
    uint8_t bytes[AP_DRIVER_STEP_BYTES];
    uint32_t wait_ms;   // afterwards
    uint32_t repeat_ms; // not 0: again and again (keep-alive)
    bool if_silent;     // again only where no interface of the device has given a pose for so long
};

// One product, in a row of a table of ids.
#define AP_PRODUCT(vendor_id, product_id)                                                          \
    .vendor = (vendor_id), .first_product = (product_id), .last_product = (product_id)

// A model, or a few that are the same to their driver.
struct ap_driver_ids {
    uint16_t bus; // 0: any
    uint16_t vendor, first_product, last_product;
    uint32_t not_interfaces; // bits: of a device with several, those that are not for this driver
    const void *model;       // the driver's own: what is particular about it
};

struct ap_driver {
    const char *name;   // one word, for the command line
    const char *title;  // for people
    bool hands_first;   // its trackers are a left and a right hand, not a head and two hands
    size_t state_bytes; // at most AP_DRIVER_STATE_MAX, zeroed before init
    bool (*match)(const struct ap_device_info *info);             // NULL: by ids
    void (*init)(void *state, const struct ap_device_info *info); // may be NULL
    // The number of steps; may be NULL: the device reports by itself.
    int (*start)(const struct ap_device_info *info,
                 struct ap_driver_step steps[AP_DRIVER_STEPS_MAX]);
    // After a report: what to send because of it, as data (the next question); its wait and repeat
    // do not count. False: nothing. May be NULL.
    bool (*ask)(void *state, struct ap_driver_step *step);
    // One input report as hidraw gives it, received at t_ns (never before the report before it).
    // samples->count is 0 on entry.
    enum ap_report_verdict (*parse)(void *state, const struct ap_device_info *info, int64_t t_ns,
                                    const uint8_t *bytes, size_t len,
                                    struct ap_driver_samples *samples);
    // What a device that is silent at rest would say at t_ns, not before its newest report; changes
    // nothing. NULL: the device goes on reporting.
    void (*idle)(const void *state, const struct ap_device_info *info, int64_t t_ns,
                 struct ap_driver_samples *samples);
    // "left" or "right" where the device is made for that hand, else NULL. May be NULL.
    const char *(*side)(const struct ap_device_info *info);
    uint32_t recentre; // buttons that make everybody's yaw anew
    int degrees;       // of freedom of what it measures: 3 or 6
    // Whom it may be, for udev's rules and for a bus that cannot read descriptors before it opens:
    // ends with a vendor of 0. A driver that asks the descriptor names the vendors it is known of.
    const struct ap_driver_ids *ids;
};

// The first driver of the table that knows the device, or NULL.
const struct ap_driver *ap_driver_find(const struct ap_device_info *info);

int ap_driver_count(void);
const struct ap_driver *ap_driver_at(int index);

// What the driver's ids say of the device; NULL: they do not name it, or not this interface of it.
const struct ap_driver_ids *ap_driver_ids_of(const struct ap_driver *driver,
                                             const struct ap_device_info *info);

// The same, and no more than whether.
bool ap_driver_names(const struct ap_driver *driver, const struct ap_device_info *info);

// For drivers: AP_REPORT_BAD, with the sentence in samples->why ("expected …").
enum ap_report_verdict ap_report_bad(struct ap_driver_samples *samples, const char *format, ...)
    AP_PRINTF(2, 3);

// For drivers: the next sample, cleared but for an identity pose, or NULL where there is no room.
struct ap_driver_sample *ap_driver_add_sample(struct ap_driver_samples *samples);

#endif
