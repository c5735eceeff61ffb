#include "src/app/play/body.h"

#include <math.h>

#include "src/base/log.h"

enum { DOTS = 24, RAILS = AP_CHAPERONE_MAX_LINES };

static const double rail_m = 0.25;
static const char *const hand_names[2] = {"left", "right"};

enum ap_status ap_body_init(struct ap_error *err, struct ap_room *room, struct ap_body *out) {
    struct ap_body body = {.room = room};
    const struct ap_part dot = {.kind = AP_PART_BALL,
                                .carrier_from_part = AP_ISO_IDENTITY,
                                .radius_m = 0.006,
                                .color_srgb = {0.55, 0.9, 1},
                                .object = -1};
    const struct ap_part rail = {.kind = AP_PART_STICK,
                                 .carrier_from_part = AP_ISO_IDENTITY,
                                 .radius_m = 0.002,
                                 .radius2_m = 0.002,
                                 .length_m = rail_m,
                                 .object = -1};
    enum ap_status st = ap_scene_add(err, room->scene, &dot, DOTS, &body.first_dot);
    if (!st)
        st = ap_scene_add(err, room->scene, &rail, RAILS, &body.first_rail);
    ap_travel_init(&body.travel, NULL);
    if (!st)
        *out = body;
    return st;
}

void ap_body_settle(struct ap_body *body, const struct ap_play_settings *settings, double width_m,
                    double depth_m) {
    double turn_deg = ap_play_number(settings, AP_PLAY_TURN);
    bool smooth = isnan(turn_deg);
    const struct ap_travel_params params = {
        .speed_mps = ap_play_number(settings, AP_PLAY_SPEED),
        .turn_rad = (smooth ? 60 : turn_deg) * 0.017453292519943295,
        .turn_smoothly = smooth,
        .no_vignette = ap_play_is(settings, AP_PLAY_VIGNETTE, "off")};
    ap_travel_init(&body->travel, &params);
    body->chaperone = (struct ap_chaperone){.width_m = width_m, .depth_m = depth_m};
    body->fence = ap_play_is(settings, AP_PLAY_FENCE, "on");
}

// A stick pushed away from the body with the right hand points; the left one flies.
static struct ap_travel_input ask(const struct ap_xr_frame *frame) {
    const struct ap_xr_hand *left = &frame->hand[0], *right = &frame->hand[1];
    bool point = (double)right->stick_y > 0.6 && right->aim.valid;
    return (struct ap_travel_input){.t_ns = frame->time_ns,
                                    .right = (double)left->stick_x,
                                    .forward = (double)left->stick_y,
                                    .turn = point ? 0 : (double)right->stick_x,
                                    .point = point,
                                    .cancel = right->squeeze > 0.5f,
                                    .room_from_head = frame->head.pose,
                                    .room_from_aim = right->aim.pose};
}

static void show_dots(struct ap_body *body, const struct ap_travel_output *out,
                      struct ap_pose room_from_aim) {
    struct ap_scene *scene = body->room->scene;
    struct ap_iso aim;
    bool shown = out->pointing && ap_tracker_place(body->room->tracker, room_from_aim, &aim);
    for (int i = 0; i < DOTS; i++) {
        struct ap_part *part = &scene->parts[body->first_dot + (size_t)i];
        part->hidden = !shown;
        if (!shown)
            continue;
        struct ap_vec3 way = {0, 0, -out->reach_m * (i + 1) / DOTS};
        part->carrier_from_part = ap_iso_mul(aim, ap_iso_translate(scene->space, way));
        part->radius_m = i == DOTS - 1 ? 0.03 : 0.006;
    }
}

// The turn that takes −z to the direction of a line along one of the axes.
static struct ap_quat along(struct ap_vec3 d) {
    struct ap_vec3 from = {0, 0, -1}, axis = ap_vec3_cross(from, d);
    if (ap_vec3_length(axis) < 1e-6)
        return AP_QUAT_IDENTITY; // forward or back is the same stick
    return ap_quat_from_axis_angle(axis, acos(fmin(fmax(ap_vec3_dot(from, d), -1), 1)));
}

