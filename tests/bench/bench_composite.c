// What composition costs on this device, against the least that could be asked for: a plain copy of
// the same images, and one full-screen textured draw of the same pixels per layer. Both eyes,
// 1440×1600. CPU time of all threads of the process, for software Vulkan runs on them; every
// contender has its turn in every round, and medians are given.

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "sim_hmd/compose/pass.h"
#include "sim_hmd/compose/plan.h"
#include "sim_hmd/compose/slot.h"
#include "tests/sim_hmd/textured.frag.spv.h"
#include "tests/sim_hmd/textured.vert.spv.h"

enum { WIDTH = 1440, HEIGHT = 1600, IMAGES = 4, MAX_ROUNDS = 1000 };

static struct ap_gpu gpu;
static struct sim_pass pass;
static struct sim_pass_target target[2];
static struct sim_slot slot;
static struct ap_gpu_buffer buffer[2];
static struct ap_gpu_image images[IMAGES][2], cube;
static VkPipeline textured;
static VkCommandPool pool;
static struct sim_settings settings;

static void ok(enum ap_status st, const struct ap_error *err) {
    if (st) {
        printf("%s\n", err->text);
        exit(1);
    }
}

// ---- Things to draw

static struct ap_gpu_image make_image(uint32_t width, uint32_t height, uint32_t layers) {
    struct ap_error err;
    struct ap_gpu_image image;
    VkImageCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
        .flags = layers == 6 ? VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT : 0,
        .imageType = VK_IMAGE_TYPE_2D,
        .format = VK_FORMAT_R8G8B8A8_SRGB,
        .extent = {width, height, 1},
        .mipLevels = 1,
        .arrayLayers = layers,
        .samples = VK_SAMPLE_COUNT_1_BIT,
        .tiling = VK_IMAGE_TILING_OPTIMAL,
        .usage = VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT |
                 VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT};
    ok(ap_gpu_image_create(&err, &gpu, &info,
                           layers == 6 ? VK_IMAGE_VIEW_TYPE_CUBE : VK_IMAGE_VIEW_TYPE_2D,
                           VK_IMAGE_ASPECT_COLOR_BIT, &image),
       &err);
    VkCommandBuffer cmd;
    ok(ap_gpu_commands_begin(&err, &gpu, &cmd), &err);
    ap_gpu_barrier(cmd, image.image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    VkClearColorValue grey = {.float32 = {0.4f, 0.5f, 0.2f, 0.5f}};
    VkImageSubresourceRange all = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, layers};
    vkCmdClearColorImage(cmd, image.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &grey, 1, &all);
    ap_gpu_barrier(cmd, image.image, VK_IMAGE_ASPECT_COLOR_BIT,
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_GENERAL);
    ok(ap_gpu_commands_end(&err, &gpu, cmd), &err);
    return image;
}

static VkShaderModule shader(const uint32_t *words, size_t bytes) {
    struct ap_error err;
    VkShaderModule module;
    ok(ap_gpu_shader(&err, &gpu, words, bytes, &module), &err);
    return module;
}

static void make_textured(void) {
    VkShaderModule vert = shader(textured_vert, sizeof textured_vert);
    VkShaderModule frag = shader(textured_frag, sizeof textured_frag);
    VkPipelineShaderStageCreateInfo stages[2] = {
        {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
         .stage = VK_SHADER_STAGE_VERTEX_BIT,
         .module = vert,
         .pName = "main"},
        {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
         .stage = VK_SHADER_STAGE_FRAGMENT_BIT,
         .module = frag,
         .pName = "main"}};
    VkPipelineVertexInputStateCreateInfo input = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
    VkPipelineInputAssemblyStateCreateInfo assembly = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
        .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
    VkViewport viewport = {0, 0, WIDTH, HEIGHT, 0, 1};
    VkRect2D scissor = {{0, 0}, {WIDTH, HEIGHT}};
    VkPipelineViewportStateCreateInfo view = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
        .viewportCount = 1,
        .pViewports = &viewport,
        .scissorCount = 1,
        .pScissors = &scissor};
    VkPipelineRasterizationStateCreateInfo raster = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO, .lineWidth = 1};
    VkPipelineMultisampleStateCreateInfo samples = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
        .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT};
    VkPipelineColorBlendAttachmentState plain = {.colorWriteMask = 15};
    VkPipelineColorBlendStateCreateInfo blend = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
        .attachmentCount = 1,
        .pAttachments = &plain};
    VkGraphicsPipelineCreateInfo info = {.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                         .stageCount = 2,
                                         .pStages = stages,
                                         .pVertexInputState = &input,
                                         .pInputAssemblyState = &assembly,
                                         .pViewportState = &view,
                                         .pRasterizationState = &raster,
                                         .pMultisampleState = &samples,
                                         .pColorBlendState = &blend,
                                         .layout = pass.layout,
                                         .renderPass = pass.render_pass};
    struct ap_error err;
    ok(ap_vk_check(&err,
                   vkCreateGraphicsPipelines(gpu.device, VK_NULL_HANDLE, 1, &info, NULL, &textured),
                   "vkCreateGraphicsPipelines"),
       &err);
    vkDestroyShaderModule(gpu.device, vert, NULL);
    vkDestroyShaderModule(gpu.device, frag, NULL);
}

