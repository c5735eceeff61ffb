// The Vulkan helpers on whatever device there is: memory, images, read-back, and silence from the
// validation layer.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <string.h>

#include "src/gpu/gpu.h"

static struct ap_gpu gpu;
static int validation_errors;

static void check(enum ap_status st, const struct ap_error *err) {
    if (st != AP_OK)
        fail_msg("status %d: %s", st, err->text);
}

static void buffers_keep_their_bytes(void **state) {
    (void)state;
    struct ap_error err;
    struct ap_gpu_buffer a, b, c;
    VkBufferUsageFlags usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    check(ap_gpu_buffer_create(&err, &gpu, 4096, usage, true, &a), &err);
    check(ap_gpu_buffer_create(&err, &gpu, 4096, usage, false, &b), &err);
    check(ap_gpu_buffer_create(&err, &gpu, 4096, usage, true, &c), &err);
    assert_null(b.mapped);
    for (int i = 0; i < 4096; i++)
        ((uint8_t *)a.mapped)[i] = (uint8_t)(i * 7 + i / 256);
    memset(c.mapped, 0, 4096);
    VkCommandBuffer cmd;
    VkBufferCopy copy = {0, 0, 4096};
    VkMemoryBarrier barrier = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                               .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
                               .dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT};
    check(ap_gpu_commands_begin(&err, &gpu, &cmd), &err);
    vkCmdCopyBuffer(cmd, a.buffer, b.buffer, 1, &copy);
    vkCmdPipelineBarrier(cmd, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 1,
                         &barrier, 0, NULL, 0, NULL);
    vkCmdCopyBuffer(cmd, b.buffer, c.buffer, 1, &copy);
    check(ap_gpu_commands_end(&err, &gpu, cmd), &err);
    assert_memory_equal(a.mapped, c.mapped, 4096);
    ap_gpu_buffer_destroy(&gpu, &a);
    ap_gpu_buffer_destroy(&gpu, &b);
    ap_gpu_buffer_destroy(&gpu, &c);
}

static void images_clear_and_read_back(void **state) {
    (void)state;
    struct ap_error err;
    struct ap_gpu_image image;
    struct ap_gpu_buffer out;
    VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                              .imageType = VK_IMAGE_TYPE_2D,
                              .format = VK_FORMAT_R8G8B8A8_UNORM,
                              .extent = {16, 8, 1},
                              .mipLevels = 1,
                              .arrayLayers = 2,
                              .samples = VK_SAMPLE_COUNT_1_BIT,
                              .usage = VK_IMAGE_USAGE_TRANSFER_SRC_BIT |
                                       VK_IMAGE_USAGE_TRANSFER_DST_BIT |
                                       VK_IMAGE_USAGE_SAMPLED_BIT};
    check(ap_gpu_image_create(&err, &gpu, &info, VK_IMAGE_VIEW_TYPE_2D_ARRAY,
                              VK_IMAGE_ASPECT_COLOR_BIT, &image),
          &err);
    check(ap_gpu_buffer_create(&err, &gpu, 16 * 8 * 4 * 2, VK_BUFFER_USAGE_TRANSFER_DST_BIT, true,
                               &out),
          &err);
    VkCommandBuffer cmd;
    check(ap_gpu_commands_begin(&err, &gpu, &cmd), &err);
    ap_gpu_barrier(cmd, image.image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    VkClearColorValue color = {.float32 = {1, 0, 0.2f, 1}};
    VkImageSubresourceRange second = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 2};
    vkCmdClearColorImage(cmd, image.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &color, 1,
                         &second);
    ap_gpu_barrier(cmd, image.image, VK_IMAGE_ASPECT_COLOR_BIT,
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    VkBufferImageCopy copy = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 2},
                              .imageExtent = {16, 8, 1}};
    vkCmdCopyImageToBuffer(cmd, image.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, out.buffer, 1,
                           &copy);
    check(ap_gpu_commands_end(&err, &gpu, cmd), &err);
    const uint8_t expected[4] = {255, 0, 51, 255};
    for (int i = 0; i < 16 * 8 * 2; i++)
        assert_memory_equal((uint8_t *)out.mapped + 4 * i, expected, 4);
    ap_gpu_buffer_destroy(&gpu, &out);
    ap_gpu_image_destroy(&gpu, &image);
}

static void results_have_names(void **state) {
    (void)state;
    struct ap_error err;
    assert_string_equal(ap_vk_result_name(VK_ERROR_DEVICE_LOST), "VK_ERROR_DEVICE_LOST");
    assert_int_equal(ap_vk_check(&err, VK_SUCCESS, "x"), AP_OK);
    assert_int_equal(ap_vk_check(&err, VK_ERROR_OUT_OF_HOST_MEMORY, "vkDoIt"), AP_ENVIRONMENT);
    assert_string_equal(err.text, "vkDoIt: VK_ERROR_OUT_OF_HOST_MEMORY");
}

static void destroy_accepts_nothing(void **state) {
    (void)state;
    struct ap_gpu none = {0};
    struct ap_gpu_buffer buffer = {0};
    struct ap_gpu_image image = {0};
    ap_gpu_buffer_destroy(&gpu, &buffer);
    ap_gpu_image_destroy(&gpu, &image);
    ap_gpu_finish(&none);
}

static void validation_is_silent(void **state) {
    (void)state;
    if (validation_errors != 0)
        fail_msg("%d validation errors, expected 0", validation_errors);
}

int main(void) {
    struct ap_error err;
    struct ap_gpu_headless_params params = {true, &validation_errors};
    if (ap_gpu_create_headless(&err, &params, &gpu) != AP_OK) {
        printf("skipped: %s\n", err.text);
        return 77;
    }
    printf("device: %s\n", gpu.properties.deviceName);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(buffers_keep_their_bytes), cmocka_unit_test(images_clear_and_read_back),
        cmocka_unit_test(results_have_names),       cmocka_unit_test(destroy_accepts_nothing),
        cmocka_unit_test(validation_is_silent),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    ap_gpu_finish(&gpu);
    return failed + (validation_errors != 0);
}
