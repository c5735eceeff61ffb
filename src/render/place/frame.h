#ifndef ANTIPODE_RENDER_PLACE_FRAME_H
#define ANTIPODE_RENDER_PLACE_FRAME_H

#include <stdbool.h>
#include <stdint.h>

#include "src/geom/isometry.h"
#include "src/scene/scene.h"
#include "src/view/view.h"

// shaders/frame.glsl in C: what the CPU makes in double and hands over rounded once. Matrices are
// column by column.

struct ap_gpu_view {
    float eye_from_tangent[16];
    float projection[4];
};

// std140
struct ap_gpu_frame {
    struct ap_gpu_view view[2];
    float depth[2][4];
    float rho, near;
    float forbidden, forbidden_sine;
    float born_rho, long_way, unused[2];
    float lamp_light[4];
};

enum { AP_DRAW_MESH, AP_DRAW_BALL, AP_DRAW_SHEET };

// std430
struct ap_gpu_draw {
    float to[2][16];
    float lamp[4], nose[4], color[4], shape[4], finish[4], root[4];
};

// std140; shaders/finish.glsl. Shadows of balls, then the mouths of pockets; a sine of 0: none.
enum { AP_SHADOWS_MAX = 16, AP_MARKS_MAX = AP_SHADOWS_MAX + AP_MOUTHS_MAX };
struct ap_gpu_marks {
    float at[AP_MARKS_MAX][4], sine[AP_MARKS_MAX];
    float mouth_inverse[AP_MOUTHS_MAX]; // 1/S² of a mouth's radius
};

// The eyes, as far as they do not depend on what is drawn.
struct ap_eyes {
    struct ap_iso eye_from_nose[2]; // tourist and native-of
    double reach_m;                 // the farther eye's distance from the nose
    double pixels[2];               // pixels a unit of tangent, the larger of the two axes
    double slope[2];                // the largest tangent at the picture's corners
    double corner_rad[2];           // its angle
};
struct ap_eyes ap_eyes_of(const struct ap_viewer *viewer, uint32_t width, uint32_t height);

// Everything but depth[] and lamp_light. In native views of s3 all that is seen the long way round
// lies behind all that is not, and is up to a full turn away: near/−z would not tell what is a
// metre apart where the radius is a hundred. So its depth is counted from the other end, by its
// angle from the nose the short way, to a float's digits of that. Worlds of cells (cells) are no
// larger than a few cells, and keep near/−z.
struct ap_gpu_frame ap_frame_of(const struct ap_viewer *viewer, bool cells);

// The lamp's reach and radius as in ap_scene.
void ap_frame_light(const struct ap_viewer *viewer, const struct ap_eyes *eyes, double lamp_reach_m,
                    double lamp_radius_m, struct ap_gpu_frame *frame);

// How the tourist's depth is spread: from the distance of the nearest to that of the farthest thing
// there is (along the way it is seen in each image; in native-of view: each way round her own s3).
// Reversed: nearer is larger; in s3 image 0 gets the larger half.
struct ap_depth_range {
    double near_m[2], far_m[2];
};
void ap_frame_depth(const struct ap_viewer *viewer, const struct ap_eyes *eyes,
                    const struct ap_depth_range *range, struct ap_gpu_frame *frame);

void ap_store_iso(const struct ap_iso *m, float columns[16]);
// Over rho; the base point for what float32 cannot hold: a lamp so far away gives no light anyway.
void ap_store_point(struct ap_space space, struct ap_vec4 p, float out[4]);

#endif
