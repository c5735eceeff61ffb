#include "sim_hmd/capture/depth.h"

#include <string.h>

size_t sim_depth_texel_bytes(VkFormat format) {
    return format == VK_FORMAT_D16_UNORM ? 2 : 4;
}

static double depth_at(const uint8_t *texel, VkFormat format) {
    uint16_t short_value;
    uint32_t value;
    float real;
    switch (format) {
    case VK_FORMAT_D16_UNORM:
        memcpy(&short_value, texel, sizeof short_value);
        return short_value / 65535.0;
    case VK_FORMAT_D24_UNORM_S8_UINT: // the upper eight bits are not defined
        memcpy(&value, texel, sizeof value);
        return (value & 0xffffff) / 16777215.0;
    default:
        memcpy(&real, texel, sizeof real);
        return (double)real;
    }
}

void sim_depth_values(const void *texels, VkFormat format, size_t count, float min, float max,
                      uint16_t *values) {
    const uint8_t *at = texels;
    size_t bytes = sim_depth_texel_bytes(format);
    for (size_t k = 0; k < count; k++, at += bytes) {
        double v = (depth_at(at, format) - (double)min) / ((double)max - (double)min);
        values[k] = v >= 1 ? 65535 : v > 0 ? (uint16_t)(v * 65535 + 0.5) : 0; // NaN: 0
    }
}
