#include "src/track/tracker.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/track/anchored.h"
#include "src/track/billiards.h"
#include "src/track/motion.h"

// One device of `naive`: its own anchor.
struct device {
    char *name;
    struct ap_anchored anchored;
};

struct ap_tracker {
    struct ap_tracker_params params;
    bool has_head;
    int64_t dropped;
    struct ap_anchored head;   // anchor
    struct ap_perimeter c;     // billiards: the head's
    struct ap_billiards table; // billiards
    struct device *devices;    // naive
    size_t device_count, device_room, last_device;
};

static const char *const kind_names[] = {"naive", "anchor", "billiards"};

enum ap_status ap_tracker_kind_from_name(struct ap_error *err, const char *name,
                                         enum ap_tracker_kind *kind) {
    for (size_t i = 0; i < sizeof kind_names / sizeof *kind_names; i++)
        if (strcmp(name, kind_names[i]) == 0) {
            *kind = (enum ap_tracker_kind)i;
            return AP_OK;
        }
    return ap_fail(err, AP_USAGE, "unknown tracker '%s': use naive, anchor or billiards", name);
}

const char *ap_tracker_kind_name(enum ap_tracker_kind kind) {
    return kind_names[kind];
}

static enum ap_status check_params(struct ap_error *err, const struct ap_tracker_params *p) {
    if (p->kind < AP_TRACKER_NAIVE || p->kind > AP_TRACKER_BILLIARDS)
        return ap_fail(err, AP_USAGE, "unknown tracker %d", (int)p->kind);
    if (p->space.kappa < -1 || p->space.kappa > 1 || !isfinite(p->space.rho_m) ||
        !(p->space.rho_m > 0))
        return ap_fail(err, AP_USAGE, "a space of curvature sign %d and radius %g m does not exist",
                       p->space.kappa, p->space.rho_m);
    if (!isfinite(p->table_height_m))
        return ap_fail(err, AP_USAGE, "the table's height must be finite");
    if (p->kind != AP_TRACKER_BILLIARDS)
        return AP_OK;
    if (!isfinite(p->table_edge_m) || !(p->table_edge_m > 0))
        return ap_fail(err, AP_USAGE, "the table's edge must be finite and > 0, not %g m",
                       p->table_edge_m);
    if (p->space.kappa == 0)
        return AP_OK;
    double fits_m = ap_table_edge_of_radius(p->space);
    if (!(fabs(p->table_edge_m - fits_m) <= 1e-9 + 1e-15 * fits_m))
        return ap_fail(err, AP_USAGE,
                       "a table edge of %.12g m does not fit the radius %.12g m, whose table has "
                       "the edge %.12g m: leave one of the two out",
                       p->table_edge_m, p->space.rho_m, fits_m);
    return AP_OK;
}

enum ap_status ap_tracker_create(struct ap_error *err, const struct ap_tracker_params *params,
                                 struct ap_tracker **tracker) {
    enum ap_status status = check_params(err, params);
    if (status)
        return status;
    struct ap_tracker *t = calloc(1, sizeof *t);
    if (!t)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory for a tracker");
    t->params = *params;
    t->c = AP_PERIMETER_START;
    if (params->kind == AP_TRACKER_BILLIARDS)
        ap_billiards_init(params->space, params->table_edge_m, params->table_height_m, &t->table);
    *tracker = t;
    return AP_OK;
}

void ap_tracker_destroy(struct ap_tracker *tracker) {
    if (!tracker)
        return;
    for (size_t i = 0; i < tracker->device_count; i++)
        free(tracker->devices[i].name);
    free(tracker->devices);
    free(tracker);
}

// The place of a device in the list: an old one, or a new one at its end that does not count yet.
static enum ap_status find_device(struct ap_error *err, struct ap_tracker *t, const char *name,
                                  size_t *index) {
    // Logs alternate between few devices: look onward from the last one.
    for (size_t i = 1; i <= t->device_count; i++) {
        size_t at = (t->last_device + i) % t->device_count;
        if (strcmp(t->devices[at].name, name) == 0) {
            *index = at;
            return AP_OK;
        }
    }
    if (t->device_count == t->device_room) {
        size_t room = t->device_room ? 2 * t->device_room : 4;
        struct device *more = realloc(t->devices, room * sizeof *more);
        if (!more)
            return ap_fail(err, AP_ENVIRONMENT, "out of memory for the device '%.64s'", name);
        t->devices = more;
        t->device_room = room;
    }
    *index = t->device_count;
    return AP_OK;
}