static void show_fence(struct ap_body *body, const struct ap_xr_frame *frame) {
    static const double color[3] = {0.2, 0.75, 1};
    struct ap_scene *scene = body->room->scene;
    struct ap_chaperone_line lines[AP_CHAPERONE_MAX_LINES];
    struct ap_vec3 points[3];
    size_t count = 0, line_count = 0;
    if (frame->head.tracked)
        points[count++] = frame->head.pose.p;
    for (int h = 0; h < 2; h++)
        if (frame->hand[h].grip.tracked)
            points[count++] = frame->hand[h].grip.pose.p;
    if (body->fence)
        line_count = ap_chaperone_fence(&body->chaperone, points, count, lines);
    for (size_t i = 0; i < RAILS; i++) {
        struct ap_part *part = &scene->parts[body->first_rail + i];
        part->hidden = true;
        if (i >= line_count)
            continue;
        struct ap_vec3 way = ap_vec3_sub(lines[i].b, lines[i].a);
        struct ap_pose at = {ap_vec3_scale(0.5, ap_vec3_add(lines[i].a, lines[i].b)),
                             along(ap_vec3_normalize(way))};
        part->hidden = !ap_tracker_place(body->room->tracker, at, &part->carrier_from_part);
        for (int c = 0; c < 3; c++)
            part->color_srgb[c] = scene->background_srgb[c] +
                                  lines[i].strength * (color[c] - scene->background_srgb[c]);
    }
}

// A pose that no tracker can mean (NaN, or farther than can be told) is a device that is lost: the
// others go on, and so does the game.
static void place(enum ap_status *st, struct ap_error *err, struct ap_body *body,
                  const char *device, const struct ap_xr_located *located, bool *has_row,
                  struct ap_iso *iso) {
    *has_row = false;
    if (*st || !located->valid)
        return;
    struct ap_error why;
    enum ap_status fed =
        ap_tracker_feed(&why, body->room->tracker, device, located->pose, has_row, iso);
    if (fed == AP_INPUT) {
        *has_row = false;
        if (body->refused++ == 0)
            ap_log(AP_LOG_WARNING, "%s counts as lost: %s", device, why.text);
    } else if (fed) {
        *st = ap_fail(err, fed, "%s", why.text);
    }
}

// What the others are placed by comes first.
static enum ap_status place_all(struct ap_error *err, struct ap_body *body,
                                const struct ap_xr_frame *frame, struct ap_frame_input *input) {
    const struct ap_tracker *tracker = body->room->tracker;
    enum ap_status st = AP_OK;
    for (int turn = 0; turn < 2; turn++) {
        bool head = false;
        if (ap_tracker_leads(tracker, "head") == !turn)
            place(&st, err, body, "head", &frame->head, &head, &input->viewer.world_from_nose);
        body->head_known |= head;
        for (int h = 0; h < 2; h++)
            if (ap_tracker_leads(tracker, hand_names[h]) == !turn)
                place(&st, err, body, hand_names[h], &frame->hand[h].grip, &input->hand_tracked[h],
                      &input->world_from_hand[h]);
    }
    return st ? st
              : ap_room_follow(err, body->room, &input->viewer.world_from_nose,
                               input->world_from_hand);
}

// In a world of cells whoever comes in stands in the middle of one: heads are as high over the
// room's origin as walls may be.
static enum ap_status begin(struct ap_error *err, struct ap_body *body,
                            const struct ap_xr_frame *frame, struct ap_frame_input *input) {
    const struct ap_scene *scene = body->room->scene;
    bool may_go = body->room->tracker_params.kind == AP_TRACKER_ANCHOR;
    if (body->has_begun || !body->head_known || !scene->honeycomb || !may_go)
        return AP_OK;
    body->has_begun = true;
    const struct ap_vec4 middle = {0, 0, 0, scene->space.rho_m};
    struct ap_iso head_from_world = ap_iso_inverse(scene->space, input->viewer.world_from_nose);
    struct ap_vec3 way = ap_log_unchecked(scene->space, ap_iso_apply(&head_from_world, middle), 0);
    struct ap_error why;
    if (ap_tracker_carry(&why, body->room->tracker, frame->head.pose,
                         (struct ap_pose){way, {0, 0, 0, 1}}))
        return AP_OK; // where no tracker can go she begins where she is
    return place_all(err, body, frame, input);
}

enum ap_status ap_body_step(struct ap_error *err, struct ap_body *body,
                            const struct ap_xr_frame *frame, bool still,
                            struct ap_frame_input *input) {
    struct ap_travel_output out = {0};
    bool may_go = body->room->tracker_params.kind == AP_TRACKER_ANCHOR && body->head_known;
    if (may_go && !still) {
        const struct ap_travel_input asked = ask(frame);
        out = ap_travel_step(&body->travel, &asked);
    }
    enum ap_status st = AP_OK;
    if (out.carry && ap_tracker_carry(err, body->room->tracker, out.room_from_grip, out.motion))
        out.carry = false; // too far: she stays
    st = place_all(err, body, frame, input);
    if (!st)
        st = begin(err, body, frame, input);
    body->fade = out.fade;
    body->vignette = out.vignette;
    show_dots(body, &out, frame->hand[1].aim.pose);
    show_fence(body, frame);
    return st;
}
