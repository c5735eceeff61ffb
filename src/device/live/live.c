#include "src/device/live/live.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/clock.h"
#include "src/base/log.h"
#include "src/device/live/set.h"

static const char *const state_names[] = {
    [AP_LIVE_GONE] = "unplugged", [AP_LIVE_NO_DRIVER] = "no driver", [AP_LIVE_DENIED] = "denied",
    [AP_LIVE_FAILED] = "failed",  [AP_LIVE_STARTING] = "starting",   [AP_LIVE_RUNNING] = "running",
};

const char *ap_live_state_name(enum ap_live_state state) {
    return state_names[state];
}

int live_slot_count(struct ap_live *live) {
    pthread_mutex_lock(&live->lock);
    int count = live->slot_count;
    pthread_mutex_unlock(&live->lock);
    return count;
}

// --- opening

static enum ap_status no_memory(struct ap_error *err) {
    return ap_fail(err, AP_ENVIRONMENT, "devices: out of memory");
}

static enum ap_status take_buses(struct ap_error *err, const struct ap_live_params *params,
                                 struct ap_live *live) {
    struct ap_live_bus buses[AP_LIVE_BUSES_MAX];
    int count = params->bus_count;
    enum ap_status st = AP_OK;
    if (params->buses)
        memcpy(buses, params->buses, (size_t)count * sizeof *buses);
    else
        st = ap_live_machine(err, params->ways, params->way_count, buses, &count);
    for (int i = 0; i < count && !st; i++)
        live->buses[live->bus_count++].way = buses[i];
    return st;
}

static enum ap_status copy_assignments(struct ap_error *err, const struct ap_live_params *params,
                                       struct ap_live *live) {
    size_t count = params->assign_count + params->position_count;
    if (count == 0)
        return AP_OK;
    live->assignments = calloc(count, sizeof *live->assignments);
    if (!live->assignments)
        return no_memory(err);
    for (size_t i = 0; i < count; i++) {
        bool position = i >= params->assign_count;
        const char *text =
            position ? params->position[i - params->assign_count] : params->assign[i];
        struct live_assignment *a = &live->assignments[i];
        enum ap_status st = live_assignment_read(err, text, position, a);
        if (!st && a->which[0] == '/')
            st = ap_live_hidraw_resolve(err, a->which);
        if (st)
            return st;
        live->assignment_count++;
    }
    return AP_OK;
}

static enum ap_status copy_mounts(struct ap_error *err, const struct ap_live_params *params,
                                  struct ap_live *live) {
    if (params->mount_count == 0)
        return AP_OK;
    live->mounts = calloc(params->mount_count, sizeof *live->mounts);
    if (!live->mounts)
        return no_memory(err);
    for (size_t i = 0; i < params->mount_count; i++) {
        live->mounts[i] = params->mounts[i];
        live->mounts[i].serial = strdup(params->mounts[i].serial);
        if (!live->mounts[i].serial)
            return no_memory(err);
        live->mount_count++;
    }
    return AP_OK;
}

static void add_roles(struct ap_live *live) {
    static const char *const names[] = {"head", "left", "right", "table"};
    for (int i = 0; i < 4; i++)
        memcpy(live->roles[i].name, names[i], strlen(names[i]) + 1);
    atomic_init(&live->role_count, 4);
}

static enum ap_status prepare(struct ap_error *err, const struct ap_live_params *params,
                              struct ap_live *live) {
    struct ap_history history;
    add_roles(live);
    live->no_automatic = params->no_automatic;
    live->all = params->all;
    live->listener = params->listener;
    live->history = params->history;
    enum ap_status st = take_buses(err, params, live);
    if (!st)
        st = ap_live_check(err, params);
    if (!st && !ap_history_init(&history, &params->history))
        st = ap_fail(err, AP_USAGE, "devices: a parameter of the prediction is out of range");
    if (!st)
        st = copy_assignments(err, params, live);
    return st ? st : copy_mounts(err, params, live);
}

