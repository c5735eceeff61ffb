#ifndef ANTIPODE_RENDER_REFINE_REFINE_SURFACE_H
#define ANTIPODE_RENDER_REFINE_REFINE_SURFACE_H

#include "src/render/place/frame.h"
#include "src/scene/scene.h"

// The surface of a part by coordinates of its own, and where two eyes see a point of it.

// What a part is, as far as its surface goes: solids with a form are one of the other three.
enum ap_surface_shape { AP_SURFACE_BALL, AP_SURFACE_TUBE, AP_SURFACE_SHEET };
enum ap_surface_shape ap_surface_shape_of(const struct ap_part *part);

// Whether it is round and bears no pattern: then a place of it may be drawn elsewhere on it, across
// its outline's bound by up to four times as much, without anything that shows it.
bool ap_surface_is_bare(const struct ap_part *part);

// Of a ball and a tube: the place along the axis over rho (a ball's is 0), and the unit vector
// from there, across a tube but in a stick's caps. Sheets need neither.
struct ap_surface_point {
    double along, sine, cosine; // and S and C of it
    struct ap_vec3 from;
    struct ap_vec4 p;         // in the part's coordinates, over rho
    struct ap_vec3 tangent_m; // relative to the nose; not in tourist view
    double share; // of the nose-space point, what is seen is a multiple: one over it (tourist: 1)
    struct ap_vec3 seen[2];   // from each eye, in its axes: native metres, else a direction
    struct ap_vec3 toward[2]; // its direction, of length 1
    struct ap_vec3 outward;   // what ap_surface_face gives: native
    double away[2];           // tourist
};

struct ap_surface {
    const struct ap_part *part;
    enum ap_surface_shape shape;
    bool bare;
    struct ap_space space;
    enum ap_view_mode mode;
    struct ap_space born; // of AP_VIEW_BORN
    int image;
    bool any_depth;      // an error in depth does not count
    double sine, cosine; // S and C of a ball's or a tube's radius
    struct ap_iso nose_from_part;
    struct ap_iso eye_from_part[2]; // tourist; AP_VIEW_BORN: of the nose in the space of her birth
    struct ap_iso eye_from_view[2]; // native; the upper rows
    struct ap_vec3 eye_m[2];        // native: where the eyes are, relative to the nose
    struct ap_vec3 inward[2][4]; // unit normals of the sides of the eyes' pictures, in their axes
};

struct ap_surface ap_surface_of(const struct ap_viewer *viewer, const struct ap_eyes *eyes,
                                const struct ap_part *part, struct ap_iso nose_from_part,
                                int image);

// along and from of a point (over rho) of the surface of a solid with a form.
struct ap_surface_point ap_surface_point_of(const struct ap_surface *surface, struct ap_vec4 p);

// along, with its S and C.
void ap_surface_place(const struct ap_surface *surface, double along,
                      struct ap_surface_point *point);
// Fills p, tangent_m and seen: from along and from, or (sheets) from p.
void ap_surface_see(const struct ap_surface *surface, struct ap_surface_point *point);
// Of a round surface. Native view: fills outward, the unit normal in tangent space; tourist: away,
// the cosine between the surface's normal and each eye's line of sight, onward.
void ap_surface_face(const struct ap_surface *surface, struct ap_surface_point *point);

// Halfway between two points along the surface, seen.
struct ap_surface_point ap_surface_middle(const struct ap_surface *surface,
                                          const struct ap_surface_point *a,
                                          const struct ap_surface_point *b);

// The unit normal 4-vector; of a ball as its meshes have it (src/render/mesh/mesh.h).
struct ap_vec4 ap_surface_normal(const struct ap_surface *surface,
                                 const struct ap_surface_point *point);

// Whether geodesics are drawn exactly: a sheet in e3, and as a tourist sees it.
bool ap_surface_is_straight(const struct ap_surface *surface);

// How many pixels of an eye's picture lie between the surface at m, and the place of the straight
// edge from a to b that stands for it (of what is bare: any place of the edge); m: the middle, or
// (round surfaces) about the share k of the way. A quarter of the error in depth counts (added in a
// sheet's case), as it shows where surfaces meet. The larger of the two eyes.
double ap_surface_error_px(const struct ap_surface *surface, const struct ap_eyes *eyes,
                           const struct ap_surface_point *a, const struct ap_surface_point *b,
                           double k, const struct ap_surface_point *m);

// Whether three points, and what the surface bulges between them, lie outside one side of the
// picture, for each eye. False in native-of view, and where they are far apart.
bool ap_surface_out_of_sight(const struct ap_surface *surface,
                             const struct ap_surface_point *const points[3]);

#endif
