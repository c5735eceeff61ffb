#include "src/render/logmap/logmap_device.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "shaders/logmap_test.comp.spv.h"
#include "src/geom/map.h"

enum { WAYS = 3, GROUP = 64 }; // GROUP: local_size_x of the shader

struct push {
    int32_t kappa, image, count;
};

struct ap_logmap_device {
    const struct ap_gpu *gpu;
    size_t most;
    struct ap_gpu_buffer points, tangents;
    VkDescriptorSetLayout set_layout;
    VkDescriptorPool pool;
    VkDescriptorSet set;
    VkPipelineLayout layout;
    VkPipeline pipeline[WAYS];
};

static enum ap_status create_set(struct ap_error *err, struct ap_logmap_device *d) {
    VkDevice device = d->gpu->device;
    const VkDescriptorSetLayoutBinding bindings[2] = {
        {0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, NULL},
        {1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, NULL}};
    const VkDescriptorSetLayoutCreateInfo set = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
        .bindingCount = 2,
        .pBindings = bindings};
    const VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 2};
    const VkDescriptorPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                             .maxSets = 1,
                                             .poolSizeCount = 1,
                                             .pPoolSizes = &size};
    enum ap_status st = ap_vk_check(
        err, vkCreateDescriptorSetLayout(device, &set, NULL, &d->set_layout), "the set's layout");
    if (!st)
        st = ap_vk_check(err, vkCreateDescriptorPool(device, &pool, NULL, &d->pool), "a pool");
    VkDescriptorSetAllocateInfo allocate = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                            .descriptorPool = d->pool,
                                            .descriptorSetCount = 1,
                                            .pSetLayouts = &d->set_layout};
    if (!st)
        st = ap_vk_check(err, vkAllocateDescriptorSets(device, &allocate, &d->set), "a set");
    const VkDescriptorBufferInfo info[2] = {{d->points.buffer, 0, VK_WHOLE_SIZE},
                                            {d->tangents.buffer, 0, VK_WHOLE_SIZE}};
    const VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                        .dstSet = d->set,
                                        .descriptorCount = 2,
                                        .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                        .pBufferInfo = info};
    if (!st)
        vkUpdateDescriptorSets(device, 1, &write, 0, NULL);
    return st;
}

static enum ap_status create_pipelines(struct ap_error *err, struct ap_logmap_device *d) {
    VkDevice device = d->gpu->device;
    const VkPushConstantRange push = {VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(struct push)};
    const VkPipelineLayoutCreateInfo layout = {.sType =
                                                   VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                               .setLayoutCount = 1,
                                               .pSetLayouts = &d->set_layout,
                                               .pushConstantRangeCount = 1,
                                               .pPushConstantRanges = &push};
    enum ap_status st = ap_vk_check(err, vkCreatePipelineLayout(device, &layout, NULL, &d->layout),
                                    "a pipeline's layout");
    VkShaderModule module = VK_NULL_HANDLE;
    if (!st)
        st = ap_gpu_shader(err, d->gpu, logmap_test_comp, sizeof logmap_test_comp, &module);
    for (int32_t way = 0; !st && way < WAYS; way++) {
        const VkSpecializationMapEntry entry = {0, 0, sizeof way};
        const VkSpecializationInfo constant = {1, &entry, sizeof way, &way};
        const VkComputePipelineCreateInfo info = {
            .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
            .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                      .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                      .module = module,
                      .pName = "main",
                      .pSpecializationInfo = &constant},
            .layout = d->layout};
        st = ap_vk_check(
            err,
            vkCreateComputePipelines(device, VK_NULL_HANDLE, 1, &info, NULL, &d->pipeline[way]),
            "a compute pipeline");
    }
    vkDestroyShaderModule(device, module, NULL);
    return st;
}

enum ap_status ap_logmap_device_create(struct ap_error *err, const struct ap_gpu *gpu, size_t most,
                                       struct ap_logmap_device **device) {
    struct ap_logmap_device *d = calloc(1, sizeof *d);
    if (!d)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    d->gpu = gpu;
    d->most = most;
    const VkBufferUsageFlags usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    enum ap_status st =
        ap_gpu_buffer_create(err, gpu, most * sizeof(float[4]), usage, true, &d->points);
    if (!st)
        st = ap_gpu_buffer_create(err, gpu, most * sizeof(float[4]), usage, true, &d->tangents);
    if (!st)
        st = create_set(err, d);
    if (!st)
        st = create_pipelines(err, d);
    if (st)
        ap_logmap_device_destroy(d);
    else
        *device = d;
    return st;
}

