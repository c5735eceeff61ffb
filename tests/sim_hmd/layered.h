#ifndef ANTIPODE_TESTS_SIM_HMD_LAYERED_H
#define ANTIPODE_TESTS_SIM_HMD_LAYERED_H

#include "tests/sim_hmd/painter.h"

// A program whose frames have two projection layers, of swapchains with two array layers and a
// colour for every pixel; the second is blended and shows a part of its image.

enum { W = 64, H = 48, FRAMES = 6 };

struct screen {
    XrSwapchain swapchain;
    VkImage image[3];
    VkFormat format;
    uint32_t texel_bytes;
};

struct layer {
    XrCompositionLayerProjectionView views[2];
    XrCompositionLayerProjection projection;
};

extern const XrRect2Di layered_whole, layered_part;

// Captures into `dir` of the client's folder, with `more` of capture's settings and of the
// headset's; on the virtual clock, or on the real one.
void layered_start(struct painter *p, const char *dir, const char *more, const char *profile);
void layered_start_real(struct painter *p, const char *dir, const char *more);
// For so many frames.
void layered_run(struct painter *p, VkFormat first, VkFormat second, int frames);

// Its parts.
uint8_t layered_texel(int x, int y, int layer, int channel);
struct screen layered_screen(struct painter *p, VkFormat format);
void layered_draw(struct painter *p, struct screen *s, int frame);
void layered_layer(struct painter *p, const struct screen *s, XrTime time, XrRect2Di rect,
                   XrCompositionLayerFlags flags, struct layer *l);

// What a capture has left.
bool layered_exists(const char *dir, const char *name);
char *layered_read(const char *dir, const char *name, size_t *len);

#endif