static void open_stage(void) {
    struct ap_error err;
    VkCommandPoolCreateInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                    .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                    .queueFamilyIndex = gpu.queue_family};
    ok(ap_vk_check(&err, vkCreateCommandPool(gpu.device, &info, NULL, &pool),
                   "vkCreateCommandPool"),
       &err);
    ok(sim_pass_create(&err, &gpu, &pass), &err);
    ok(sim_slot_create(&err, &gpu, pool, &slot), &err);
    ok(sim_slot_descriptors(&err, &gpu, &pass, &slot), &err);
    make_textured();
    for (int eye = 0; eye < 2; eye++) {
        ok(sim_pass_target_create(&err, &gpu, &pass, WIDTH, HEIGHT, &target[eye]), &err);
        ok(ap_gpu_buffer_create(&err, &gpu, (VkDeviceSize)WIDTH * HEIGHT * 4,
                                VK_BUFFER_USAGE_TRANSFER_DST_BIT, true, &buffer[eye]),
           &err);
        settings.profile.eye[eye] = (struct ap_eye_profile){.width_px = WIDTH, .height_px = HEIGHT};
        for (int k = 0; k < IMAGES; k++)
            images[k][eye] = make_image(WIDTH, HEIGHT, 1);
    }
    cube = make_image(1024, 1024, 6);
}

// ---- Frames

static struct sim_frame frame;

static struct sim_layer *add(enum sim_layer_kind kind, bool blend) {
    struct sim_layer *l = &frame.layer[frame.layer_count++];
    *l = (struct sim_layer){.kind = kind, .blend_alpha = blend};
    for (int eye = 0; eye < 2; eye++)
        l->view[eye] = (struct sim_layer_view){.image = images[frame.layer_count - 1][eye].image,
                                               .format = VK_FORMAT_R8G8B8A8_SRGB,
                                               .width_px = WIDTH,
                                               .height_px = HEIGHT,
                                               .samples = 1,
                                               .rect = {{0, 0}, {WIDTH, HEIGHT}},
                                               .stage_from_view = frame.stage_from_eye[eye],
                                               .fov = frame.fov[eye],
                                               .at_display = kind == SIM_LAYER_PROJECTION};
    return l;
}

// The head has turned by a little since the layer was drawn, and the layer is wider for that.
static void turn(struct sim_layer *l) {
    for (int eye = 0; eye < 2; eye++) {
        l->view[eye].at_display = false;
        l->view[eye].stage_from_view.q =
            ap_quat_mul(l->view[eye].stage_from_view.q,
                        ap_quat_from_axis_angle((struct ap_vec3){0.6, 0.8, 0}, 0.03));
        l->view[eye].fov = (XrFovf){-0.85f, 0.85f, 0.85f, -0.85f};
    }
}

static void clear_frame(void) {
    frame = (struct sim_frame){.capture = true};
    for (int eye = 0; eye < 2; eye++) {
        frame.stage_from_eye[eye] = (struct ap_pose){{0.03 * eye, 1.6, 0}, AP_QUAT_IDENTITY};
        frame.fov[eye] = (XrFovf){-0.8f, 0.7f, 0.75f, -0.75f};
    }
}

static void frame_turned(void) {
    turn(add(SIM_LAYER_PROJECTION, false));
}

static void frame_two(void) {
    turn(add(SIM_LAYER_PROJECTION, false));
    turn(add(SIM_LAYER_PROJECTION, true));
}

static void frame_four(void) {
    frame_two();
    turn(add(SIM_LAYER_PROJECTION, true));
    turn(add(SIM_LAYER_PROJECTION, true));
}

static void frame_hidden(void) {
    frame_four();
    turn(add(SIM_LAYER_PROJECTION, false));
    for (int eye = 0; eye < 2; eye++)
        frame.layer[4].view[eye].image = images[0][eye].image;
}

static void frame_quad(void) {
    struct sim_layer *l = add(SIM_LAYER_QUAD, false);
    l->width_m = l->height_m = 4;
    for (int eye = 0; eye < 2; eye++)
        l->view[eye].stage_from_view.p.z = -1;
}

