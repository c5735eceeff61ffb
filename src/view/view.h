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

// Where somebody born in another space takes a tangent point to stand: a point of that space, her
// nose at its base point. behind: s3 only, it is seen the long way round.
struct ap_born_point {
    struct ap_vec4 x;
    bool behind;
};

// native: distances are seen as they are, as by somebody born in flat space who is shown
// nose-centred distances (the paper's section 5). tourist: as by eyes in the curved space itself.
// native-of: as by somebody born in a space of her own (the paper's last exercise): each thing
// stands in that space in its direction and at its distance from her nose, and there she looks at
// it as a tourist does. So native is native-of e3, and tourist is native-of the world's own space.
enum ap_view_mode { AP_VIEW_NATIVE, AP_VIEW_TOURIST, AP_VIEW_BORN };

// "native", "tourist", "native-of". AP_USAGE.
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
    struct ap_space born; // AP_VIEW_BORN only
};

// The space that the visitor's eyes take the world for: flat, the world's own, or viewer->born.
struct ap_space ap_viewer_born(const struct ap_viewer *viewer);

// The mode that shows the world as somebody born in `born` sees it: native for any e3, tourist for
// the world's own space, else AP_VIEW_BORN.
enum ap_view_mode ap_view_mode_of(struct ap_space world, struct ap_space born);

// Nothing within this distance of the eye, or of its antipode (native: the nose's), is drawn.
#define AP_NEAR_M 1e-3

struct ap_nose_point ap_nose_from_world(const struct ap_viewer *viewer, struct ap_vec4 world);

// image 0, or 1 in s3.
struct ap_tangent_point ap_tangent_from_nose(struct ap_space space, struct ap_nose_point p,
                                             int image);

// exp in the space she was born in. Domain: |p| up to 700 born.rho_m in h3.
struct ap_born_point ap_born_from_tangent(struct ap_space born, struct ap_tangent_point p);

struct ap_eye_point ap_eye_from_tangent(const struct ap_view_eye *eye, struct ap_tangent_point p);

// The isometry of the space she was born in (ap_viewer_born) that takes what is seen from the nose
// to the eye's own coordinates.
struct ap_iso ap_eye_from_nose(const struct ap_viewer *viewer, int eye);

// Along which line, in the eye's axes and of any length, an eye sees a nose point, before it or
// behind it. False where there is none: the nose's antipode in image 0, the nose in image 1; in
// AP_VIEW_BORN also from a full turn of her s3 on.
bool ap_sight_line(const struct ap_viewer *viewer, int eye, struct ap_nose_point nose, int image,
                   struct ap_vec3 *line);
// The same of a tangent point; not in tourist view, whose lines need no tangent space.
bool ap_sight_line_of_tangent(const struct ap_viewer *viewer, int eye, struct ap_tangent_point p,
                              struct ap_vec3 *line);

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
