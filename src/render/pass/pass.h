#ifndef ANTIPODE_RENDER_PASS_PASS_H
#define ANTIPODE_RENDER_PASS_PASS_H

#include "src/gpu/gpu.h"

// One way of drawing: a render pass with the images that it draws into and its pipelines, for one
// eye at a time (views 1) or both at once with multiview (views 2).

enum ap_pipeline_kind {
    AP_PIPELINE_CLOSED,      // back faces are not seen
    AP_PIPELINE_TWOSIDED,    // polygons, and solids that somebody else made
    AP_PIPELINE_MATTE_BALLS, // closed; light at every fragment, and nothing else
    AP_PIPELINE_MATTE,
    AP_PIPELINE_PLANES, // matte, of one normal
    AP_PIPELINE_BALLS,  // light and material at every fragment: closed, closed, two-sided
    AP_PIPELINE_STICKS,
    AP_PIPELINE_SHEETS, // and solids
    AP_PIPELINE_GUARD,  // every fragment is looked at; and so many as AP_GUARD_… after it
    AP_PIPELINE_GUARD_END = AP_PIPELINE_GUARD + 20,
    AP_PIPELINE_DISC =
        AP_PIPELINE_GUARD_END, // src/render/refine/disc.h; over all others, far before near
    AP_PIPELINE_COUNT
};

// Added up: back faces are not seen; depth is the surface's and not the facet's (native views of
// s3); light and material at every fragment.
enum {
    AP_GUARD_CLOSED = 1,
    AP_GUARD_EXACT = 2,
    AP_GUARD_BALLS = 4,
    AP_GUARD_STICKS = 8,
    AP_GUARD_SHEETS = 12,
    AP_GUARD_MATTE = 16
};

// What the shaders are made for: a sign of curvature and a way of looking at it. Each has pipelines
// of its own, since a software device runs both sides of every branch.
enum { AP_WORLD_COUNT = 12 };
struct ap_world {
    int kappa, mode; // mode: enum ap_view_mode
    int born_kappa;  // native-of
};

enum { AP_PASS_SHADERS = 12 };

struct ap_pass_params {
    VkFormat color_format;
    uint32_t width, height, views;
    VkSampleCountFlagBits samples;
    bool coded;    // the image holds sRGB codes as plain numbers, written and read by the shaders
    bool straight; // into somebody else's image, in which it stays: none of its own
    int32_t marks; // MARKS of shaders/finish.glsl
    VkPipelineLayout layout;
};

struct ap_pass {
    struct ap_pass_params params;
    uint32_t views;
    VkRenderPass render_pass;  // colour, which is read afterwards, and depth
    VkFramebuffer framebuffer; // straight: none
    struct ap_gpu_image color, depth;
    VkImageView read;                       // of what is read afterwards: as color.view, or coded
    VkShaderModule shader[AP_PASS_SHADERS]; // vertex and fragment in turn
    VkPipeline pipeline[AP_WORLD_COUNT][AP_PIPELINE_COUNT]; // made when they are first needed
};

enum ap_status ap_pass_create(struct ap_error *err, const struct ap_gpu *gpu,
                              const struct ap_pass_params *params, struct ap_pass *pass);
// Of a straight pass: a framebuffer, the caller's, that draws into an image of the pass's size.
enum ap_status ap_pass_framebuffer(struct ap_error *err, const struct ap_gpu *gpu,
                                   const struct ap_pass *pass, VkImageView color,
                                   VkFramebuffer *framebuffer);
// The pipelines for a world. Those of the kinds that are marked are made if this is the first time:
// most frames need few of them, and a software device takes some 50 ms for each.
enum ap_status ap_pass_pipelines(struct ap_error *err, const struct ap_gpu *gpu,
                                 struct ap_world world, const bool needed[AP_PIPELINE_COUNT],
                                 struct ap_pass *pass, const VkPipeline **pipelines);
void ap_pass_destroy(const struct ap_gpu *gpu, struct ap_pass *pass);

#endif