static void frame_small_quad(void) {
    struct sim_layer *l = add(SIM_LAYER_QUAD, false);
    l->width_m = l->height_m = 0.5;
    for (int eye = 0; eye < 2; eye++)
        l->view[eye].stage_from_view.p.z = -1;
}

static void frame_cylinder(void) {
    struct sim_layer *l = add(SIM_LAYER_CYLINDER, false);
    l->radius_m = 2;
    l->central_rad = 2;
    l->height_radii = 4;
}

static void frame_sphere(void) {
    struct sim_layer *l = add(SIM_LAYER_EQUIRECT, false);
    l->radius_m = 2;
    l->central_rad = 6.2831854;
    l->upper_rad = 1.5707964;
    l->lower_rad = -1.5707964;
}

static void beside(void (*fill)(void)) {
    fill();
    for (int eye = 0; eye < 2; eye++)
        frame.layer[0].view[eye].stage_from_view.p.x += 0.4;
}

static void frame_cylinder_beside(void) {
    beside(frame_cylinder);
}

static void frame_sphere_beside(void) {
    beside(frame_sphere);
}

// One pixel less all around than the image.
static void part(void (*fill)(void)) {
    fill();
    for (int eye = 0; eye < 2; eye++)
        frame.layer[0].view[eye].rect = (XrRect2Di){{1, 1}, {WIDTH - 2, HEIGHT - 2}};
}

static void frame_cylinder_part(void) {
    part(frame_cylinder);
}

static void frame_cylinder_beside_part(void) {
    part(frame_cylinder_beside);
}

static void frame_sphere_part(void) {
    part(frame_sphere);
}

static void frame_sphere_beside_part(void) {
    part(frame_sphere_beside);
}

static void frame_cube(void) {
    struct sim_layer *l = add(SIM_LAYER_CUBE, false);
    for (int eye = 0; eye < 2; eye++) {
        l->view[eye].image = cube.image;
        l->view[eye].width_px = l->view[eye].height_px = 1024;
    }
}

// ---- The contenders

static void begin(void) {
    VkCommandBufferBeginInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    vkBeginCommandBuffer(slot.cmd, &info);
}

static double cpu_ms(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

static double run(void) {
    vkEndCommandBuffer(slot.cmd);
    VkSubmitInfo info = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                         .commandBufferCount = 1,
                         .pCommandBuffers = &slot.cmd};
    vkResetFences(gpu.device, 1, &slot.fence);
    double from = cpu_ms(CLOCK_PROCESS_CPUTIME_ID);
    vkQueueSubmit(gpu.queue, 1, &info, slot.fence);
    vkWaitForFences(gpu.device, 1, &slot.fence, VK_TRUE, UINT64_MAX);
    return cpu_ms(CLOCK_PROCESS_CPUTIME_ID) - from;
}

static void copy(int eye) {
    VkBufferImageCopy region = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                                .imageExtent = {WIDTH, HEIGHT, 1}};
    vkCmdCopyImageToBuffer(slot.cmd, images[0][eye].image, VK_IMAGE_LAYOUT_GENERAL,
                           buffer[eye].buffer, 1, &region);
}

static double plain_copy(void) {
    begin();
    for (int eye = 0; eye < 2; eye++)
        copy(eye);
    return run();
}

static struct sim_plan plan;

// As the compositor does it, without the read-back.
static double compose(void) {
    struct ap_error err;
    sim_plan_make(&settings, &frame, 0, &plan);
    begin();
    for (uint32_t k = 0; k < plan.use_count; k++) {
        plan.uses[k].layout = VK_IMAGE_LAYOUT_GENERAL; // as the images are here
        ap_gpu_barrier(slot.cmd, plan.uses[k].image, VK_IMAGE_ASPECT_COLOR_BIT,
                       VK_IMAGE_LAYOUT_GENERAL, VK_IMAGE_LAYOUT_GENERAL);
    }
    for (int eye = 0; eye < 2; eye++) {
        if (plan.copy[eye]) {
            copy(eye);
            continue;
        }
        for (uint32_t k = 0; k < plan.batch_count[eye]; k++) {
            ok(sim_pass_prepare(&err, &gpu, &pass, &plan.batches[eye][k].key), &err);
            ok(sim_slot_bind(&err, &gpu, &pass, &slot, &plan, eye, k), &err);
        }
        sim_pass_begin(slot.cmd, &pass, &target[eye]);
        for (uint32_t k = 0; k < plan.batch_count[eye]; k++) {
            const struct sim_batch *b = &plan.batches[eye][k];
            VkRect2D all = {{0, 0}, {WIDTH, HEIGHT}};
            sim_pass_draw(slot.cmd, &pass, all, &b->key, b->from_uv, b->to_uv, slot.sets[eye][k]);
        }
        sim_pass_end(slot.cmd);
    }
    for (uint32_t k = 0; k < plan.use_count; k++)
        ap_gpu_barrier(slot.cmd, plan.uses[k].image, VK_IMAGE_ASPECT_COLOR_BIT,
                       VK_IMAGE_LAYOUT_GENERAL, VK_IMAGE_LAYOUT_GENERAL);
    double ms = run();
    sim_slot_recycle(&gpu, &slot);
    return ms;
}