static enum ap_status too_far(struct ap_error *err, const struct ap_tracker *t, const char *name) {
    return ap_fail(err, AP_INPUT,
                   "the virtual pose of '%.64s' is not a finite number: it is too far away for a "
                   "radius of %g m, or its pose in the room is not finite",
                   name, t->params.space.rho_m);
}

static struct ap_vec3 base_point(const struct ap_tracker *t) {
    return (struct ap_vec3){0, t->params.table_height_m, 0};
}

static enum ap_status feed_naive(struct ap_error *err, struct ap_tracker *t, const char *name,
                                 struct ap_pose pose, struct ap_iso *out) {
    size_t index = 0;
    enum ap_status status = find_device(err, t, name, &index);
    if (status)
        return status;
    bool is_new = index == t->device_count;
    struct ap_anchored next;
    if (is_new) {
        ap_anchored_init(&next, t->params.space, base_point(t), pose);
    } else {
        next = t->devices[index].anchored;
        ap_anchored_move(&next, pose);
    }
    if (!ap_iso_is_finite(&next.world_from_anchor.hi))
        return too_far(err, t, name);
    if (is_new) {
        char *copy = strdup(name);
        if (!copy)
            return ap_fail(err, AP_ENVIRONMENT, "out of memory for the device '%.64s'", name);
        t->devices[index].name = copy;
        t->device_count++;
    }
    t->devices[index].anchored = next;
    t->last_device = index;
    *out = next.world_from_anchor.hi;
    return AP_OK;
}

static enum ap_status feed_anchor(struct ap_error *err, struct ap_tracker *t, const char *name,
                                  bool is_head, struct ap_pose pose, struct ap_iso *out) {
    struct ap_iso place;
    struct ap_anchored next = t->head;
    if (!is_head) {
        place = ap_anchored_place(&t->head, pose);
    } else {
        if (t->has_head)
            ap_anchored_move(&next, pose);
        else
            ap_anchored_init(&next, t->params.space, base_point(t), pose);
        place = next.world_from_anchor.hi;
    }
    if (!ap_iso_is_finite(&place))
        return too_far(err, t, name);
    t->head = next;
    *out = place;
    return AP_OK;
}

// Straight above the centre a device has the coordinate it is compared with: the head its previous
// one, a hand the head's.
static enum ap_status feed_billiards(struct ap_error *err, struct ap_tracker *t, const char *name,
                                     bool is_head, struct ap_pose pose, struct ap_iso *out) {
    struct ap_perimeter c = t->c, at;
    if (ap_perimeter_of(pose.p.x, pose.p.z, &at))
        c = is_head && !t->has_head ? at : ap_perimeter_unwrap(t->c, at);
    struct ap_iso place = ap_billiards_place(&t->table, c, pose);
    if (!ap_iso_is_finite(&place))
        return too_far(err, t, name);
    if (is_head)
        t->c = c;
    *out = place;
    return AP_OK;
}

enum ap_status ap_tracker_feed(struct ap_error *err, struct ap_tracker *tracker, const char *device,
                               struct ap_pose table_from_device, bool *has_row,
                               struct ap_iso *world_from_device) {
    bool is_head = strcmp(device, "head") == 0;
    enum ap_tracker_kind kind = tracker->params.kind;
    if (kind != AP_TRACKER_NAIVE && !is_head && !tracker->has_head) {
        tracker->dropped++;
        *has_row = false;
        return AP_OK;
    }
    struct ap_iso out;
    enum ap_status status;
    if (kind == AP_TRACKER_NAIVE)
        status = feed_naive(err, tracker, device, table_from_device, &out);
    else if (kind == AP_TRACKER_ANCHOR)
        status = feed_anchor(err, tracker, device, is_head, table_from_device, &out);
    else
        status = feed_billiards(err, tracker, device, is_head, table_from_device, &out);
    if (status)
        return status;
    tracker->has_head |= is_head;
    *has_row = true;
    *world_from_device = out;
    return AP_OK;
}

int64_t ap_tracker_dropped(const struct ap_tracker *tracker) {
    return tracker->dropped;
}
