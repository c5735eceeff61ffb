#ifndef ANTIPODE_TESTS_RENDER_STAGE_H
#define ANTIPODE_TESTS_RENDER_STAGE_H

#include "src/image/image.h"
#include "src/render/renderer.h"

// A device, a target of two layers and what is read back from it: what the renderer's tests share.
struct stage {
    struct ap_gpu gpu;
    int validation_errors;
    uint32_t width, height;
    struct ap_gpu_image target;
    struct ap_gpu_buffer pixels; // RGBA, eye after eye
};

// False, with a message on standard output, where there is no Vulkan device. Any other failure ends
// the process.
bool stage_open(struct stage *stage, uint32_t width, uint32_t height, bool validate);
void stage_resize(struct stage *stage, uint32_t width, uint32_t height);
void stage_close(struct stage *stage);

struct ap_renderer *stage_renderer(const struct stage *stage, const struct ap_scene *scene,
                                   const struct ap_renderer_params *params);

// Draws, waits and reads both eyes back.
struct ap_frame_stats stage_draw(struct stage *stage, struct ap_renderer *renderer,
                                 const struct ap_frame_input *input);
const uint8_t *stage_eye(const struct stage *stage, int eye);
struct ap_image stage_picture(const struct stage *stage, int eye); // the caller finishes it

// Two eyes at ±ipd/2, a symmetric field of view, the nose at the base point.
struct ap_frame_input stage_input(struct ap_space space, enum ap_view_mode mode, double half_rad,
                                  double ipd_m);

// A scene of parts that the caller owns, black behind, lamp overhead.
struct ap_scene stage_scene(struct ap_space space, struct ap_part *parts, size_t count);

// An unlit ball.
struct ap_part stage_ball(struct ap_space space, struct ap_vec3 at_m, double radius_m,
                          const uint8_t color[3]);

#define STAGE_CHECK(call) stage_check((call), &stage_error, __FILE__, __LINE__)
extern struct ap_error stage_error;
void stage_check(enum ap_status st, const struct ap_error *err, const char *file, int line);

#endif
