#include <ctype.h>
#include <string.h>

#include "src/base/number.h"
#include "src/device/live/set.h"
#include "src/device/log/poselog_argument.h"

// A number behind the only colon is a tracker's. Serial numbers and paths have several colons.
static bool is_tracker_right(const char *which) {
    const char *colon = strchr(which, ':');
    int64_t number;
    if (colon == which)
        return false;
    if (!colon || strchr(colon + 1, ':') || !ap_parse_int64(colon + 1, strlen(colon + 1), &number))
        return true;
    return number >= 1 && number <= AP_LIVE_TRACKERS_MAX;
}

enum ap_status live_assignment_read(struct ap_error *err, const char *text, bool position,
                                    struct live_assignment *out) {
    size_t n = ap_role_length(text), len = strlen(text + n);
    if (n == 0 || n > sizeof out->role || len == 0 || len >= sizeof out->which)
        return ap_fail(err, AP_USAGE,
                       "'%s': expected ROLE=WHICH, as head=/dev/hidraw0, left=joycon or "
                       "right=SERIAL (see antipode devices)",
                       text);
    struct live_assignment a = {.position = position};
    memcpy(a.role, text, n - 1);
    memcpy(a.which, text + n, len + 1);
    if (!is_tracker_right(a.which))
        return ap_fail(err, AP_USAGE,
                       "'%s': expected a device, and its trackers are numbered from 1 to %d", text,
                       AP_LIVE_TRACKERS_MAX);
    *out = a;
    return AP_OK;
}

// Each can be read, and no role stands there twice.
static enum ap_status check_list(struct ap_error *err, const char *const *list, size_t count,
                                 bool position) {
    struct live_assignment a;
    for (size_t i = 0; i < count; i++) {
        enum ap_status st = live_assignment_read(err, list[i], position, &a);
        if (st)
            return st;
        for (size_t k = 0; k < i; k++)
            if (ap_role_length(list[k]) == strlen(a.role) + 1 &&
                memcmp(list[k], a.role, strlen(a.role)) == 0)
                return ap_fail(err, AP_USAGE,
                               "'%s' and '%s': a role has one device%s; name one of them", list[k],
                               list[i], position ? " that tells its place" : "");
    }
    return AP_OK;
}

enum ap_status ap_live_check(struct ap_error *err, const struct ap_live_params *params) {
    enum ap_status st = live_ways_check(err, params->ways, params->way_count);
    for (int position = 0; position < 2 && !st; position++) {
        const char *const *list = position ? params->position : params->assign;
        size_t count = position ? params->position_count : params->assign_count;
        st = check_list(err, list, count, position);
    }
    return st;
}

static bool is_named(const struct ap_live_device *d, const char *name, size_t len) {
    const char *const names[] = {d->place.serial, d->place.path, d->driver ? d->driver->name : ""};
    for (int i = 0; i < 3; i++)
        if (len > 0 && strlen(names[i]) == len && memcmp(names[i], name, len) == 0)
            return true;
    return false;
}

// A serial number may hold a colon itself, so the whole word is looked at first.
static bool is_meant(const struct live_assignment *a, const struct live_slot *slot, int tracker) {
    const char *colon = strrchr(a->which, ':');
    int64_t number;
    return is_named(&slot->about, a->which, strlen(a->which)) ||
           (colon && ap_parse_int64(colon + 1, strlen(colon + 1), &number) &&
            number == tracker + 1 && is_named(&slot->about, a->which, (size_t)(colon - a->which)));
}

int ap_live_role(const struct ap_live *live, const char *name) {
    int count = atomic_load_explicit(&live->role_count, memory_order_acquire);
    for (int i = 0; i < count; i++)
        if (strcmp(live->roles[i].name, name) == 0)
            return i;
    return -1;
}

int ap_live_role_count(const struct ap_live *live) {
    return atomic_load_explicit(&live->role_count, memory_order_acquire);
}

const char *ap_live_role_name(const struct ap_live *live, int role) {
    return role >= 0 && role < ap_live_role_count(live) ? live->roles[role].name : NULL;
}

// The role of that name, made where there is none; −1: no room.
static int make_role(struct ap_live *live, const char *name) {
    int role = ap_live_role(live, name);
    int count = ap_live_role_count(live);
    if (role >= 0 || count == AP_LIVE_ROLES_MAX)
        return role;
    size_t n = strlen(name);
    memcpy(live->roles[count].name, name, n + 1);
    atomic_store_explicit(&live->role_count, count + 1, memory_order_release);
    return count;
}

static bool is_free(struct ap_live *live, int role) {
    return !atomic_load_explicit(&live->roles[role].tracker, memory_order_relaxed);
}

// Whether somebody asked for this role by name: then it is not given away.
static bool is_reserved(const struct ap_live *live, int role) {
    for (size_t i = 0; i < live->assignment_count; i++)
        if (!live->assignments[i].position &&
            strcmp(live->assignments[i].role, live->roles[role].name) == 0)
            return true;
    return false;
}

// Room is left for the names that somebody has asked for.
static int tracker_role(struct ap_live *live) {
    char name[AP_LIVE_ROLE_NAME_MAX];
    int room = AP_LIVE_ROLES_MAX - (int)live->assignment_count;
    for (int n = 1; n <= AP_LIVE_ROLES_MAX; n++) {
        snprintf(name, sizeof name, "tracker%d", n);
        int role =
            ap_live_role_count(live) < room ? make_role(live, name) : ap_live_role(live, name);
        if (role >= 0 && is_free(live, role))
            return role;
    }
    return -1;
}

