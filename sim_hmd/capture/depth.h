#ifndef ANTIPODE_SIM_HMD_CAPTURE_DEPTH_H
#define ANTIPODE_SIM_HMD_CAPTURE_DEPTH_H

#include <stddef.h>
#include <stdint.h>
#include <vulkan/vulkan.h>

// Depths as they come out of an image's copy into a buffer (Vulkan, "Depth/Stencil Aspect Copies").

// 2 or 4. The formats are those of swapchains of depth.
size_t sim_depth_texel_bytes(VkFormat format);

// From min to max as 0 to 65535, rounded to the nearest, cut beyond; what is no number is 0. For
// D16_UNORM from 0 to 1 the texels themselves.
void sim_depth_values(const void *texels, VkFormat format, size_t count, float min, float max,
                      uint16_t *values);

#endif