// One image each eye; several would not do, for llvmpipe leaves out what an opaque draw hides.
static double draw_textured(void) {
    struct ap_error err;
    struct sim_frame kept = frame;
    frame.layer_count = 0;
    add(SIM_LAYER_PROJECTION, false);
    sim_plan_make(&settings, &frame, 0, &plan);
    plan.uses[0].layout = plan.uses[1].layout = VK_IMAGE_LAYOUT_GENERAL;
    begin();
    for (int eye = 0; eye < 2; eye++) {
        ok(sim_slot_bind(&err, &gpu, &pass, &slot, &plan, eye, 0), &err);
        sim_pass_begin(slot.cmd, &pass, &target[eye]);
        vkCmdBindPipeline(slot.cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, textured);
        vkCmdBindDescriptorSets(slot.cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, pass.layout, 0, 1,
                                &slot.sets[eye][0], 0, NULL);
        vkCmdDraw(slot.cmd, 3, 1, 0, 0);
        sim_pass_end(slot.cmd);
    }
    double ms = run();
    sim_slot_recycle(&gpu, &slot);
    frame = kept;
    return ms;
}

static int by_size(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, int n) {
    qsort(values, (size_t)n, sizeof *values, by_size);
    return values[n / 2];
}

static const char *only; // contests with this in their names; NULL: all

// layers: with how many times a textured draw it is compared; 0: with a plain copy.
static void contest(const char *name, void (*fill)(void), uint32_t layers, int rounds) {
    static double ours[MAX_ROUNDS], theirs[MAX_ROUNDS], ratio[MAX_ROUNDS];
    if (only && !strstr(name, only))
        return;
    clear_frame();
    fill();
    for (int k = -2; k < rounds; k++) { // two rounds to get warm
        double a = compose(), b = layers ? layers * draw_textured() : plain_copy();
        if (k < 0)
            continue;
        ours[k] = a;
        theirs[k] = b;
        ratio[k] = a / b;
    }
    printf("%-34s %7.2f ms  %-18s %7.2f ms  ratio %.2f\n", name, median(ours, rounds),
           layers ? layers > 1 ? "that many draws" : "a textured draw" : "a plain copy",
           median(theirs, rounds), median(ratio, rounds));
}

static void frame_at_display(void) {
    add(SIM_LAYER_PROJECTION, false);
}

int main(int argc, char **argv) {
    int rounds = argc > 1 ? atoi(argv[1]) : 15;
    only = argc > 2 ? argv[2] : NULL;
    struct ap_error err;
    struct ap_gpu_headless_params params = {0};
    if (rounds < 1 || rounds > MAX_ROUNDS) {
        printf("usage: bench_composite [ROUNDS [WORDS]]\n");
        return 2;
    }
    if (ap_gpu_create_headless(&err, &params, &gpu)) {
        printf("skipped: %s\n", err.text);
        return 77;
    }
    open_stage();
    printf("%s, two eyes of %dx%d, CPU time a frame, medians of %d rounds\n",
           gpu.properties.deviceName, WIDTH, HEIGHT, rounds);
    contest("opaque, at the display's pose", frame_at_display, 0, rounds);
    contest("opaque, turned", frame_turned, 1, rounds);
    contest("two, the upper one blended", frame_two, 2, rounds);
    contest("four, three of them blended", frame_four, 4, rounds);
    contest("five, the last hides the others", frame_hidden, 1, rounds);
    contest("a quad over the whole eye", frame_quad, 1, rounds);
    contest("a quad of half a metre", frame_small_quad, 1, rounds);
    contest("a cylinder about the eye", frame_cylinder, 1, rounds);
    contest("a cylinder beside the eye", frame_cylinder_beside, 1, rounds);
    contest("a whole sphere about the eye", frame_sphere, 1, rounds);
    contest("a whole sphere beside the eye", frame_sphere_beside, 1, rounds);
    contest("part of an image: cylinder about", frame_cylinder_part, 1, rounds);
    contest("part of an image: cylinder beside", frame_cylinder_beside_part, 1, rounds);
    contest("part of an image: sphere about", frame_sphere_part, 1, rounds);
    contest("part of an image: sphere beside", frame_sphere_beside_part, 1, rounds);
    contest("a cube map", frame_cube, 1, rounds);
    vkDeviceWaitIdle(gpu.device);
    return 0; // the process's end frees the rest
}
