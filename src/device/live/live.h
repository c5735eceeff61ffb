#ifndef ANTIPODE_DEVICE_LIVE_LIVE_H
#define ANTIPODE_DEVICE_LIVE_LIVE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "src/device/hid/driver.h"
#include "src/device/live/io.h"
#include "src/device/fusion/predict.h"

// Devices that are plugged in, now and later: found, opened, switched on, read and kept alive by
// threads of their own (for each bus a reader and a keeper). Everybody else asks where a role is at
// a time, without waiting for a device or a lock. docs/devices.md.

struct ap_live;

enum {
    AP_LIVE_BUSES_MAX = 4,
    AP_LIVE_DEVICES_MAX = 128, // known at a time, unplugged ones too
    AP_LIVE_TRACKERS_MAX = 16, // of one device
    AP_LIVE_ROLES_MAX = 256,
    AP_LIVE_ROLE_NAME_MAX = 32,
};

enum ap_live_state {
    AP_LIVE_GONE,      // unplugged; comes back by itself
    AP_LIVE_NO_DRIVER, // there, but nothing here knows it
    AP_LIVE_DENIED,    // there, but we may not open it
    AP_LIVE_FAILED,    // there, but it does not open; tried again
    AP_LIVE_STARTING,  // open, being switched on
    AP_LIVE_RUNNING,   // open, its reports are read
};

const char *ap_live_state_name(enum ap_live_state state);

// What is known of a device: a copy, of no later use than to look at.
struct ap_live_device {
    struct ap_live_place place;
    const char *way; // its bus's name: "hidraw"
    enum ap_live_state state;
    const struct ap_driver *driver;                         // NULL: none
    char why[256];                                          // AP_LIVE_DENIED, _FAILED: a sentence
    int tracker_count;                                      // that have said something
    char role[AP_LIVE_TRACKERS_MAX][AP_LIVE_ROLE_NAME_MAX]; // "": none
    int degrees;             // of freedom that it measures: 3, 6; 0: not known yet
    double rate_hz;          // of reports, over the last second
    int64_t reports, bad;    // read; that cannot be right
    int64_t lost;            // by the device's own clock; −1: it has none
    int64_t newest_ns;       // the time of the newest report; 0: none yet
    int battery_percent;     // −1: not known
    int64_t unplugged_count; // how often it has gone while it was open
};

// A report as it came, and what its driver made of it. `device` is an index for ap_live_device_at.
struct ap_live_report {
    int device;
    int64_t arrival_ns; // whole microseconds, as in a recording
    const uint8_t *bytes;
    size_t len;
};

// One pose that went into a history. The time is the device's clock on the host's where it has one.
struct ap_live_pose_row {
    int device, tracker;
    char role[AP_LIVE_ROLE_NAME_MAX];
    int64_t t_ns, arrival_ns;
    struct ap_pose pose;
    bool
        restarted; // nothing leads here from the pose before: unplugged, recentred, a new reference
    const struct ap_driver_sample *sample; // rates, forces, buttons
};

// Somebody who listens, from the reader's threads: must return soon and must not call ap_live_….
// `started` comes before a device's first report, with all that was read of it (keeper's thread).
struct ap_live_listener {
    void *user;
    void (*started)(void *user, int device, const struct ap_live_place *place,
                    const struct ap_device_info *info, int64_t now_ns);
    void (*report)(void *user, const struct ap_live_report *report);
    void (*pose)(void *user, const struct ap_live_pose_row *row);
};

// What is known of a device by calibration: how it is mounted (body = tracker·mount; all zero: not
// turned) and what its sensors say at rest.
struct ap_live_mount {
    const char *serial; // of the device; "VVVV:PPPP", its ids, where it has none
    struct ap_quat tracker_from_body;
    struct ap_imu_bias bias;
};

