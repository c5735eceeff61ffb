#ifndef ANTIPODE_TESTS_SIM_HMD_STAGE_H
#define ANTIPODE_TESTS_SIM_HMD_STAGE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "sim_hmd/compose/compositor.h"
#include "src/image/image.h"

// A compositor on a headless device, handed frames as the runtime hands them, its pictures read
// back from disk.

enum { W = 64, H = 48 }; // of each eye's display

extern struct ap_gpu gpu;
extern struct sim_settings settings;
extern char folder[];

// False: there is no Vulkan device, and why was said. Validation messages are counted.
bool stage_open(void);
void stage_close(void);
void validation_is_silent(void **state);

struct picture {
    struct ap_gpu_image image;
    VkFormat format;
    uint32_t width, height, layers, samples, mips;
    bool cube; // six layers
};

// In COLOR_ATTACHMENT_OPTIMAL, as a program leaves it.
struct picture make_picture(VkFormat format, uint32_t width, uint32_t height, uint32_t layers,
                            uint32_t samples);
struct picture make_cube(VkFormat format, uint32_t size, uint32_t count);
struct picture make_mips(VkFormat format, uint32_t width, uint32_t height, uint32_t mips);
void free_picture(struct picture *p);

// Layers of `bytes_per_pixel`·width·height bytes. Does not wait for earlier work: the queue orders.
void upload(const struct picture *p, const void *bytes, uint32_t bytes_per_pixel);
// Every sample of every layer of one mip.
void fill(const struct picture *p, uint32_t mip, const float color[4]);

uint8_t *noise(size_t n);
// Colours that change slowly, so that a texel more or less does not decide.
uint8_t *smooth(uint32_t width, uint32_t height);

struct sim_compositor *create(void);
struct sim_frame new_frame(int64_t index);
struct sim_layer_view whole(const struct picture *p, const struct sim_frame *f, int eye);
struct sim_layer *add_layer(struct sim_frame *f, const struct picture *p); // a projection
void submit(struct sim_compositor *c, const struct sim_frame *f);
void flush(struct sim_compositor *c);

const char *path_of(int64_t index, int eye);
struct ap_image read_picture(int64_t index, int eye); // and removes the file

// Every pixel of the file is within `tolerance` of the reference (linear light, 3·W·H); a NaN there
// is a pixel that may be anything.
void compare(int64_t index, int eye, const double *linear, int tolerance);

// An sRGB image's texel as a bilinear sampler sees it, the edge repeated inside the view's rect;
// x and y in texels of the whole image.
void texel(const struct sim_layer_view *v, const uint8_t *bytes, double x, double y, double out[4]);

#endif
