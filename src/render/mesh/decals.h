#ifndef ANTIPODE_RENDER_MESH_DECALS_H
#define ANTIPODE_RENDER_MESH_DECALS_H

#include "src/gpu/gpu.h"

// Texts that balls bear: an array of square 8-bit coverage images with all their smaller versions,
// and how to look at them. Without any it is one transparent pixel.
struct ap_decals {
    struct ap_gpu_image image;
    VkSampler sampler;
};

struct ap_decals_params {
    const uint8_t *coverage; // count squares of side_px, one after the other; NULL: none
    uint32_t side_px, count;
};
// AP_USAGE where the device cannot hold so many, or so large ones.
enum ap_status ap_decals_create(struct ap_error *err, const struct ap_gpu *gpu,
                                const struct ap_decals_params *params, struct ap_decals *decals);
void ap_decals_destroy(const struct ap_gpu *gpu, struct ap_decals *decals);

#endif
