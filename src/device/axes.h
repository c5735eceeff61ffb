#ifndef ANTIPODE_DEVICE_AXES_H
#define ANTIPODE_DEVICE_AXES_H

#include <stdbool.h>
#include <stddef.h>

#include "src/geom/pose.h"

// Another system of axes, of the world and of the devices in it, turned into ours (x right, y up,
// z back). Mirrored systems (left-handed ones) too.
struct ap_axes {
    bool given;              // false: they are ours
    unsigned char source[3]; // our x, y, z is its 0: x, 1: y, 2: z …
    signed char sign[3];     // … times this
    signed char determinant; // −1: mirrored
};

// "xz-y": our x is its x, our y its z, our z its −y. False where a letter is missing or twice.
bool ap_axes_parse(const char *text, size_t len, struct ap_axes *axes);

// Exact: permutations and signs. A direction or a place; what turns (a rate); an orientation.
struct ap_vec3 ap_axes_vec3(const struct ap_axes *axes, struct ap_vec3 v);
struct ap_vec3 ap_axes_rate(const struct ap_axes *axes, struct ap_vec3 w);
struct ap_quat ap_axes_quat(const struct ap_axes *axes, struct ap_quat q);

#endif
