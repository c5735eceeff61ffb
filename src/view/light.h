#ifndef ANTIPODE_VIEW_LIGHT_H
#define ANTIPODE_VIEW_LIGHT_H

#include "src/geom/map.h"
#include "src/geom/space.h"

// Light in the space, in double: what shaders/light.glsl and finish.glsl do in float32 for every
// pixel. Points, normals (unit tangent 4-vectors) and the lamp in any one frame of the space,
// metres. Only light that comes the short way is counted: what would come the long way round s3 is
// taken as hidden. Pure, any thread.

struct ap_lamp {
    struct ap_vec4 at;
    double reach_m;  // the distance at which its light is 1
    double radius_m; // it is a ball
};

struct ap_lit_point {
    struct ap_vec4 at, normal; // the side that is seen
};

// cosine: of the angle between the normal and the geodesic to the lamp; negative behind. falloff:
// the area of the geodesic sphere of radius reach_m over that through the point,
// S²(reach/rho)/S²(d/rho), S = sin, the identity, sinh; at most 4.
struct ap_lamplight {
    double cosine, falloff;
};
struct ap_lamplight ap_lamp_light(struct ap_space space, const struct ap_lamp *lamp,
                                  const struct ap_lit_point *point);

// What a ball hides: of the surroundings (weighted by the cosine, of all that is above the surface
// 1) and of the lamp, by the smooth step that the shader takes for the overlap of two discs.
struct ap_hidden {
    double surroundings, lamp;
};
struct ap_hidden ap_hidden_by_ball(struct ap_space space, const struct ap_lamp *lamp,
                                   const struct ap_lit_point *point, struct ap_vec4 ball,
                                   double radius_m);

// By how much a colour (linear light) is multiplied: ambient light, a fill from where she stands,
// and the lamp. hidden: the sum of the surroundings that are, and the product of what is left of
// the lamp.
double ap_surface_strength(struct ap_space space, const struct ap_lamp *lamp,
                           const struct ap_lit_point *point, struct ap_vec4 nose,
                           double surroundings_hidden, double lamp_left);

#endif
