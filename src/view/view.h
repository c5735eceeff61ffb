#ifndef ANTIPODE_VIEW_VIEW_H
#define ANTIPODE_VIEW_VIEW_H

#include <stdbool.h>

#include "src/geom/isometry.h"
#include "src/geom/map.h"
#include "src/geom/pose.h"

// The view pipeline: world → nose space → Euclidean tangent space → eye → projection (Weeks 2021,
// section 5). A type per space, so that mixing them does not compile. Metres. Double, pure.

struct ap_nose_point {
    struct ap_vec4 x; // on the space, the nose at the base point, axes of OpenXR's VIEW
};

struct ap_tangent_point {
    struct ap_vec3 x; // log of a nose point: where the visitor sees it, relative to her nose
};

struct ap_eye_point {
    struct ap_vec3 x; // the eye at the origin, −z forward
};

enum ap_view_mode { AP_VIEW_NATIVE, AP_VIEW_TOURIST };

enum ap_status ap_view_mode_from_name(struct ap_error *err, const char *name,
                                      enum ap_view_mode *mode);
const char *ap_view_mode_name(enum ap_view_mode mode);

// Tangents of the half angles: (tan left, tan right, tan up, tan down), left and down usually < 0.
struct ap_frustum {
    double left, right, up, down;
};

struct ap_view_eye {
    struct ap_pose view_from_eye; // offset and cant, as the runtime's views say
    struct ap_frustum frustum;
};

// Everything that a picture depends on, but for what is drawn.
struct ap_viewer {
    struct ap_space space;
    enum ap_view_mode mode;
    struct ap_iso world_from_nose;
    struct ap_view_eye eye[2];
};

// Nothing within this distance of the eye, or of its antipode (native: the nose's), is drawn.
#define AP_NEAR_M 1e-3

struct ap_nose_point ap_nose_from_world(const struct ap_viewer *viewer, struct ap_vec4 world);

// image 0, or 1 in s3.
struct ap_tangent_point ap_tangent_from_nose(struct ap_space space, struct ap_nose_point p,
                                             int image);

struct ap_eye_point ap_eye_from_tangent(const struct ap_view_eye *eye, struct ap_tangent_point p);

// tourist: the isometry that takes nose space to the eye's own curved coordinates.
struct ap_iso ap_eye_from_nose(const struct ap_viewer *viewer, int eye);

// The direction (tangents a = x/−z, b = y/−z in the eye's axes) in which an eye sees a world point.
// False: not in front of the eye.
bool ap_direction(const struct ap_viewer *viewer, int eye, struct ap_vec4 world, int image,
                  double *a, double *b);

// Vergence straight ahead at distance d, eyes at ±ipd/2: radians. AP_INPUT: ipd or d ≤ 0, d ≥
// 2·pi·rho in s3. Error at most 2e-15 rad.
enum ap_status ap_vergence_ahead(struct ap_error *err, struct ap_space space,
                                 enum ap_view_mode mode, double ipd_m, double d_m,
                                 double *vergence_rad);

#endif
