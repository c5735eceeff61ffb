#ifndef ANTIPODE_RENDER_RENDERER_H
#define ANTIPODE_RENDER_RENDERER_H

#include <stdbool.h>
#include <stdint.h>

#include "src/gpu/gpu.h"
#include "src/scene/scene.h"
#include "src/view/portal.h"
#include "src/view/view.h"

// Draws a scene for both eyes with Vulkan: nose-from-object matrices made in double on the CPU, the
// log map per vertex on the GPU (no inverse or hyperbolic built-ins), one pass for both eyes where
// multiview is there, 4 samples a pixel, resolved in linear light (an sRGB target), or as many as
// asked for. docs/rendering.md.

struct ap_renderer;

struct ap_renderer_params {
    VkFormat color_format;  // an sRGB format, or the result is written linear
    uint32_t width, height; // of one eye; both eyes are drawn at one size
    uint32_t samples;       // a pixel: 1 (at its middle: edges have steps), 4, 16 or 64; 0: 4, and
                            // how they are made is the renderer's
    double max_error_px;    // 0: 0.25; how far from its true direction a surface may be seen
    // The scene's texts as coverage, 0…255: a square of decal_px for each of its decals, one after
    // the other. Copied. NULL: balls bear none.
    const uint8_t *decals;
    uint32_t decal_px, decal_count;
    bool no_multiview;          // one pass for each eye; what a software device gets anyway, unless
    bool multiview_in_software; // …the test that proves the two ways equal asks for it
    // Leave nothing out: every part and image for both eyes, all cells within the horizon, whether
    // an eye can see any of it or not. The pictures stay the same; for tests and to compare the
    // work. An eye that is shut stays so.
    bool no_cull;
    int64_t (*now_ns)(void); // a clock for the times in ap_frame_stats; NULL: they are 0
};

// Borrows gpu and scene, which must outlive the renderer; the parts' places, colours, `hidden`
// and the radius of balls may change between frames, their number and other shapes may not. Where
// the physical device has the multiview feature (core in Vulkan 1.1) the device must have been
// created with it, unless no_multiview; nothing else is asked of the device. One thread. A queue
// that failed cannot be used again: destroy the renderer.
enum ap_status ap_renderer_create(struct ap_error *err, const struct ap_gpu *gpu,
                                  const struct ap_scene *scene,
                                  const struct ap_renderer_params *params,
                                  struct ap_renderer **renderer);
void ap_renderer_destroy(struct ap_renderer *renderer);

// What moves from frame to frame.
struct ap_frame_input {
    struct ap_viewer viewer;
    bool hand_tracked[2]; // left, right: parts of a hand that is not tracked are not drawn
    struct ap_iso world_from_hand[2];
    bool
        plain; // no materials, texts and shadows: light at the corners of triangles only, for speed
    unsigned closed_eyes; // bit e: eye e is shut, its picture is black and costs nothing
};

struct ap_eye_stats {
    uint32_t draws;               // parts·images drawn that this eye may see
    uint32_t culled;              // parts·images that it cannot see
    uint32_t turned_away;         // of `culled`, those that it would only see the back of
    uint32_t back_hidden;         // of `culled`, those of s3's back hemisphere that a polygon in
                                  // front of them hides
    uint32_t back_draws;          // of `draws`, those of s3's back hemisphere
    uint64_t triangles, vertices; // mapped for it
};
struct ap_frame_stats {
    struct ap_eye_stats eye[2];
    uint32_t refined;       // parts·images whose triangles were made for this frame
                            // (src/render/refine/refine.h)
    uint32_t unseen_facets; // triangles of those that were left out: out of sight or turned away
    uint32_t beyond_bound;  // parts·images that even the finest triangles show farther off than
                            // max_error_px
    uint32_t over_budget;   // of `beyond_bound`, those for which the scene's budget had no room for
                            // finer ones; it is said once
    uint32_t out_of_domain; // parts whose place is no number, or beyond float's range: not drawn
    // Milliseconds of the calling thread: waiting for the frame before the last, placing, culling
    // and refining, recording, submitting.
    double wait_ms, place_ms, record_ms, submit_ms;
    struct ap_portal_stats cells; // of a scene of cells
    // Memory that is held for meshes, lists and this frame and the one before, in the process and
    // on the GPU, but for images; of what the scene's budget bounds.
    size_t held_bytes;
};

// Draws into two images (or two layers of one): image + array layer per eye, created with
// COLOR_ATTACHMENT usage, in any layout; left in COLOR_ATTACHMENT_OPTIMAL. Submits to gpu->queue
// and does not wait. The images stay in use by the queue until it is idle or the next two frames
// end.
struct ap_target {
    VkImage image[2];
    uint32_t layer[2];
};
enum ap_status ap_renderer_draw(struct ap_error *err, struct ap_renderer *renderer,
                                const struct ap_frame_input *input, const struct ap_target *target,
                                struct ap_frame_stats *stats);

// How long the GPU took for the newest frame. False: it is not done, or the device cannot tell.
bool ap_renderer_gpu_ms(const struct ap_renderer *renderer, double *ms);

#endif
