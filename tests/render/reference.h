#ifndef ANTIPODE_TESTS_RENDER_REFERENCE_H
#define ANTIPODE_TESTS_RENDER_REFERENCE_H

#include <stdbool.h>
#include <stdint.h>

#include "src/render/renderer.h"

// What an eye truly sees, in double and without a triangle that is not in the scene: each line of
// sight (native: straight in tangent space, from the eye's place; tourist: a geodesic from the eye)
// is taken to the curved space by exp, and where it meets the geodesic planes, tubes, spheres and
// facets of the scene is found by bracketing. Written from shared conventions and formulas, not
// from the renderer: exp instead of log, lines instead of vertices, both images of s3 on one line,
// and cells by walking the pairing instead of looking through faces. It knows the scene's parts,
// the tiling's shape and ap_viewer; nothing of src/render. One thread; the scene outlives it.

// Something that is drawn: a part, in a cell where the world is made of them.
struct ref_thing {
    uint32_t part;
    struct ap_iso nose_from_part;
};

struct ref_hit {
    int thing;                // −1: nothing
    int image;                // s3: 1 is the long way round
    double along_m;           // along the line of sight, from the eye
    struct ap_vec3 tangent_m; // native: the point, relative to the nose
};

struct ref_world;

// Of this frame: parts that are hidden, and hands that are not tracked, are not there.
struct ref_world *ref_world_create(const struct ap_scene *scene, const struct ap_frame_input *input,
                                   uint32_t width_px, uint32_t height_px);
void ref_world_destroy(struct ref_world *world);

int ref_thing_count(const struct ref_world *world);
const struct ref_thing *ref_thing_at(const struct ref_world *world, int thing);

// Whether either eye is inside of a closed surface, or within a millimetre of any: false: neither.
bool ref_eye_inside(const struct ref_world *world);

// Whether a thing is a part of a plane.
bool ref_is_sheet(const struct ref_world *world, int thing);

// Which eye the next lines are of.
void ref_aim(struct ref_world *world, int eye);

// What is seen at a point of the eye's picture, pixels: (i + ½, j + ½) is the middle of pixel
// (i, j). Exact up to 3 px outside of the picture.
struct ref_hit ref_cast(struct ref_world *world, double x_px, double y_px);

// Whether the line through a point of the picture meets a thing in an image at all, seen or hidden;
// how far along (may be NULL).
bool ref_meets(const struct ref_world *world, double x_px, double y_px, int thing, int image,
               double *along_m);

// The point of a thing's surface (its plane, tube or sphere as a whole) that the nose sees in the
// direction of a tangent-space point, at about its distance; and (of what is round) the one that
// lies across from that point in the curved space. Native view. False: there is none within a fifth
// of the distance, or the thing is made of facets.
bool ref_from_nose(const struct ref_world *world, int thing, struct ap_vec3 near_m,
                   struct ap_vec3 *at_m);
bool ref_foot(const struct ref_world *world, int thing, struct ap_vec3 near_m,
              struct ap_vec3 *at_m);

#endif
