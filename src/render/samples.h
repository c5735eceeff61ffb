#ifndef ANTIPODE_RENDER_SAMPLES_H
#define ANTIPODE_RENDER_SAMPLES_H

#include "src/render/renderer.h"

// What is drawn into for a picture, by what the device has and what pays on it.

// Whether one pass draws both eyes.
bool ap_use_multiview(const struct ap_gpu *gpu, const struct ap_renderer_params *params);

struct ap_samples {
    VkSampleCountFlagBits samples; // of each pixel of the images that are drawn into
    uint32_t across;               // of those pixels for one of the target's, to each side
    bool straight;                 // drawn into the target itself: one sample a pixel, eye by eye
    bool coded;                    // drawn as sRGB codes, not as linear light (shaders/coded.glsl)
};

// What the device does not have is made of larger images; 4 samples are always there. AP_USAGE: a
// number that is not offered, or images larger than the device's.
enum ap_status ap_choose_samples(struct ap_error *err, const struct ap_gpu *gpu,
                                 const struct ap_scene *scene,
                                 const struct ap_renderer_params *params,
                                 struct ap_samples *samples);

#endif
