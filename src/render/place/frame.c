#include "src/render/place/frame.h"

#include <math.h>
#include <string.h>

// Depth clips along the axis, not by distance: with a quarter of the forbidden distance nothing
// outside it is lost within 75° of the axis. Reversed float depth pays nothing for it.
static const double PI = 3.14159265358979323846;
static const double NEAR_PLANE_M = AP_NEAR_M / 4;

void ap_store_iso(const struct ap_iso *m, float columns[16]) {
    for (int c = 0; c < 4; c++)
        for (int r = 0; r < 4; r++)
            columns[4 * c + r] = (float)m->m[r][c];
}

void ap_store_point(struct ap_space space, struct ap_vec4 p, float out[4]) {
    const struct ap_vec4 base = {0, 0, 0, space.rho_m};
    double most = fabs(p.x) + fabs(p.y) + fabs(p.z) + fabs(p.w); // NaN where one is
    if (!(most / space.rho_m < 1e36))
        p = base;
    out[0] = (float)(p.x / space.rho_m);
    out[1] = (float)(p.y / space.rho_m);
    out[2] = (float)(p.z / space.rho_m);
    out[3] = (float)(p.w / space.rho_m);
}

struct ap_eyes ap_eyes_of(const struct ap_viewer *viewer, uint32_t width, uint32_t height) {
    struct ap_eyes eyes = {0};
    for (int e = 0; e < 2; e++) {
        const struct ap_frustum *f = &viewer->eye[e].frustum;
        eyes.pixels[e] = fmax(width / (f->right - f->left), height / (f->up - f->down));
        eyes.slope[e] =
            hypot(fmax(fabs(f->left), fabs(f->right)), fmax(fabs(f->up), fabs(f->down)));
        eyes.corner_rad[e] = atan(eyes.slope[e]);
        eyes.reach_m = fmax(eyes.reach_m, ap_vec3_length(viewer->eye[e].view_from_eye.p));
        eyes.eye_from_nose[e] = ap_eye_from_nose(viewer, e);
    }
    return eyes;
}

static void rigid(struct ap_pose pose, float columns[16]) {
    struct ap_vec3 axis[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    memset(columns, 0, 16 * sizeof *columns);
    for (int c = 0; c < 3; c++) {
        struct ap_vec3 v = ap_quat_rotate(pose.q, axis[c]);
        columns[4 * c] = (float)v.x;
        columns[4 * c + 1] = (float)v.y;
        columns[4 * c + 2] = (float)v.z;
    }
    columns[12] = (float)pose.p.x;
    columns[13] = (float)pose.p.y;
    columns[14] = (float)pose.p.z;
    columns[15] = 1;
}

struct ap_gpu_frame ap_frame_of(const struct ap_viewer *viewer, bool cells) {
    struct ap_gpu_frame frame = {
        .rho = (float)viewer->space.rho_m,
        .near = (float)NEAR_PLANE_M,
        .forbidden = (float)AP_NEAR_M,
        .forbidden_sine = (float)ap_space_sin(viewer->space, AP_NEAR_M / viewer->space.rho_m),
    };
    // Below near/−z of anything within half a turn of the nose; eyes are within a metre of it.
    double half_m = PI * viewer->space.rho_m;
    if (viewer->mode == AP_VIEW_NATIVE && viewer->space.kappa > 0 && !cells)
        frame.long_way = (float)(NEAR_PLANE_M / (2 * half_m + 2) / PI);
    frame.born_rho = (float)ap_viewer_born(viewer).rho_m;
    for (int e = 0; e < 2; e++) {
        const struct ap_frustum *f = &viewer->eye[e].frustum;
        struct ap_gpu_view *view = &frame.view[e];
        rigid(ap_pose_inverse(viewer->eye[e].view_from_eye), view->eye_from_tangent);
        if (viewer->mode == AP_VIEW_BORN) {
            struct ap_iso eye_from_nose = ap_eye_from_nose(viewer, e);
            ap_store_iso(&eye_from_nose, view->eye_from_tangent);
        }
        double across = f->right - f->left, tall = f->up - f->down;
        view->projection[0] = (float)(2 / across);
        view->projection[1] = (float)(-2 / tall); // row 0 is at the top
        view->projection[2] = (float)((f->left + f->right) / across);
        view->projection[3] = (float)(-(f->up + f->down) / tall);
    }
    return frame;
}

void ap_frame_light(const struct ap_viewer *viewer, const struct ap_eyes *eyes, double lamp_reach_m,
                    double lamp_radius_m, struct ap_gpu_frame *frame) {
    double rho = viewer->space.rho_m;
    double reach = lamp_reach_m > 0 ? lamp_reach_m : viewer->space.kappa > 0 ? fmin(1, rho) : 1;
    double s = ap_space_sin(viewer->space, reach / rho);
    frame->lamp_light[0] = (float)(s * s);
    frame->lamp_light[1] = (float)fmax(ap_space_sin(viewer->space, lamp_radius_m / rho), 1e-3 * s);
    frame->lamp_light[2] = (float)(1 / fmin(eyes->pixels[0], eyes->pixels[1]));
}

// w/−z of what is seen at this distance on the axis; off the axis its size grows by at most
// 1/cos(angle) = sqrt(1 + slope²).
static double cotangent(struct ap_space space, double d_m, double slope) {
    double t = d_m / space.rho_m;
    double c = ap_space_cos(space, t) / ap_space_sin(space, t);
    return c * sqrt(1 + slope * slope);
}

void ap_frame_depth(const struct ap_viewer *viewer, const struct ap_eyes *eyes,
                    const struct ap_depth_range *range, struct ap_gpu_frame *frame) {
    struct ap_space space = viewer->mode == AP_VIEW_BORN ? viewer->born : viewer->space;
    if (space.kappa <= 0) {
        frame->depth[0][0] = (float)(NEAR_PLANE_M / space.rho_m);
        frame->depth[0][1] = 0;
        return;
    }
    double slope = fmax(eyes->slope[0], eyes->slope[1]), half = space.rho_m * 3.14159265358979;
    for (int image = 0; image < 2; image++) {
        // In image 1 distances are counted from the antipode: the same range of cotangents.
        double near_m = range->near_m[image] - image * half - eyes->reach_m;
        double far_m = range->far_m[image] - image * half + eyes->reach_m;
        near_m = fmin(fmax(near_m, NEAR_PLANE_M), half - NEAR_PLANE_M);
        far_m = fmin(fmax(far_m, NEAR_PLANE_M), half - NEAR_PLANE_M);
        double most = fmax(1, cotangent(space, near_m, slope));
        double least = fmin(-1, cotangent(space, far_m, slope));
        // depth = base + span·(w/−z − least)/(most − least)
        double span = 0.5 / (most - least), base = image == 0 ? 0.5 : 0;
        frame->depth[image][0] = (float)span;
        frame->depth[image][1] = (float)(base - span * least);
    }
}
