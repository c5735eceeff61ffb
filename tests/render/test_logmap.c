// The log map in float32, in C and on the device, against the double reference: every space, from
// next to the nose to next to the antipode and out to 80 rho.
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "shaders/logmap_test.comp.spv.h"
#include "src/geom/map.h"
#include "src/render/logmap_float.h"
#include "tests/render/stage.h"

enum { POINTS = 60000 };
static const double TOLERANCE = 4e-7;

struct push {
    int32_t kappa, image, count;
};

struct samples {
    int kappa, image;
    float p[POINTS][4];      // rounded once, as a vertex is
    double truth[POINTS][3]; // of the rounded point
    double theta[POINTS];
};

// The truth for a rounded point: (x, y, z) alone where it knows the distance better than w does,
// both in s3; what the rounding itself moved is not the map's doing.
static void reference(struct samples *s, int i) {
    const float *p = s->p[i];
    double r = sqrt((double)p[0] * p[0] + (double)p[1] * p[1] + (double)p[2] * p[2]), f = 1;
    if (s->kappa > 0) {
        double theta = atan2(r, p[3]);
        f = (s->image ? theta - 2 * 3.14159265358979323846 : theta) / r;
    } else if (s->kappa < 0) {
        f = asinh(r) / r;
    }
    for (int k = 0; k < 3; k++)
        s->truth[i][k] = f * p[k];
}

static void fill(struct samples *s, int kappa, int image) {
    const double pi = 3.14159265358979323846;
    struct ap_space space = {kappa, 1};
    uint64_t seed = 7;
    s->kappa = kappa;
    s->image = image;
    for (int i = 0; i < POINTS; i++) {
        double u = (i + 0.5) / POINTS, t, v[3];
        for (int k = 0; k < 3; k++) {
            seed = seed * 6364136223846793005u + 1442695040888963407u;
            v[k] = (double)(seed >> 11) / 9007199254740992.0 - 0.5;
        }
        if (i % 3 == 0) // even
            t = u * (kappa > 0 ? pi : 80);
        else if (i % 3 == 1) // close to the nose
            t = exp(log(1e-8) + u * (log(2) - log(1e-8)));
        else // close to the antipode, or far
            t = kappa > 0 ? pi - exp(log(1e-5) + u * (log(2) - log(1e-5))) : u * 5;
        struct ap_vec3 dir = ap_vec3_normalize((struct ap_vec3){v[0], v[1], v[2]});
        struct ap_vec4 p = ap_exp(space, ap_vec3_scale(t, dir));
        s->theta[i] = t;
        s->p[i][0] = (float)p.x;
        s->p[i][1] = (float)p.y;
        s->p[i][2] = (float)p.z;
        s->p[i][3] = (float)p.w;
        reference(s, i);
    }
}

static int judge(const struct samples *s, const char *what, const float (*q)[4]) {
    double worst = 0, at = 0;
    for (int i = 0; i < POINTS; i++) {
        const double *t = s->truth[i];
        double e = sqrt(pow(q[i][0] - t[0], 2) + pow(q[i][1] - t[1], 2) + pow(q[i][2] - t[2], 2)) /
                   sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]);
        if (!(e <= worst)) {
            worst = e;
            at = s->theta[i];
        }
    }
    bool bad = !(worst <= TOLERANCE);
    printf("%s image %d, %s: worst relative error %.3g at theta %.6g (tolerance %.3g)%s\n",
           ap_space_name((struct ap_space){s->kappa, 1}), s->image, what, worst, at, TOLERANCE,
           bad ? "  FAILED" : "");
    return bad;
}

struct device {
    struct ap_gpu gpu;
    int validation_errors;
    struct ap_gpu_buffer buffer;
    VkDescriptorSetLayout set_layout;
    VkDescriptorPool pool;
    VkDescriptorSet set;
    VkPipelineLayout layout;
    VkShaderModule module;
    VkPipeline pipeline;
};

static void vk(VkResult r, const char *what) {
    STAGE_CHECK(ap_vk_check(&stage_error, r, what));
}