void ap_logmap_device_destroy(struct ap_logmap_device *d) {
    if (!d)
        return;
    VkDevice device = d->gpu->device;
    for (int way = 0; way < WAYS; way++)
        vkDestroyPipeline(device, d->pipeline[way], NULL);
    vkDestroyPipelineLayout(device, d->layout, NULL);
    vkDestroyDescriptorPool(device, d->pool, NULL);
    vkDestroyDescriptorSetLayout(device, d->set_layout, NULL);
    ap_gpu_buffer_destroy(d->gpu, &d->points);
    ap_gpu_buffer_destroy(d->gpu, &d->tangents);
    free(d);
}

enum ap_status ap_logmap_device_map(struct ap_error *err, struct ap_logmap_device *d,
                                    enum ap_logmap_way way, const int kappa_image[2],
                                    const float (*p)[4], size_t count, float (*q)[4], int repeats) {
    if (count > d->most)
        return ap_fail(err, AP_USAGE, "%zu points, but there is room for %zu", count, d->most);
    const struct push push = {kappa_image[0], kappa_image[1], (int32_t)count};
    memcpy(d->points.mapped, p, count * sizeof *p);
    VkCommandBuffer cmd = VK_NULL_HANDLE;
    enum ap_status st = ap_gpu_commands_begin(err, d->gpu, &cmd);
    if (st)
        return st;
    vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, d->pipeline[way]);
    vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, d->layout, 0, 1, &d->set, 0, NULL);
    vkCmdPushConstants(cmd, d->layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof push, &push);
    for (int i = 0; i < repeats; i++)
        vkCmdDispatch(cmd, (uint32_t)((count + GROUP - 1) / GROUP), 1, 1);
    VkMemoryBarrier barrier = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                               .srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT,
                               .dstAccessMask = VK_ACCESS_HOST_READ_BIT};
    vkCmdPipelineBarrier(cmd, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0,
                         1, &barrier, 0, NULL, 0, NULL);
    st = ap_gpu_commands_end(err, d->gpu, cmd);
    if (!st)
        memcpy(q, d->tangents.mapped, count * sizeof *q);
    return st;
}

// Distances over rho: a third even, a third near the nose, a third near the antipode or not far.
static double distance_of(int kappa, size_t i, size_t points) {
    const double pi = 3.14159265358979323846, least = 1e-8;
    double u = ((double)i + 0.5) / (double)points, far = kappa > 0 ? pi - 1e-5 : 80;
    if (i % 3 == 0)
        return least + u * (far - least);
    if (i % 3 == 1)
        return least * pow(2 / least, u);
    return kappa > 0 ? pi - 1e-5 * pow(2e5, u) : least + u * 5;
}

// Of the point as float32 holds it; the length of the tangent vector over rho.
static double exact_factor(int kappa, int image, const float p[4]) {
    double r = sqrt((double)p[0] * p[0] + (double)p[1] * p[1] + (double)p[2] * p[2]);
    double theta = kappa > 0 ? atan2(r, p[3]) : kappa < 0 ? asinh(r) : r;
    return (image ? theta - 2 * 3.14159265358979323846 : theta) / r;
}

enum ap_status ap_logmap_device_error(struct ap_error *err, struct ap_logmap_device *d,
                                      const int kappa_image[2], size_t points, double *worst,
                                      double *at) {
    float(*p)[4] = calloc(points, sizeof *p), (*q)[4] = calloc(points, sizeof *q);
    enum ap_status st = p && q ? AP_OK : ap_fail(err, AP_ENVIRONMENT, "out of memory");
    const struct ap_space space = {kappa_image[0], 1};
    for (size_t i = 0; !st && i < points; i++) {
        double t = distance_of(space.kappa, i, points), turn = 2.4 * (double)i,
               up = 2 * fmod(0.618 * (double)i, 1) - 1, flat = sqrt(1 - up * up);
        struct ap_vec4 x =
            ap_exp(space, (struct ap_vec3){t * flat * cos(turn), t * up, t * flat * sin(turn)});
        const double all[4] = {x.x, x.y, x.z, x.w};
        for (int k = 0; k < 4; k++)
            p[i][k] = (float)all[k];
    }
    if (!st)
        st = ap_logmap_device_map(err, d, AP_LOGMAP_POLYNOMIAL, kappa_image, (const float(*)[4])p,
                                  points, q, 1);
    double most = 0, where = 0;
    for (size_t i = 0; !st && i < points; i++) {
        double f = exact_factor(space.kappa, kappa_image[1], p[i]), off = 0, all = 0;
        for (int k = 0; k < 3; k++) {
            off += pow(q[i][k] - f * p[i][k], 2);
            all += pow(f * p[i][k], 2);
        }
        double e = sqrt(off / all);
        if (!isnan(most) && !(e <= most)) {
            most = e;
            where = distance_of(space.kappa, i, points);
        }
    }
    free(p);
    free(q);
    if (!st) {
        *worst = most;
        *at = where;
    }
    return st;
}
