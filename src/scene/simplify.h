#ifndef ANTIPODE_SCENE_SIMPLIFY_H
#define ANTIPODE_SCENE_SIMPLIFY_H

#include "src/scene/scene.h"

// Models that are larger than there is memory for.

// What a solid takes at the most, from its being read to its being drawn: here, on its way to the
// GPU and there.
size_t ap_solid_bytes(const struct ap_solid *solid);

// Fewer vertices and triangles: those in one cube of a grid become one (the first of them, with the
// mean of their normals), what is left of a triangle is dropped where it has no three corners any
// more. The grid is as fine as leaves at most most_bytes; but a solid that has a triangle keeps
// one. False without memory: the solid is as it was.
bool ap_solid_simplify(struct ap_solid *solid, size_t most_bytes);

#endif