static void open_sets(struct device *d) {
    VkDevice device = d->gpu.device;
    VkDescriptorSetLayoutBinding binding = {0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1,
                                            VK_SHADER_STAGE_COMPUTE_BIT, NULL};
    VkDescriptorSetLayoutCreateInfo set = {.sType =
                                               VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                           .bindingCount = 1,
                                           .pBindings = &binding};
    vk(vkCreateDescriptorSetLayout(device, &set, NULL, &d->set_layout), "set layout");
    VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1};
    VkDescriptorPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                       .maxSets = 1,
                                       .poolSizeCount = 1,
                                       .pPoolSizes = &size};
    vk(vkCreateDescriptorPool(device, &pool, NULL, &d->pool), "pool");
    VkDescriptorSetAllocateInfo allocate = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                            .descriptorPool = d->pool,
                                            .descriptorSetCount = 1,
                                            .pSetLayouts = &d->set_layout};
    vk(vkAllocateDescriptorSets(device, &allocate, &d->set), "set");
    VkDescriptorBufferInfo info = {d->buffer.buffer, 0, VK_WHOLE_SIZE};
    VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                  .dstSet = d->set,
                                  .descriptorCount = 1,
                                  .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                  .pBufferInfo = &info};
    vkUpdateDescriptorSets(device, 1, &write, 0, NULL);
}

static bool device_open(struct device *d) {
    struct ap_gpu_headless_params params = {true, &d->validation_errors};
    if (ap_gpu_create_headless(&stage_error, &params, &d->gpu) != AP_OK) {
        printf("skipped on the device: %s\n", stage_error.text);
        return false;
    }
    VkDevice device = d->gpu.device;
    STAGE_CHECK(ap_gpu_buffer_create(&stage_error, &d->gpu, sizeof(float[POINTS][4]),
                                     VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, true, &d->buffer));
    open_sets(d);
    VkPushConstantRange push = {VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(struct push)};
    VkPipelineLayoutCreateInfo layout = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                         .setLayoutCount = 1,
                                         .pSetLayouts = &d->set_layout,
                                         .pushConstantRangeCount = 1,
                                         .pPushConstantRanges = &push};
    vk(vkCreatePipelineLayout(device, &layout, NULL, &d->layout), "pipeline layout");
    STAGE_CHECK(ap_gpu_shader(&stage_error, &d->gpu, logmap_test_comp, sizeof logmap_test_comp,
                              &d->module));
    VkComputePipelineCreateInfo pipeline = {
        .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
        .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                  .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                  .module = d->module,
                  .pName = "main"},
        .layout = d->layout};
    vk(vkCreateComputePipelines(device, VK_NULL_HANDLE, 1, &pipeline, NULL, &d->pipeline),
       "pipeline");
    return true;
}

static void device_close(struct device *d) {
    VkDevice device = d->gpu.device;
    if (!device)
        return;
    vkDestroyPipeline(device, d->pipeline, NULL);
    vkDestroyShaderModule(device, d->module, NULL);
    vkDestroyPipelineLayout(device, d->layout, NULL);
    vkDestroyDescriptorPool(device, d->pool, NULL);
    vkDestroyDescriptorSetLayout(device, d->set_layout, NULL);
    ap_gpu_buffer_destroy(&d->gpu, &d->buffer);
    ap_gpu_finish(&d->gpu);
}

static void device_map(struct device *d, const struct samples *s) {
    VkCommandBuffer cmd = VK_NULL_HANDLE;
    struct push push = {s->kappa, s->image, POINTS};
    memcpy(d->buffer.mapped, s->p, sizeof s->p);
    STAGE_CHECK(ap_gpu_commands_begin(&stage_error, &d->gpu, &cmd));
    vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, d->pipeline);
    vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, d->layout, 0, 1, &d->set, 0, NULL);
    vkCmdPushConstants(cmd, d->layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof push, &push);
    vkCmdDispatch(cmd, (POINTS + 63) / 64, 1, 1);
    VkMemoryBarrier barrier = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                               .srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT,
                               .dstAccessMask = VK_ACCESS_HOST_READ_BIT};
    vkCmdPipelineBarrier(cmd, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0,
                         1, &barrier, 0, NULL, 0, NULL);
    STAGE_CHECK(ap_gpu_commands_end(&stage_error, &d->gpu, cmd));
}

int main(void) {
    static const int CASES[][2] = {{1, 0}, {1, 1}, {0, 0}, {-1, 0}};
    static struct samples samples;
    static float twin[POINTS][4];
    struct device device = {0};
    int failures = 0;
    bool there = device_open(&device);
    for (int c = 0; c < 4; c++) {
        fill(&samples, CASES[c][0], CASES[c][1]);
        for (int i = 0; i < POINTS; i++)
            ap_logmap_float(samples.kappa, samples.image, samples.p[i], twin[i]);
        failures += judge(&samples, "C twin", (const float(*)[4])twin);
        if (!there)
            continue;
        device_map(&device, &samples);
        failures += judge(&samples, device.gpu.properties.deviceName, device.buffer.mapped);
    }
    device_close(&device);
    return failures + device.validation_errors;
}
