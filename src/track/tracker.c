#include "src/track/tracker.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/track/billiards.h"
#include "src/track/motion.h"
#include "src/track/walker.h"

// One device of `naive`: its own anchor.
struct device {
    char *name;
    struct ap_anchored anchored;
};

struct ap_tracker {
    struct ap_tracker_params params;
    struct ap_pose table_from_room;
    bool has_lead; // what the others are placed by has been seen
    int64_t dropped;
    struct ap_walker walker; // anchor
    struct ap_pose hand[2];  // anchor "hands"
    bool has_hand[2];
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
    if (!isfinite(p->table_x_m + p->table_z_m + p->table_yaw_rad))
        return ap_fail(err, AP_USAGE, "the table's place must be finite");
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
    t->table_from_room = ap_pose_inverse((struct ap_pose){
        {params->table_x_m, 0, params->table_z_m},
        ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, params->table_yaw_rad)});
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

// Poses that are in the table's frame already stay bit for bit what they are.
static struct ap_pose on_table(const struct ap_tracker *t, struct ap_pose room_from_device) {
    const struct ap_tracker_params *p = &t->params;
    bool same = p->table_x_m == 0 && p->table_z_m == 0 && p->table_yaw_rad == 0;
    return same ? room_from_device : ap_pose_mul(t->table_from_room, room_from_device);
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

static bool is_hands(const struct ap_tracker *t) {
    return strcmp(t->params.anchor, "hands") == 0;
}

static bool is_hand(const char *name) {
    return strcmp(name, "left") == 0 || strcmp(name, "right") == 0;
}

bool ap_tracker_leads(const struct ap_tracker *t, const char *device) {
    if (t->params.kind == AP_TRACKER_NAIVE)
        return false;
    if (t->params.kind == AP_TRACKER_BILLIARDS || !t->params.anchor[0])
        return strcmp(device, "head") == 0;
    return is_hands(t) ? is_hand(device) : strcmp(device, t->params.anchor) == 0;
}

// The middle of two poses, facing half way between them.
static struct ap_pose middle_of(struct ap_pose a, struct ap_pose b) {
    double sign = a.q.x * b.q.x + a.q.y * b.q.y + a.q.z * b.q.z + a.q.w * b.q.w < 0 ? -1 : 1;
    struct ap_quat q = {a.q.x + sign * b.q.x, a.q.y + sign * b.q.y, a.q.z + sign * b.q.z,
                        a.q.w + sign * b.q.w};
    return (struct ap_pose){ap_vec3_scale(0.5, ap_vec3_add(a.p, b.p)), ap_quat_normalize(q)};
}

// The anchor moves to `pose`, or starts there.
static struct ap_walker walker_at(const struct ap_tracker *t, struct ap_pose pose) {
    struct ap_walker next = t->walker;
    if (t->has_lead)
        ap_walker_move(&next, pose);
    else
        ap_walker_init(&next, t->params.deep, t->params.space, base_point(t), pose);
    return next;
}

static enum ap_status feed_anchor(struct ap_error *err, struct ap_tracker *t, const char *name,
                                  bool leads, struct ap_pose pose, struct ap_iso *out) {
    if (!leads) {
        struct ap_iso place = ap_anchored_place(&t->walker.anchored, pose);
        if (!ap_iso_is_finite(&place))
            return too_far(err, t, name);
        *out = place;
        return AP_OK;
    }
    struct ap_walker next = walker_at(t, pose);
    if (!ap_iso_is_finite(&next.anchored.world_from_anchor.hi))
        return too_far(err, t, name);
    t->walker = next;
    *out = next.anchored.world_from_anchor.hi;
    return AP_OK;
}

// "hands": each sample of either moves the middle of both.
static enum ap_status feed_hands(struct ap_error *err, struct ap_tracker *t, const char *name,
                                 struct ap_pose pose, struct ap_iso *out) {
    int h = strcmp(name, "right") == 0;
    struct ap_walker next = walker_at(t, middle_of(pose, t->hand[!h]));
    struct ap_iso place = ap_anchored_place(&next.anchored, pose);
    if (!ap_iso_is_finite(&place))
        return too_far(err, t, name);
    t->walker = next;
    t->hand[h] = pose;
    *out = place;
    return AP_OK;
}

// False: the sample of a hand is only remembered, the other one has not been seen.
static bool both_hands(struct ap_tracker *t, const char *name, struct ap_pose pose) {
    int h = strcmp(name, "right") == 0;
    if (t->has_lead || t->has_hand[!h])
        return true;
    t->hand[h] = pose;
    t->has_hand[h] = true;
    return false;
}

// Straight above the centre a device has the coordinate it is compared with: the head its previous
// one, a hand the head's.
static struct ap_perimeter perimeter_of(const struct ap_tracker *t, bool leads,
                                        struct ap_pose pose) {
    struct ap_perimeter at;
    if (!ap_perimeter_of(pose.p.x, pose.p.z, &at))
        return t->c;
    return leads && !t->has_lead ? at : ap_perimeter_unwrap(t->c, at);
}

static enum ap_status feed_billiards(struct ap_error *err, struct ap_tracker *t, const char *name,
                                     bool leads, struct ap_pose pose, struct ap_iso *out) {
    struct ap_perimeter c = perimeter_of(t, leads, pose);
    struct ap_iso place = ap_billiards_place(&t->table, c, pose);
    if (!ap_iso_is_finite(&place))
        return too_far(err, t, name);
    if (leads)
        t->c = c;
    *out = place;
    return AP_OK;
}

enum ap_status ap_tracker_feed(struct ap_error *err, struct ap_tracker *tracker, const char *device,
                               struct ap_pose room_from_device, bool *has_row,
                               struct ap_iso *world_from_device) {
    struct ap_pose table_from_device = on_table(tracker, room_from_device);
    enum ap_tracker_kind kind = tracker->params.kind;
    bool leads = ap_tracker_leads(tracker, device);
    bool hands = leads && kind == AP_TRACKER_ANCHOR && is_hands(tracker);
    if ((kind != AP_TRACKER_NAIVE && !leads && !tracker->has_lead) ||
        (hands && !both_hands(tracker, device, table_from_device))) {
        tracker->dropped++;
        *has_row = false;
        return AP_OK;
    }
    struct ap_iso out;
    enum ap_status status;
    if (kind == AP_TRACKER_NAIVE)
        status = feed_naive(err, tracker, device, table_from_device, &out);
    else if (kind == AP_TRACKER_BILLIARDS)
        status = feed_billiards(err, tracker, device, leads, table_from_device, &out);
    else if (hands)
        status = feed_hands(err, tracker, device, table_from_device, &out);
    else
        status = feed_anchor(err, tracker, device, leads, table_from_device, &out);
    if (status)
        return status;
    tracker->has_lead |= leads;
    *has_row = true;
    *world_from_device = out;
    return AP_OK;
}

// What rests in the room is placed by this: NULL, by the table's edge.
static const struct ap_anchored *anchor_of_things(const struct ap_tracker *t) {
    if (t->params.kind == AP_TRACKER_ANCHOR)
        return t->has_lead ? &t->walker.anchored : NULL;
    for (size_t i = 0; i < t->device_count; i++)
        if (strcmp(t->devices[i].name, "head") == 0)
            return &t->devices[i].anchored;
    return NULL;
}

bool ap_tracker_place(const struct ap_tracker *tracker, struct ap_pose room_from_thing,
                      struct ap_iso *world_from_thing) {
    struct ap_pose table_from_thing = on_table(tracker, room_from_thing);
    const struct ap_anchored *anchored = anchor_of_things(tracker);
    struct ap_iso place;
    if (tracker->params.kind == AP_TRACKER_BILLIARDS && tracker->has_lead)
        place = ap_billiards_place(&tracker->table, perimeter_of(tracker, false, table_from_thing),
                                   table_from_thing);
    else if (anchored)
        place = ap_anchored_place(anchored, table_from_thing);
    else
        return false;
    if (!ap_iso_is_finite(&place))
        return false;
    *world_from_thing = place;
    return true;
}

enum ap_status ap_tracker_carry(struct ap_error *err, struct ap_tracker *tracker,
                                struct ap_pose room_from_grip, struct ap_pose motion) {
    struct ap_pose table_from_grip = on_table(tracker, room_from_grip);
    if (tracker->params.kind != AP_TRACKER_ANCHOR)
        return ap_fail(err, AP_USAGE,
                       "the tracker '%s' goes only where the visitor walks: take 'anchor' to fly, "
                       "turn or teleport",
                       ap_tracker_kind_name(tracker->params.kind));
    if (!tracker->has_lead)
        return ap_fail(err, AP_USAGE, "nobody to carry: the anchor has not been seen yet");
    struct ap_walker next = tracker->walker;
    ap_walker_carry(&next, table_from_grip, motion);
    if (!ap_iso_is_finite(&next.anchored.world_from_anchor.hi))
        return too_far(err, tracker, "the visitor");
    tracker->walker = next;
    return AP_OK;
}

enum ap_status ap_tracker_rebase(struct ap_error *err, struct ap_tracker *tracker,
                                 const struct ap_iso *high, const struct ap_iso *low,
                                 const struct ap_deep_iso *deep) {
    if (tracker->params.kind == AP_TRACKER_BILLIARDS)
        return ap_fail(err, AP_USAGE,
                       "the tracker 'billiards' holds the visitor to its table: take 'anchor' to "
                       "walk from cell to cell");
    ap_walker_rebase(&tracker->walker, high, low, deep);
    for (size_t i = 0; i < tracker->device_count; i++)
        ap_anchored_rebase(&tracker->devices[i].anchored, high, low);
    return AP_OK;
}

int64_t ap_tracker_dropped(const struct ap_tracker *tracker) {
    return tracker->dropped;
}