static enum ap_status start_bus(struct ap_error *err, struct ap_live *live, struct live_bus *bus) {
    bus->live = live;
    bus->places = calloc(AP_LIVE_DEVICES_MAX, sizeof *bus->places);
    bus->batch = malloc(AP_LIVE_BATCH_BYTES);
    if (!bus->places || !bus->batch)
        return no_memory(err);
    bus->reader_runs = pthread_create(&bus->reader, NULL, live_read, bus) == 0;
    bus->keeper_runs = bus->reader_runs && pthread_create(&bus->keeper, NULL, live_keep, bus) == 0;
    return bus->keeper_runs ? AP_OK
                            : ap_fail(err, AP_ENVIRONMENT, "devices: no thread can be started");
}

enum ap_status ap_live_open(struct ap_error *err, const struct ap_live_params *params,
                            struct ap_live **out) {
    struct ap_live *live = calloc(1, sizeof *live);
    if (!live) {
        for (int i = 0; params->buses && i < params->bus_count; i++)
            params->buses[i].io->destroy(params->buses[i].bus);
        return no_memory(err);
    }
    pthread_mutex_init(&live->lock, NULL);
    for (int i = 0; i < AP_LIVE_BUSES_MAX; i++)
        pthread_mutex_init(&live->buses[i].lock, NULL);
    enum ap_status st = prepare(err, params, live);
    for (int i = 0; !st && i < live->bus_count; i++)
        st = start_bus(err, live, &live->buses[i]);
    if (st) {
        ap_live_close(live);
        return st;
    }
    *out = live;
    return AP_OK;
}

static void stop_bus(struct live_bus *bus) {
    const struct ap_live_io *io = bus->way.io;
    atomic_store(&bus->stop, true);
    io->rouse(bus->way.bus);
    io->wake(bus->way.bus);
    if (bus->keeper_runs)
        pthread_join(bus->keeper, NULL);
    if (bus->reader_runs)
        pthread_join(bus->reader, NULL);
}

void ap_live_close(struct ap_live *live) {
    if (!live)
        return;
    for (int i = 0; i < live->bus_count; i++)
        stop_bus(&live->buses[i]);
    for (int i = 0; i < live->slot_count; i++) {
        struct live_slot *slot = live->slots[i];
        if (slot->device)
            slot->bus->way.io->close(slot->bus->way.bus, slot->device);
        for (int t = 0; t < AP_LIVE_TRACKERS_MAX; t++)
            free(slot->tracker[t]);
        free(slot->feed);
        free(slot);
    }
    for (int i = 0; i < live->bus_count; i++) {
        live->buses[i].way.io->destroy(live->buses[i].way.bus);
        free(live->buses[i].places);
        free(live->buses[i].batch);
    }
    for (int i = 0; i < AP_LIVE_BUSES_MAX; i++)
        pthread_mutex_destroy(&live->buses[i].lock);
    pthread_mutex_destroy(&live->lock);
    for (size_t i = 0; i < live->mount_count; i++)
        free((char *)(uintptr_t)live->mounts[i].serial);
    free(live->mounts);
    free(live->assignments);
    free(live);
}

// --- looking

static const struct ap_driver *driver_of(const struct ap_live_place *p,
                                         struct ap_device_info *info) {
    return live_describe(NULL, p, info) ? NULL : ap_driver_find(info);
}

int ap_live_list(const struct ap_live_bus *buses, int bus_count, struct ap_live_place *places,
                 const struct ap_driver **drivers, int max) {
    struct ap_device_info *info = malloc(sizeof *info);
    int count = 0;
    for (int i = 0; i < bus_count && info; i++)
        count += buses[i].io->list(buses[i].bus, places + count, max - count);
    for (int i = 0; i < count; i++)
        drivers[i] = driver_of(&places[i], info);
    free(info);
    return count;
}

int64_t ap_live_now_ns(const struct ap_live *live) {
    return live->buses[0].way.io->now_ns(live->buses[0].way.bus);
}

static struct ap_live *writable(const struct ap_live *live) {
    return (struct ap_live *)(uintptr_t)live; // its locks are
}

int ap_live_device_count(const struct ap_live *live) {
    return live_slot_count(writable(live));
}

