// A game that chooses its own anchor: half way between the head and the midpoint of the hands,
// facing as the head does. Built against an installed antipode:
//
//     cc midpoint_anchor.c $(pkg-config --cflags --libs libantipode) -lm -o midpoint_anchor
//
// A player turns and leans about for four seconds and comes back to where she was. With the anchor
// her hands are back where her eyes left them; with the naive integration of every device by itself
// they are not, but in flat space.

#include <math.h>
#include <stdio.h>

#include <antipode/track/anchored.h>

enum { HEAD, LEFT, RIGHT, DEVICES };
enum { FRAMES = 360 };

// Where the devices are at a time from 0 to 1: what an OpenXR program gets from xrLocateSpace.
static struct ap_pose locate(int device, double t) {
    const double turn = 6.283185307179586 * t;
    struct ap_pose pose = {{0, 1.6, 0}, {0, 0, 0, 1}};
    if (device == HEAD) {
        pose.p.x = 0.3 * sin(turn);
        pose.p.z = 0.3 * (1 - cos(turn));
        pose.q = ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, 0.5 * sin(turn));
    } else {
        pose.p.x = (device == LEFT ? -0.25 : 0.25) + 0.1 * sin(2 * turn);
        pose.p.y = 1.1 + 0.2 * sin(turn);
        pose.p.z = -0.35;
    }
    return pose;
}

static struct ap_pose anchor_of(const struct ap_pose device[DEVICES]) {
    struct ap_vec3 hands = ap_vec3_add(device[LEFT].p, device[RIGHT].p);
    struct ap_vec3 middle = ap_vec3_add(ap_vec3_scale(0.5, device[HEAD].p), //
                                        ap_vec3_scale(0.25, hands));
    return (struct ap_pose){middle, device[HEAD].q};
}

// How far the left hand is, in metres, from the place it first had with respect to the head.
static double hand_off_m(struct ap_space space, struct ap_iso first, struct ap_iso head,
                         struct ap_iso hand) {
    struct ap_iso now = ap_iso_mul(ap_iso_inverse(space, head), hand);
    struct ap_iso d = ap_iso_mul(ap_iso_inverse(space, first), now);
    double r = sqrt(d.m[0][3] * d.m[0][3] + d.m[1][3] * d.m[1][3] + d.m[2][3] * d.m[2][3]);
    return space.rho_m * (space.kappa > 0 ? asin(r) : space.kappa < 0 ? asinh(r) : r);
}

static int play(struct ap_space space) {
    const struct ap_vec3 floor_m = {0, 0, 0};
    struct ap_anchored body, naive[DEVICES];
    struct ap_pose device[DEVICES];
    struct ap_iso first = AP_ISO_IDENTITY, first_naive = AP_ISO_IDENTITY;
    double off_m = 0, naive_off_m = 0;
    for (int frame = 0; frame <= FRAMES; frame++) {
        for (int i = 0; i < DEVICES; i++)
            device[i] = locate(i, (double)frame / FRAMES);

        if (frame == 0)
            ap_anchored_init(&body, space, floor_m, anchor_of(device));
        else
            ap_anchored_move(&body, anchor_of(device));
        struct ap_iso head = ap_anchored_place(&body, device[HEAD]);
        struct ap_iso hand = ap_anchored_place(&body, device[LEFT]);

        // The naive way, to see what the anchor is good for: every device is its own anchor.
        for (int i = 0; i < DEVICES; i++) {
            if (frame == 0)
                ap_anchored_init(&naive[i], space, floor_m, device[i]);
            else
                ap_anchored_move(&naive[i], device[i]);
        }
        struct ap_iso naive_head = naive[HEAD].world_from_anchor.hi;
        struct ap_iso naive_hand = naive[LEFT].world_from_anchor.hi;

        if (frame == 0) {
            first = ap_iso_mul(ap_iso_inverse(space, head), hand);
            first_naive = ap_iso_mul(ap_iso_inverse(space, naive_head), naive_hand);
        }
        off_m = hand_off_m(space, first, head, hand);
        naive_off_m = hand_off_m(space, first_naive, naive_head, naive_hand);
    }
    printf("%s: left hand off by %.1f mm with the anchor, %.1f mm in the naive way\n",
           ap_space_name(space), 1e3 * off_m, 1e3 * naive_off_m);
    return off_m < 1e-12 && (space.kappa == 0 ? naive_off_m < 1e-12 : naive_off_m > 1e-3);
}

int main(void) {
    static const char *const names[] = {"s3", "e3", "h3"};
    struct ap_error err;
    int good = 1;
    for (int i = 0; i < 3; i++) {
        struct ap_space space;
        if (ap_space_from_name(&err, names[i], 0.85, &space)) {
            fprintf(stderr, "%s\n", err.text);
            return 2;
        }
        good = play(space) && good;
    }
    return good ? 0 : 1;
}
