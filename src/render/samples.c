#include "src/render/samples.h"

static bool is_software(const struct ap_gpu *gpu) {
    return gpu->properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
}

// A software device gains nothing from one pass for both eyes, and Mesa 22.3.6's lavapipe puts some
// of the triangles that the picture's edge cuts into the wrong eye (docs/rendering.md).
bool ap_use_multiview(const struct ap_gpu *gpu, const struct ap_renderer_params *params) {
    if (params->no_multiview || (is_software(gpu) && !params->multiview_in_software))
        return false;
    VkPhysicalDeviceMultiviewFeatures has = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MULTIVIEW_FEATURES};
    VkPhysicalDeviceFeatures2 features = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2,
                                          .pNext = &has};
    if (gpu->properties.apiVersion < VK_API_VERSION_1_1)
        return false;
    vkGetPhysicalDeviceFeatures2(gpu->physical_device, &features);
    return has.multiview;
}

static bool has_samples(const struct ap_gpu *gpu, uint32_t n) {
    const VkPhysicalDeviceLimits *limits = &gpu->properties.limits;
    return limits->framebufferColorSampleCounts & limits->framebufferDepthSampleCounts & n;
}

// Discs are blended, in linear light: by an image that is of that.
static bool blends(const struct ap_scene *scene) {
    for (size_t i = 0; i < scene->part_count; i++)
        if (scene->parts[i].kind == AP_PART_BALL && !scene->parts[i].lit &&
            scene->parts[i].carrier != AP_CARRIER_CELL)
            return true;
    return false;
}

enum ap_status ap_choose_samples(struct ap_error *err, const struct ap_gpu *gpu,
                                 const struct ap_scene *scene,
                                 const struct ap_renderer_params *params,
                                 struct ap_samples *samples) {
    uint32_t wanted = params->samples ? params->samples : 4, across = 1;
    // Worlds of cells are many small triangles: there lavapipe is faster at four times the pixels
    // than at four samples of each.
    uint32_t limit = gpu->properties.limits.maxImageDimension2D;
    bool larger = is_software(gpu) && scene->honeycomb && params->samples == 0 &&
                  params->width <= limit / 2 && params->height <= limit / 2;
    if (wanted != 1 && wanted != 4 && wanted != 16 && wanted != 64)
        return ap_fail(err, AP_USAGE, "%u samples a pixel: expected 1, 4, 16 or 64", wanted);
    while (larger ? wanted > 1 : !has_samples(gpu, wanted) && wanted > 4) {
        wanted /= 4;
        across *= 2;
    }
    if (params->width > limit / across || params->height > limit / across)
        return ap_fail(err, AP_USAGE,
                       "pictures of %ux%u with %u samples a pixel are larger than the "
                       "device's %u: ask for fewer samples",
                       params->width, params->height, params->samples, limit);
    *samples =
        (struct ap_samples){.samples = (VkSampleCountFlagBits)wanted,
                            .across = across,
                            .straight = params->samples == 1 && !ap_use_multiview(gpu, params),
                            .coded = larger && !blends(scene)};
    return AP_OK;
}
