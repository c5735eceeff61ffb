#ifndef ANTIPODE_SIM_HMD_COMPOSE_SHAPE_H
#define ANTIPODE_SIM_HMD_COMPOSE_SHAPE_H

#include "sim_hmd/compose/frame.h"

// Where an eye sees a layer. An eye's picture is (u, v): (0, 0) its left top corner, (1, 1) the
// other. The ray of a pixel is linear in them, so it is worked out here in double for the three
// corners and interpolated by the GPU.

// What the shaders are told of a layer: shaders/composite.glsl, std140.
struct sim_shape {
    float from_uv[3][4];
    float origin[4];
    float shape[4];
    float limit[4];
};

struct sim_seen {
    bool any;          // false: nothing of it is in the picture
    bool all;          // every pixel of the picture meets the layer
    double from_uv[2]; // nothing of it is outside of these
    double to_uv[2];
    bool part;    // of an image only
    bool around;  // a sphere's picture goes all around: its right side joins its left one
    bool centred; // the middle of a curved layer is the eye, or it is infinitely far
    struct sim_shape shape;
};

// The layer as this eye sees it.
struct sim_seen sim_layer_seen(const struct sim_frame *frame, int eye,
                               const struct sim_layer *layer);

#endif