static void give(struct ap_live *live, struct live_tracker *t, int role) {
    if (role < 0)
        return;
    const char *name = live->roles[role].name;
    atomic_store(&t->role, role);
    atomic_store(&t->part, (int)ap_body_part_of(name, strlen(name)));
    atomic_store_explicit(&live->roles[role].tracker, t, memory_order_release);
}

// What flies is the head's only as long as nothing better is there; then it flies the table.
static void make_way(struct ap_live *live) {
    struct live_role *head = &live->roles[AP_LIVE_HEAD];
    struct live_tracker *t = atomic_load_explicit(&head->tracker, memory_order_relaxed);
    if (!t || !t->flies || !t->is_automatic)
        return;
    atomic_store_explicit(&head->tracker, NULL, memory_order_release);
    give(live, t, is_free(live, AP_LIVE_TABLE) ? AP_LIVE_TABLE : tracker_role(live));
}

// The first free one of head, left, right (left, right for what is held; head, table for what
// flies), then numbers.
static int automatic_role(struct live_slot *slot, const struct live_tracker *t) {
    struct ap_live *live = slot->live;
    const struct ap_driver *driver = slot->about.driver;
    const char *side = driver->side ? driver->side(&slot->feed->info) : NULL;
    int first = driver->hands_first ? AP_LIVE_LEFT : AP_LIVE_HEAD, last = AP_LIVE_RIGHT;
    if (side)
        first = last = ap_live_role(live, side);
    if (first == AP_LIVE_HEAD && !t->flies)
        make_way(live);
    for (int role = first; role <= (t->flies ? AP_LIVE_TABLE : last); role++) {
        bool fits = !t->flies || role == AP_LIVE_HEAD || role == AP_LIVE_TABLE;
        if (fits && is_free(live, role) && !is_reserved(live, role))
            return role;
    }
    return tracker_role(live);
}

// --- the same device by another way

static char next_of(const char **text) {
    while (**text == ':' || **text == '-')
        ++*text;
    return **text ? (char)tolower((unsigned char)*(*text)++) : '\0';
}

bool live_is_same_serial(const char *a, const char *b) {
    if (!*a)
        return false;
    for (;;) {
        char x = next_of(&a), y = next_of(&b);
        if (x != y)
            return false;
        if (!x)
            return true;
    }
}

static bool is_twin(const struct live_tracker *a, const struct live_tracker *b) {
    return a != b && a->index == b->index && a->driver == b->driver && a->vendor == b->vendor &&
           live_is_same_serial(a->serial, b->serial);
}

// Takes over what a tracker that has gone was there for; true where there is such a one, gone or
// not: a device that is plugged in twice has one role.
static bool take_over(struct ap_live *live, struct live_tracker *t) {
    bool has_twin = false;
    for (int i = 0, count = ap_live_role_count(live); i < count; i++) {
        struct live_role *r = &live->roles[i];
        struct live_tracker *old = atomic_load_explicit(&r->tracker, memory_order_relaxed);
        struct live_tracker *place = atomic_load_explicit(&r->position, memory_order_relaxed);
        if (place && is_twin(place, t)) {
            has_twin = true;
            if (live_slot_state(place->slot) == AP_LIVE_GONE)
                atomic_store_explicit(&r->position, t, memory_order_release);
        }
        if (!old || !is_twin(old, t))
            continue;
        has_twin = true;
        if (live_slot_state(old->slot) != AP_LIVE_GONE)
            continue;
        t->is_automatic = old->is_automatic;
        atomic_store(&old->role, -1);
        give(live, t, i);
    }
    return has_twin;
}

void live_inherit(struct ap_live *live, struct live_tracker *t) {
    unsigned count = atomic_load_explicit(&live->lose_count, memory_order_acquire);
    if (atomic_load(&t->role) >= 0 || t->lose_count == count)
        return;
    t->lose_count = count;
    pthread_mutex_lock(&live->lock);
    take_over(live, t);
    pthread_mutex_unlock(&live->lock);
}

void live_assign(struct live_slot *slot, int index) {
    struct ap_live *live = slot->live;
    struct live_tracker *t = slot->tracker[index];
    int role = -1;
    bool asked = false;
    pthread_mutex_lock(&live->lock);
    for (size_t i = 0; i < live->assignment_count; i++) {
        const struct live_assignment *a = &live->assignments[i];
        int r = is_meant(a, slot, index) ? make_role(live, a->role) : -1;
        if (r < 0)
            continue;
        if (a->position) {
            atomic_store_explicit(&live->roles[r].position, t, memory_order_release);
            asked = true;
        } else if (role < 0 && is_free(live, r)) {
            role = r;
        }
    }
    t->is_automatic = role < 0;
    t->lose_count = atomic_load_explicit(&live->lose_count, memory_order_acquire);
    if (role < 0 && take_over(live, t))
        asked = true;
    if (role < 0 && !asked && !live->no_automatic)
        role = automatic_role(slot, t);
    give(live, t, role);
    pthread_mutex_unlock(&live->lock);
}
