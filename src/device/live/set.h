#ifndef ANTIPODE_DEVICE_LIVE_SET_H
#define ANTIPODE_DEVICE_LIVE_SET_H

#include <pthread.h>
#include <stdatomic.h>

#include "src/device/hid/body_model.h"
#include "src/device/live/feed.h"
#include "src/device/live/live.h"

// What the parts of the live layer share: live.c opens, closes and answers, keeper.c finds devices
// and switches them on, reader.c reads them, roles.c says who is who.
//
// Threads: each bus has a keeper and a reader. A bus's lock is held by its reader while it works
// through what has come (not while it waits), and by its keeper while it opens and closes; so a
// device is never closed under the reader. The live lock is for the tables of devices and roles and
// is taken after a bus's lock. What frame loops look at is atomic and is never taken back.

enum {
    AP_LIVE_BATCH = 256,            // reports of a device that are looked at together
    AP_LIVE_BATCH_BYTES = 64 << 10, // of all of them
};

struct live_tracker {
    struct ap_history history;
    atomic_llong newest_ns;
    atomic_ullong held;       // buttons, and the trigger's bits above them
    atomic_int role, part;    // −1: none; enum ap_body_part, by the role
    bool flies, is_automatic; // the live lock
    // Whose it is: stays, also while the device is away.
    const struct live_slot *slot;
    int index;
    const struct ap_driver *driver;
    uint16_t vendor;
    char serial[AP_LIVE_SERIAL_MAX];
    // The reader's own.
    bool is_turned;          // by turn and anchor; else poses are the driver's, bit for bit
    unsigned recentre_count; // of live->recentre_count, when it was recentred last
    unsigned lose_count;     // of live->lose_count, when it last asked for a role
    struct ap_quat turn;     // of what only knows how it is turned
    struct ap_pose anchor;   // of what flies
    uint32_t buttons;
};

struct live_slot {
    struct ap_live *live;
    struct live_bus *bus;
    int index;
    atomic_int state; // enum ap_live_state
    // The bus's lock.
    struct ap_live_device about; // but for state and roles
    bool has_mount;
    struct ap_quat mount;
    void *device; // NULL: not open
    struct ap_feed *feed;
    struct live_tracker *tracker[AP_LIVE_TRACKERS_MAX];
    bool has_asked; // the driver wants this sent
    struct ap_driver_step asked;
    int64_t rate_since_ns, rate_reports;
    // The keeper's own.
    bool seen;               // in the list that is being gone through
    bool is_reading;         // its feed has begun
    int64_t retry_ns;        // AP_LIVE_FAILED
    int step_count, step_at; // of what switches it on
    struct ap_driver_step steps[AP_DRIVER_STEPS_MAX];
    int64_t due_ns[AP_DRIVER_STEPS_MAX]; // INT64_MAX: done
};

struct live_bus {
    struct ap_live *live;
    struct ap_live_bus way;
    pthread_mutex_t lock;
    pthread_t keeper, reader;
    bool keeper_runs, reader_runs;
    atomic_bool stop;
    atomic_int scans; // finished, of what there is
    struct ap_live_place *places;
    uint8_t *batch; // AP_LIVE_BATCH_BYTES
};

struct live_role {
    char name[AP_LIVE_ROLE_NAME_MAX];
    _Atomic(struct live_tracker *) tracker, position; // NULL: none
};

// "ROLE=WHICH[:N]"
struct live_assignment {
    char role[AP_LIVE_ROLE_NAME_MAX];
    char which[AP_LIVE_PATH_MAX];
    bool position;
};

struct ap_live {
    pthread_mutex_t lock;
    struct live_bus buses[AP_LIVE_BUSES_MAX];
    int bus_count;
    struct live_slot *slots[AP_LIVE_DEVICES_MAX];
    int slot_count;
    struct live_role roles[AP_LIVE_ROLES_MAX];
    atomic_int role_count;
    atomic_uint recentre_count;
    atomic_uint lose_count; // devices that have gone
    struct live_assignment *assignments;
    size_t assignment_count;
    struct ap_live_mount *mounts; // serials are copies
    size_t mount_count;
    bool no_automatic, all, is_full;
    struct ap_live_listener listener;
    struct ap_history_params history;
};

// keeper.c, reader.c: the threads; `bus` is a struct live_bus.
void *live_keep(void *bus);
void *live_read(void *bus);

// keeper.c: what is known of a device before it is opened. AP_INPUT for its descriptor.
enum ap_status live_describe(struct ap_error *err, const struct ap_live_place *place,
                             struct ap_device_info *info);

// keeper.c: a look at what there is, and what is due; when something is due next.
int64_t live_keep_once(struct live_bus *bus);

static inline enum ap_live_state live_slot_state(const struct live_slot *slot) {
    return (enum ap_live_state)atomic_load_explicit(&slot->state, memory_order_acquire);
}

// How many slots there are; they and their buses stay.
int live_slot_count(struct ap_live *live);

// reader.c: the device is gone, its trackers are lost from now on. The bus's lock is held.
void live_slot_lose(struct live_slot *slot, int64_t now_ns);

// reader.c: works through what a device has to read. The bus's lock is held.
void live_slot_drain(struct live_slot *slot);

// ways.c: whether there are ways of these names. AP_USAGE.
enum ap_status live_ways_check(struct ap_error *err, const char *const *ways, size_t count);

// roles.c: reads "ROLE=WHICH[:N]". AP_USAGE.
enum ap_status live_assignment_read(struct ap_error *err, const char *text, bool position,
                                    struct live_assignment *out);
// roles.c: a tracker has said something for the first time. The bus's lock is held.
void live_assign(struct live_slot *slot, int tracker);
// roles.c: a tracker without a role: the one that it had on another way, if its device has gone
// there since it asked last. The bus's lock is held.
void live_inherit(struct ap_live *live, struct live_tracker *tracker);

// roles.c: whether two serial numbers are one: a Bluetooth address is written with and without
// colons, in capitals and not, as the driver of each way likes. Nobody's is nobody else's.
bool live_is_same_serial(const char *a, const char *b);

#endif