void ap_live_device_at(const struct ap_live *const_live, int device, struct ap_live_device *out) {
    struct ap_live *live = writable(const_live);
    struct live_slot *slot = live->slots[device];
    pthread_mutex_lock(&slot->bus->lock);
    *out = slot->about;
    out->state = live_slot_state(slot);
    pthread_mutex_lock(&live->lock);
    for (int i = 0; i < AP_LIVE_TRACKERS_MAX; i++) {
        struct live_tracker *t = slot->tracker[i];
        const char *role = t ? ap_live_role_name(live, atomic_load(&t->role)) : NULL;
        const char *name = role ? role : "";
        memcpy(out->role[i], name, strlen(name) + 1);
    }
    pthread_mutex_unlock(&live->lock);
    pthread_mutex_unlock(&slot->bus->lock);
}

static bool is_settled(struct ap_live *live) {
    for (int i = 0; i < live->bus_count; i++)
        if (atomic_load(&live->buses[i].scans) == 0)
            return false;
    for (int i = 0, count = live_slot_count(live); i < count; i++)
        if (live_slot_state(live->slots[i]) == AP_LIVE_STARTING)
            return false;
    return true;
}

bool ap_live_settle(struct ap_live *live, int64_t until_ns) {
    for (;;) {
        if (is_settled(live))
            return true;
        int64_t now_ns = ap_live_now_ns(live);
        if (now_ns >= until_ns)
            return false;
        ap_clock_sleep_until_ns(ap_clock_now_ns() + 5000000);
    }
}

// --- answering

static struct live_tracker *tracker_of(const struct ap_live *live, int role) {
    return role >= 0 && role < ap_live_role_count(live)
               ? atomic_load_explicit(&live->roles[role].tracker, memory_order_acquire)
               : NULL;
}

static bool is_known(enum ap_pose_state state) {
    return state != AP_POSE_NONE && state != AP_POSE_LOST;
}

// What flies the table moves everybody else the other way.
static void ride(const struct ap_live *live, int64_t t_ns, struct ap_live_answer *a) {
    const struct live_tracker *t = tracker_of(live, AP_LIVE_TABLE);
    if (!t)
        return;
    struct ap_history_answer table = ap_history_at(&t->history, t_ns);
    if (table.state == AP_POSE_NONE)
        return;
    table.pose.p = ap_vec3_sub(table.pose.p, ap_body_place(AP_BODY_OTHER, AP_QUAT_IDENTITY));
    struct ap_pose room_from_flown = ap_pose_inverse(table.pose);
    a->pose = ap_pose_mul(room_from_flown, a->pose);
    a->linear_m_s = ap_quat_rotate(room_from_flown.q, a->linear_m_s);
    a->angular_rad_s = ap_quat_rotate(room_from_flown.q, a->angular_rad_s);
}

struct ap_live_answer ap_live_at(const struct ap_live *live, int role, int64_t t_ns) {
    const struct live_tracker *t = tracker_of(live, role);
    if (!t)
        return (struct ap_live_answer){.state = AP_POSE_NONE, .pose = AP_POSE_IDENTITY};
    struct ap_history_answer h = ap_history_at(&t->history, t_ns);
    uint64_t held = atomic_load_explicit(&t->held, memory_order_acquire);
    uint32_t trigger = (uint32_t)(held >> 32);
    struct ap_live_answer a = {
        .state = h.state,
        .pose = h.pose,
        .linear_m_s = h.linear_m_s,
        .angular_rad_s = h.angular_rad_s,
        .age_ns = t_ns - atomic_load_explicit(&t->newest_ns, memory_order_acquire),
        .buttons = (uint32_t)held,
        .select = held & 1,
    };
    memcpy(&a.trigger, &trigger, sizeof a.trigger);
    const struct live_tracker *p =
        atomic_load_explicit(&live->roles[role].position, memory_order_acquire);
    if (p && is_known(a.state)) {
        struct ap_history_answer where = ap_history_at(&p->history, t_ns);
        if (is_known(where.state)) {
            a.pose.p = where.pose.p;
            a.linear_m_s = where.linear_m_s;
        }
    }
    if (role != AP_LIVE_TABLE && a.state != AP_POSE_NONE)
        ride(live, t_ns, &a);
    return a;
}

void ap_live_recentre(struct ap_live *live) {
    atomic_fetch_add_explicit(&live->recentre_count, 1, memory_order_acq_rel);
}
