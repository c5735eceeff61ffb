#ifndef ANTIPODE_SIM_HMD_WINDOW_SCREEN_H
#define ANTIPODE_SIM_HMD_WINDOW_SCREEN_H

#define GLFW_INCLUDE_VULKAN
#include <GLFW/glfw3.h>

#include "src/gpu/gpu.h"

// In the window's program: puts pictures of one size onto a GLFW window, as large as fits.
enum { SIM_SCREEN_MAX_IMAGES = 8 };
struct sim_screen {
    GLFWwindow *window;
    VkSurfaceKHR surface;
    struct ap_gpu gpu;
    VkSwapchainKHR swapchain; // VK_NULL_HANDLE while the window has no size
    VkSurfaceFormatKHR format;
    VkExtent2D extent;
    VkImage images[SIM_SCREEN_MAX_IMAGES];
    VkSemaphore drawn[SIM_SCREEN_MAX_IMAGES], acquired;
    uint32_t image_count;
    VkFence fence;
    uint32_t width_px, height_px; // of the largest picture
    uint32_t shown_width_px, shown_height_px;
    struct ap_gpu_buffer staging;
    struct ap_gpu_image picture;
};

// The screen is to be closed even after a failure.
enum ap_status sim_screen_open(struct ap_error *err, GLFWwindow *window, uint32_t width_px,
                               uint32_t height_px, struct sim_screen *screen);
void sim_screen_close(struct sim_screen *screen);

// R,G,B,A bytes of a picture of this size, at most the screen's; NULL: black.
enum ap_status sim_screen_draw(struct ap_error *err, struct sim_screen *screen, const void *rgba,
                               uint32_t width_px, uint32_t height_px);

#endif
