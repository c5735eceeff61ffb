#include "src/render/mesh/decals.h"

#include <stdlib.h>
#include <string.h>

static uint32_t levels_of(uint32_t side) {
    uint32_t n = 1;
    while (side > 1) {
        side /= 2;
        n++;
    }
    return n;
}

// Each layer's pixels at every level, level after level. Box filter; an odd last row is left out.
static void fill(uint8_t *out, const struct ap_decals_params *p, uint32_t levels) {
    size_t size = (size_t)p->side_px * p->side_px * p->count;
    memcpy(out, p->coverage, size);
    const uint8_t *from = out;
    uint32_t side = p->side_px;
    for (uint32_t level = 1; level < levels; level++) {
        uint8_t *to = out + size;
        uint32_t half = side / 2;
        for (uint32_t k = 0; k < p->count; k++)
            for (uint32_t j = 0; j < half; j++)
                for (uint32_t i = 0; i < half; i++) {
                    const uint8_t *f = from + ((size_t)k * side + 2 * j) * side + (size_t)2 * i;
                    to[((size_t)k * half + j) * half + i] =
                        (uint8_t)((f[0] + f[1] + f[side] + f[side + 1] + 2) / 4);
                }
        from = to;
        side = half;
        size += (size_t)half * half * p->count;
    }
}

static size_t bytes_of(const struct ap_decals_params *p, uint32_t levels) {
    size_t size = 0;
    uint32_t side = p->side_px;
    for (uint32_t level = 0; level < levels; level++, side /= 2)
        size += (size_t)side * side * p->count;
    return size;
}

static enum ap_status upload(struct ap_error *err, const struct ap_gpu *gpu,
                             const struct ap_decals_params *p, uint32_t levels, VkImage image) {
    struct ap_gpu_buffer staging = {0};
    VkCommandBuffer cmd = VK_NULL_HANDLE;
    enum ap_status st = ap_gpu_buffer_create(err, gpu, bytes_of(p, levels),
                                             VK_BUFFER_USAGE_TRANSFER_SRC_BIT, true, &staging);
    if (st == AP_OK)
        st = ap_gpu_commands_begin(err, gpu, &cmd);
    if (st == AP_OK) {
        fill(staging.mapped, p, levels);
        ap_gpu_barrier(cmd, image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
                       VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
        VkDeviceSize at = 0;
        uint32_t side = p->side_px;
        for (uint32_t level = 0; level < levels; level++, side /= 2) {
            VkBufferImageCopy copy = {
                .bufferOffset = at,
                .imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, level, 0, p->count},
                .imageExtent = {side, side, 1}};
            vkCmdCopyBufferToImage(cmd, staging.buffer, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                                   1, &copy);
            at += (VkDeviceSize)side * side * p->count;
        }
        ap_gpu_barrier(cmd, image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                       VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
        st = ap_gpu_commands_end(err, gpu, cmd);
    }
    ap_gpu_buffer_destroy(gpu, &staging);
    return st;
}

enum ap_status ap_decals_create(struct ap_error *err, const struct ap_gpu *gpu,
                                const struct ap_decals_params *params, struct ap_decals *decals) {
    static const uint8_t nothing = 0;
    const VkPhysicalDeviceLimits *limits = &gpu->properties.limits;
    struct ap_decals_params p = *params;
    if (!p.coverage || p.count == 0 || p.side_px == 0)
        p = (struct ap_decals_params){&nothing, 1, 1};
    if (p.count > limits->maxImageArrayLayers || p.side_px > limits->maxImageDimension2D)
        return ap_fail(err, AP_USAGE, "%u texts of %u pixels are more than this device holds",
                       p.count, p.side_px);
    uint32_t levels = levels_of(p.side_px);
    VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                              .imageType = VK_IMAGE_TYPE_2D,
                              .format = VK_FORMAT_R8_UNORM,
                              .extent = {p.side_px, p.side_px, 1},
                              .mipLevels = levels,
                              .arrayLayers = p.count,
                              .samples = VK_SAMPLE_COUNT_1_BIT,
                              .usage =
                                  VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT};
    VkSamplerCreateInfo sampler = {.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
                                   .magFilter = VK_FILTER_LINEAR,
                                   .minFilter = VK_FILTER_LINEAR,
                                   .mipmapMode = VK_SAMPLER_MIPMAP_MODE_LINEAR,
                                   .addressModeU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                   .addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                   .addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                   .maxLod = (float)levels};
    struct ap_decals made = {0};
    enum ap_status st = ap_gpu_image_create(err, gpu, &info, VK_IMAGE_VIEW_TYPE_2D_ARRAY,
                                            VK_IMAGE_ASPECT_COLOR_BIT, &made.image);
    if (st == AP_OK)
        st = ap_vk_check(err, vkCreateSampler(gpu->device, &sampler, NULL, &made.sampler),
                         "vkCreateSampler");
    if (st == AP_OK)
        st = upload(err, gpu, &p, levels, made.image.image);
    if (st == AP_OK)
        *decals = made;
    else
        ap_decals_destroy(gpu, &made);
    return st;
}

void ap_decals_destroy(const struct ap_gpu *gpu, struct ap_decals *decals) {
    vkDestroySampler(gpu->device, decals->sampler, NULL);
    ap_gpu_image_destroy(gpu, &decals->image);
    memset(decals, 0, sizeof *decals);
}
