#ifndef ANTIPODE_GPU_GPU_H
#define ANTIPODE_GPU_GPU_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <vulkan/vulkan.h>

#include "src/base/status.h"

// What the renderer and the simulated headset share of Vulkan: memory, buffers, images, read-back,
// shader modules, one-off commands. A struct ap_gpu borrows the handles of a device that somebody
// else made (an OpenXR program's, or ap_gpu_create_headless's for tests). All vk calls go through
// vkGetInstanceProcAddr/vkGetDeviceProcAddr of that program, so that a runtime inside somebody
// else's process never links its own idea of the loader.
struct ap_gpu {
    VkInstance instance;
    VkPhysicalDevice physical_device;
    VkDevice device;
    uint32_t queue_family;
    VkQueue queue;
    VkPhysicalDeviceMemoryProperties memory;
    VkPhysicalDeviceProperties properties;
    VkCommandPool pool; // resettable; the owner's thread only
    bool owns_device;
    VkDebugUtilsMessengerEXT messenger; // of ap_gpu_create_headless
};

// Borrows; creates only the command pool. AP_ENVIRONMENT with the VkResult's name.
enum ap_status ap_gpu_init(struct ap_error *err, VkInstance instance, VkPhysicalDevice physical,
                           VkDevice device, uint32_t family, uint32_t queue_index,
                           struct ap_gpu *gpu);

// An instance and device of its own, no window system: for tests and `doctor`. validation: the
// Khronos layer, whose errors are logged and counted in *validation_errors (may be NULL) where it
// is there. A real GPU goes before a software one; multiview is enabled where the device has it.
struct ap_gpu_headless_params {
    bool validation;
    int *validation_errors;
};
enum ap_status ap_gpu_create_headless(struct ap_error *err,
                                      const struct ap_gpu_headless_params *params,
                                      struct ap_gpu *gpu);
void ap_gpu_finish(struct ap_gpu *gpu);

// "VK_ERROR_DEVICE_LOST" and so on.
const char *ap_vk_result_name(VkResult result);

// AP_ENVIRONMENT "what: VK_…" unless VK_SUCCESS.
enum ap_status ap_vk_check(struct ap_error *err, VkResult result, const char *what);

struct ap_gpu_buffer {
    VkBuffer buffer;
    VkDeviceMemory memory;
    VkDeviceSize size;
    void *mapped; // host-visible ones stay mapped (coherent)
};

// host: visible and coherent, mapped; else device local.
enum ap_status ap_gpu_buffer_create(struct ap_error *err, const struct ap_gpu *gpu,
                                    VkDeviceSize size, VkBufferUsageFlags usage, bool host,
                                    struct ap_gpu_buffer *buffer);
void ap_gpu_buffer_destroy(const struct ap_gpu *gpu, struct ap_gpu_buffer *buffer);

struct ap_gpu_image {
    VkImage image;
    VkDeviceMemory memory;
    VkImageView view; // all layers, all mips; none for an image that is only copied
};
enum ap_status ap_gpu_image_create(struct ap_error *err, const struct ap_gpu *gpu,
                                   const VkImageCreateInfo *info, VkImageViewType view_type,
                                   VkImageAspectFlags aspect, struct ap_gpu_image *image);
void ap_gpu_image_destroy(const struct ap_gpu *gpu, struct ap_gpu_image *image);

// SPIR-V words as compiled at build time.
enum ap_status ap_gpu_shader(struct ap_error *err, const struct ap_gpu *gpu, const uint32_t *words,
                             size_t bytes, VkShaderModule *module);

// Records and runs commands to their end: begin, vkCmd… into *cmd, end (submits and waits).
enum ap_status ap_gpu_commands_begin(struct ap_error *err, const struct ap_gpu *gpu,
                                     VkCommandBuffer *cmd);
enum ap_status ap_gpu_commands_end(struct ap_error *err, const struct ap_gpu *gpu,
                                   VkCommandBuffer cmd);

// What a barrier for an image of this format names: colour, depth, or depth and stencil.
VkImageAspectFlags ap_gpu_aspect(VkFormat format);

// A whole image (all mips and layers), after everything before and before everything after, the
// host's reads included.
void ap_gpu_barrier(VkCommandBuffer cmd, VkImage image, VkImageAspectFlags aspect,
                    VkImageLayout from, VkImageLayout to);

#endif
