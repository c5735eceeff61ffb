#ifndef ANTIPODE_RENDER_PLACE_PLACE_H
#define ANTIPODE_RENDER_PLACE_PLACE_H

#include "src/render/place/frame.h"
#include "src/render/mesh/meshes.h"
#include "src/scene/scene.h"
#include "src/view/screen.h"

// Where a part is in a frame, as the nose sees it: all in double on the CPU.
struct ap_place {
    struct ap_iso nose_from_part;
    double near_m, far_m; // every point's distance from the nose lies between (conservative)
    double reach_m;       // every point's distance from its place is at most so much
    bool anywhere;        // within that it may be anywhere, turned in any way
    unsigned eyes[2];     // for image 0 and 1: bit e, eye e may see it
    unsigned behind;      // that would see it in image 1 if nothing stood before it
};

struct ap_place_params {
    const struct ap_viewer *viewer;
    struct ap_iso nose_from_carrier[3]; // by enum ap_carrier, but for cells
    bool no_cull;
    const struct ap_screen *screens; // what hides s3's back hemisphere
    int screen_count;
};

struct ap_place ap_place_part(const struct ap_place_params *params, const struct ap_part *part,
                              double reach_m);

// Least distance (metres) from the nose, and in s3 from its antipode, that the part's own symmetry
// allows: a polygon and a wall lie in their plane, a stick and a strut about their axis.
// nose_in_part: the nose in the part's coordinates.
double ap_clearance(struct ap_space space, const struct ap_part *part, struct ap_vec4 nose_in_part);

// A polygon as a screen before s3's back hemisphere; false where it is none for sure.
bool ap_place_screen(const struct ap_place_params *params, const struct ap_part *part,
                     double reach_m, double slack_rad, struct ap_screen *screen);

// False: somewhere in it is no number, or one that float32 cannot hold the products of.
bool ap_place_in_domain(const struct ap_place *place);

// The coarsest mesh made ahead that is seen nowhere farther than max_error_px from the surface it
// stands for (docs/rendering.md says by which bounds). False, *level the finest: none is, by these
// bounds; ap_refine_part looks closer.
// whole_seams: by what ap_line_depth would say at the worst none of the shape's seams
// need be cut, wherever they are within the place; false says nothing.
struct ap_level {
    int level;
    bool whole_seams;
};
bool ap_choose_level(const struct ap_viewer *viewer, const struct ap_eyes *eyes,
                     const struct ap_part *part, const struct ap_shape *shape,
                     const struct ap_place *place, int image, double max_error_px,
                     struct ap_level *level);

// A line of a tube, a sphere (radius_m about their axis and middle) or a plane (0), as the nose
// sees it: where its ends are, unit, and what its points' distances lie between; in h3 far_m may be
// INFINITY. length_m is along it; on a sphere it is bend_rad wide to either side of its middle.
struct ap_line {
    struct ap_vec3 toward[2];
    double near_m, far_m, radius_m, length_m, bend_rad;
};

// By the same bounds: into how many equal pieces, 2 to the power of what is returned, a line is cut
// at least, to be seen by either eye within max_error_px of where it is. −1: they say so of none up
// to 2^most, or say nothing. Never more than they say of a mesh with such steps that holds the
// line.
int ap_line_depth(const struct ap_viewer *viewer, const struct ap_eyes *eyes,
                  const struct ap_line *line, int image, double max_error_px, int most);

// How far 1/distance is off in h3, at most, on a straight triangle in tangent space for a geodesic
// one: over 1/rho; the longest edge and the distance of the nearest point over rho, length < d. It
// is the edge whose middle is nearest, with an allowance: the worst of 40,000 random triangles is
// 1.62 times that edge (tests/render/test_edge.c). Far off it allows three times what length²/(9·d)
// does.
double ap_edge_miss_h3(double length, double d);

// The same in s3 seen the long way round, where what is near, as far as half a turn off, takes up
// much of the picture: the longest edge, the nearest and the farthest distance by the short way,
// over rho; length < near.
double ap_edge_miss_long_way(double length, double near, double far);

// Whether fragments must be looked at: something of it may come within the forbidden distance of an
// eye or an antipode, or its facets may straddle s3's antipode, or an eye may be inside it.
bool ap_needs_guard(const struct ap_viewer *viewer, const struct ap_eyes *eyes,
                    const struct ap_place *place);

// The geodesic surface that all of a part's facets stand for, where it may cross others: a stick's
// caps and sides are two, and a ball touches things at most.
enum ap_form ap_part_form(const struct ap_part *part);

// Whether s3 in native view stretches something of it so much across the line of sight that
// surfaces which cross one another are seen to meet at small angles: near the antipode, and the
// long way round.
bool ap_is_stretched(const struct ap_viewer *viewer, const struct ap_place *place, int image);

// Whether nothing of it comes within the forbidden distance of an eye or an antipode.
bool ap_clear_of_eyes(const struct ap_viewer *viewer, const struct ap_eyes *eyes,
                      const struct ap_place *place);

// A plane's part moved along itself, to the foot of the nose's perpendicular: there its coordinates
// are small, and float32 tells points apart that a nose so near sees in any direction the long way
// round. With nose_from_part = nose_from_part · this.
struct ap_iso ap_plane_foot(struct ap_space space, const struct ap_iso *nose_from_part);

#endif
