#ifndef ANTIPODE_TESTS_RENDER_REFERENCE_SURFACE_H
#define ANTIPODE_TESTS_RENDER_REFERENCE_SURFACE_H

#include "tests/render/reference.h"

// Private to the reference: what a scene's parts are as surfaces in nose space. Lengths over rho;
// points have the base point at (0, 0, 0, 1).

enum ref_shape {
    REF_BALL,
    REF_STICK, // about the geodesic along z, round-ended
    REF_SHEET, // of the plane y = 0, within a regular polygon and outside of another
    REF_TUBE,  // about the geodesic along x, as far as it lies in its cell
    REF_JOINT, // a ball, likewise
    REF_FACET, // a geodesic triangle
};

struct ref_prim {
    int thing;
    enum ref_shape shape;
    int samples;             // along a span, between which it bends once at most
    bool from_outside;       // is not seen from behind
    double centre[4], reach; // every point is within reach of it; nose space
    struct ap_iso part_from_nose;
    double radius, radius2, half, cosine, sine; // C and S of the radius
    int sides;
    double turn;        // of the middle of an edge from −z, counterclockwise from above
    double inradius[2]; // of the polygon, and of the window in it (0: none)
    int cell;
    double plane[4], side[3][4]; // a facet's: > 0 outside; ≥ 0 within
};

// A ball about a thing.
struct ref_bound {
    int first_prim, prim_count;
    double centre[4], reach;
};

struct ref_surfaces {
    int kappa;
    struct ref_prim *prims;
    int prim_count, prim_room;
    struct ref_thing *things;
    struct ref_bound *bounds; // by thing
    int thing_count, thing_room;
    struct ap_iso *cell_from_nose;
    const struct ap_tiling *tiling;
};

// Places along a line of s3.
enum { REF_GRID = 72 };
struct ref_grid {
    int count;
    double t[REF_GRID], x[REF_GRID][4];
};

struct ref_ray {
    const struct ref_grid *grid;
    int kappa;
    bool tourist;
    double from[4], to[4]; // native: T = from + t·to; tourist: X = C(t)·from + S(t)·to
    double own[3];         // the direction in the eye's axes
};

struct ref_span {
    double begin, end;
};
enum { REF_SPANS = 2 };

// One surface, one line.
struct ref_search {
    const struct ref_surfaces *surfaces;
    const struct ref_prim *p;
    const struct ref_ray *ray;
    double forbidden; // nothing so near to an antipode is there
    double steep;     // the value changes at most so fast along the line
};

void ref_exp(int kappa, const double t[3], double x[4]);
void ref_ray_point(const struct ref_ray *ray, double t, double x[4]);
// How far along a line anything may be seen at all.
double ref_ray_end(const struct ref_ray *ray);
// Of a place of a line, native: its distance from the nose; tourist: from the eye.
double ref_far(const struct ref_ray *ray, double t);
double ref_steepest(const struct ref_ray *ray, struct ref_span span);
void ref_fill_grid(const struct ref_ray *ray, double from, struct ref_grid *grid);

double ref_value_at(const struct ref_search *s, double t);
// Between two places a and b where the values fa and fb have different signs.
double ref_root(const struct ref_search *s, double a, double fa, double b, double fb);
// The first place in a span where the surface is met within its outline. A span of more than half
// rho of s3 needs the line's grid.
bool ref_first(const struct ref_search *s, struct ref_span span, double *root);

void ref_surfaces_fill(struct ref_surfaces *s, const struct ap_scene *scene,
                       const struct ap_frame_input *input, const uint32_t size_px[2]);
void ref_surfaces_finish(struct ref_surfaces *s);

// Signed distance from a primitive's surface, outside or above positive; a facet's: of its plane,
// as S(distance).
double ref_value(const struct ref_surfaces *s, const struct ref_prim *p, const double x[4]);
// Something of the same sign, of s3, that grows and falls with it.
double ref_cheap(const struct ref_prim *p, const double x[4]);
// Whether a point of the surface is within its outline.
bool ref_within(const struct ref_surfaces *s, const struct ref_prim *p, const double x[4]);

void ref_cos_sin(int kappa, double t, double *c, double *s);
void ref_apply(const struct ap_iso *m, const double x[4], double y[4]);

// realloc that does not fail.
void *ref_grow(void *at, size_t bytes);

#endif
