#ifndef ANTIPODE_TESTS_SIM_HMD_CLIENT_H
#define ANTIPODE_TESTS_SIM_HMD_CLIENT_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdbool.h>
#include <time.h>
#include <vulkan/vulkan.h>

#define XR_USE_GRAPHICS_API_VULKAN
#define XR_USE_TIMESPEC
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

// A small OpenXR program as somebody else would write it: through the real loader, on software
// Vulkan. Every call that should succeed is asserted.
struct client {
    XrInstance instance;
    XrSystemId system;
    VkInstance vk;
    VkPhysicalDevice physical;
    VkDevice device;
    uint32_t family;
    XrSession session;
    XrSessionState state;
    XrSpace view, local, stage;
};

// The result's own name in the message.
#define XR_IS(expected, call) assert_int_equal(call, expected)
#define XR_OK(call) XR_IS(XR_SUCCESS, call)

// Writes a file into the test's own folder (made at the first call, removed at exit); the path is
// good until the next call.
const char *client_file(const char *name, const char *text);
const char *client_folder(void);

// ANTIPODE_SIM names a file with this text; NULL: it is not set.
void client_settings(const char *json);

// What instances made from now on enable besides XR_KHR_vulkan_enable2.
void client_extensions(const char *const *names, uint32_t count);

XrResult client_try_instance(XrInstance *instance);
void client_make_instance(struct client *c);
void client_make_device(struct client *c); // by XR_KHR_vulkan_enable2
XrSessionCreateInfo client_session_info(const struct client *c, XrGraphicsBindingVulkanKHR *b);
void client_make_session(struct client *c); // and the three reference spaces
void client_start(struct client *c);        // all of the above, then begins
void client_stop(struct client *c);         // destroys what there is

// After each test: ends the instance that a failed one left, for the loader has one at a time.
int client_teardown(void **state);

// Takes all events; the last state is in c->state.
void client_poll(struct client *c);

XrFrameState client_wait(struct client *c);
void client_begin(struct client *c);
void client_end_empty(struct client *c, XrTime time);
void client_views(const struct client *c, XrSpace space, XrTime time, XrView views[2]);

// Of swapchains with two layers that a program draws or copies into.
XrSwapchainCreateInfo client_colour_info(int64_t format, uint32_t width, uint32_t height);

void *client_proc(XrInstance instance, const char *name);

#endif