struct ap_live_params {
    const struct ap_live_bus *buses; // taken over, also where opening fails; NULL: the machine's
    int bus_count;
    const char *const *ways; // the machine's buses: see ap_live_machine
    size_t way_count;
    // "ROLE=WHICH": which is a serial, a driver's name or a path, with ":N" behind it the N-th
    // tracker (from 1). ROLE: head, left, right, table (what it flies), or any other name.
    const char *const *assign;
    size_t assign_count;
    // "ROLE=WHICH", too: another device tells where the role is, its own how it is turned.
    const char *const *position;
    size_t position_count;
    bool no_automatic; // only what is assigned gets a role
    bool all;          // open what no driver knows, too (recording)
    const struct ap_live_mount *mounts;
    size_t mount_count;
    struct ap_live_listener listener; // all NULL: nobody
    struct ap_history_params history;
};

// What can be said of them before anything is opened; pure. AP_USAGE: an assignment that cannot be
// read, a role that is named twice, ways as ap_live_machine has them.
enum ap_status ap_live_check(struct ap_error *err, const struct ap_live_params *params);

// Everything is copied but the listener's user. Returns before devices are found. AP_USAGE as
// ap_live_check; AP_ENVIRONMENT.
enum ap_status ap_live_open(struct ap_error *err, const struct ap_live_params *params,
                            struct ap_live **live);
// What is plugged in now, without opening any of it: at most `max`, into places, drivers (NULL
// entries: none). The number.
int ap_live_list(const struct ap_live_bus *buses, int bus_count, struct ap_live_place *places,
                 const struct ap_driver **drivers, int max);

// The ways to this machine's devices, into buses[AP_LIVE_BUSES_MAX]: those of the names "hidraw",
// "libusb", "hidapi"; none named: hidraw, and libusb where it is. AP_USAGE for another name, one
// that is there twice, and hidapi beside hidraw, which stand on the same nodes; AP_ENVIRONMENT.
enum ap_status ap_live_machine(struct ap_error *err, const char *const *ways, size_t way_count,
                               struct ap_live_bus *buses, int *count);

// Ends the threads; no callback comes afterwards. Blocks for as long as a device keeps the keeper.
void ap_live_close(struct ap_live *live);

// The clock that all times here are on.
int64_t ap_live_now_ns(const struct ap_live *live);

// Waits until every device that is there has been looked at once and, where it starts, has started
// or until_ns is past; true in the first case. Not for a frame loop.
bool ap_live_settle(struct ap_live *live, int64_t until_ns);

// Devices keep their index. Any thread but a listener; takes a lock that readers hold for
// microseconds, so: not from a frame loop.
int ap_live_device_count(const struct ap_live *live);
void ap_live_device_at(const struct ap_live *live, int device, struct ap_live_device *out);

// --- for frame loops: no lock, no allocation, no system call

enum { AP_LIVE_HEAD, AP_LIVE_LEFT, AP_LIVE_RIGHT, AP_LIVE_TABLE }; // roles that are always there

// The role's number, or −1. Roles appear with the devices that take them; numbers stay.
int ap_live_role(const struct ap_live *live, const char *name);
int ap_live_role_count(const struct ap_live *live);
const char *ap_live_role_name(const struct ap_live *live, int role);

struct ap_live_answer {
    enum ap_pose_state state; // AP_POSE_NONE: nothing has this role
    struct ap_pose pose;      // in the room, STAGE axes
    struct ap_vec3 linear_m_s, angular_rad_s;
    int64_t age_ns; // asked time − the newest report's time
    float trigger;  // 0…1
    uint32_t buttons;
    bool select;
};

struct ap_live_answer ap_live_at(const struct ap_live *live, int role, int64_t t_ns);

// Where everybody looks now is ahead (−z): for what only knows how it is turned. What flies goes
// back to where it began. Takes effect with each tracker's next report. A tracker's own button
// does the same (docs/devices.md). Any thread.
void ap_live_recentre(struct ap_live *live);

#endif
