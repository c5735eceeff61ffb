#include "src/track/walker.h"

// False leaves the walker as she was.
static bool take(struct ap_walker *w, struct ap_deep_iso deep) {
    deep = ap_deep_renew(&deep);
    if (!ap_deep_fits(&deep))
        return false;
    w->deep = deep;
    struct ap_wide_iso *m = &w->anchored.world_from_anchor;
    ap_deep_round(&deep, &m->hi, &m->lo);
    return true;
}

static bool advance(struct ap_walker *w, struct ap_pose from, struct ap_pose to) {
    struct ap_deep_iso step;
    return ap_deep_between(w->anchored.space.rho_m, from, to, &step) &&
           take(w, ap_deep_mul(&w->deep, &step));
}

void ap_walker_init(struct ap_walker *w, bool deep, struct ap_space space,
                    struct ap_vec3 room_origin, struct ap_pose room_from_anchor) {
    const struct ap_pose origin = {room_origin, {0, 0, 0, 1}};
    ap_anchored_init(&w->anchored, space, room_origin, room_from_anchor);
    w->deep = ap_deep_identity();
    w->is_deep = deep && space.kappa < 0 && advance(w, origin, room_from_anchor);
}

void ap_walker_move(struct ap_walker *w, struct ap_pose room_from_anchor) {
    w->is_deep = w->is_deep && advance(w, w->anchored.room_from_anchor, room_from_anchor);
    if (w->is_deep)
        w->anchored.room_from_anchor = room_from_anchor;
    else
        ap_anchored_move(&w->anchored, room_from_anchor);
}

void ap_walker_carry(struct ap_walker *w, struct ap_pose room_from_grip, struct ap_pose motion) {
    double rho_m = w->anchored.space.rho_m;
    struct ap_deep_iso grip, way;
    w->is_deep = w->is_deep &&
                 ap_deep_between(rho_m, w->anchored.room_from_anchor, room_from_grip, &grip) &&
                 ap_deep_between(rho_m, AP_POSE_IDENTITY, motion, &way);
    if (w->is_deep) {
        struct ap_deep_iso back = ap_deep_inverse(&grip), all = ap_deep_mul(&w->deep, &grip);
        w->is_deep = ap_deep_fits(&all);
        all = ap_deep_mul(&all, &way);
        w->is_deep = w->is_deep && ap_deep_fits(&all) && take(w, ap_deep_mul(&all, &back));
    }
    if (!w->is_deep)
        ap_anchored_carry(&w->anchored, room_from_grip, motion);
}

void ap_walker_rebase(struct ap_walker *w, const struct ap_iso *high, const struct ap_iso *low,
                      const struct ap_deep_iso *deep) {
    w->is_deep = w->is_deep && deep && take(w, ap_deep_mul(deep, &w->deep));
    if (!w->is_deep)
        ap_anchored_rebase(&w->anchored, high, low);
}
