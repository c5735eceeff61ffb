#include "tests/sim_hmd/client.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char folder[64];

static void remove_folder(void) {
    char command[128];
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    if (system(command) != 0)
        fprintf(stderr, "cannot remove %s\n", folder);
}

const char *client_folder(void) {
    if (!folder[0]) {
        strcpy(folder, "/tmp/antipode-test-XXXXXX");
        assert_non_null(mkdtemp(folder));
        atexit(remove_folder);
    }
    return folder;
}

const char *client_file(const char *name, const char *text) {
    static char path[256];
    snprintf(path, sizeof path, "%s/%s", client_folder(), name);
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    assert_true(fputs(text, f) >= 0);
    assert_int_equal(fclose(f), 0);
    return path;
}

void client_settings(const char *json) {
    if (json)
        setenv("ANTIPODE_SIM", client_file("settings.json", json), 1);
    else
        unsetenv("ANTIPODE_SIM");
}

static XrInstance last_instance;

int client_teardown(void **state) {
    (void)state;
    if (last_instance)
        xrDestroyInstance(last_instance);
    last_instance = XR_NULL_HANDLE;
    return 0;
}

static const char *extensions[16] = {XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME};
static uint32_t extension_count = 1;

void client_extensions(const char *const *names, uint32_t count) {
    for (extension_count = 1; extension_count <= count && extension_count < 16; extension_count++)
        extensions[extension_count] = names[extension_count - 1];
}

XrResult client_try_instance(XrInstance *instance) {
    XrInstanceCreateInfo info = {
        .type = XR_TYPE_INSTANCE_CREATE_INFO,
        .applicationInfo = {.applicationName = "test", .apiVersion = XR_MAKE_VERSION(1, 0, 0)},
        .enabledExtensionCount = extension_count,
        .enabledExtensionNames = extensions};
    XrResult result = xrCreateInstance(&info, instance);
    last_instance = result == XR_SUCCESS ? *instance : XR_NULL_HANDLE;
    return result;
}

void client_make_instance(struct client *c) {
    XR_OK(client_try_instance(&c->instance));
    XrSystemGetInfo info = {.type = XR_TYPE_SYSTEM_GET_INFO,
                            .formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
    XR_OK(xrGetSystem(c->instance, &info, &c->system));
}

void *client_proc(XrInstance instance, const char *name) {
    PFN_xrVoidFunction f = NULL;
    XR_OK(xrGetInstanceProcAddr(instance, name, &f));
    assert_non_null(f);
    void *p;
    memcpy(&p, &f, sizeof p);
    return p;
}

#define PROC(c, name)                                                                              \
    PFN_##name name;                                                                               \
    *(void **)&name = client_proc((c)->instance, #name)

// The software driver keeps a little memory and is unloaded with the last VkInstance, after which a
// leak checker no longer knows whose it was (lsan.supp). One stays.
static void keep_driver(void) {
    static VkInstance kept;
    VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    if (!kept)
        assert_int_equal(vkCreateInstance(&info, NULL, &kept), VK_SUCCESS);
}

static void make_vk_instance(struct client *c) {
    keep_driver();
    PROC(c, xrGetVulkanGraphicsRequirements2KHR);
    PROC(c, xrCreateVulkanInstanceKHR);
    XrGraphicsRequirementsVulkanKHR needs = {.type = XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN_KHR};
    XR_OK(xrGetVulkanGraphicsRequirements2KHR(c->instance, c->system, &needs));
    assert_true(needs.minApiVersionSupported <= XR_MAKE_VERSION(1, 0, 0));
    VkApplicationInfo app = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                             .apiVersion = VK_API_VERSION_1_1};
    VkInstanceCreateInfo vk = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                               .pApplicationInfo = &app};
    XrVulkanInstanceCreateInfoKHR info = {.type = XR_TYPE_VULKAN_INSTANCE_CREATE_INFO_KHR,
                                          .systemId = c->system,
                                          .pfnGetInstanceProcAddr = vkGetInstanceProcAddr,
                                          .vulkanCreateInfo = &vk};
    VkResult result;
    XR_OK(xrCreateVulkanInstanceKHR(c->instance, &info, &c->vk, &result));
    assert_int_equal(result, VK_SUCCESS);
}

void client_make_device(struct client *c) {
    make_vk_instance(c);
    PROC(c, xrGetVulkanGraphicsDevice2KHR);
    PROC(c, xrCreateVulkanDeviceKHR);
    XrVulkanGraphicsDeviceGetInfoKHR get = {.type = XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR,
                                            .systemId = c->system,
                                            .vulkanInstance = c->vk};
    XR_OK(xrGetVulkanGraphicsDevice2KHR(c->instance, &get, &c->physical));
    float priority = 1;
    VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                     .queueCount = 1,
                                     .pQueuePriorities = &priority};
    VkDeviceCreateInfo vk = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                             .queueCreateInfoCount = 1,
                             .pQueueCreateInfos = &queue};
    XrVulkanDeviceCreateInfoKHR info = {.type = XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR,
                                        .systemId = c->system,
                                        .pfnGetInstanceProcAddr = vkGetInstanceProcAddr,
                                        .vulkanPhysicalDevice = c->physical,
                                        .vulkanCreateInfo = &vk};
    VkResult result;
    XR_OK(xrCreateVulkanDeviceKHR(c->instance, &info, &c->device, &result));
    assert_int_equal(result, VK_SUCCESS);
}

XrSessionCreateInfo client_session_info(const struct client *c, XrGraphicsBindingVulkanKHR *b) {
    *b = (XrGraphicsBindingVulkanKHR){.type = XR_TYPE_GRAPHICS_BINDING_VULKAN_KHR,
                                      .instance = c->vk,
                                      .physicalDevice = c->physical,
                                      .device = c->device};
    return (XrSessionCreateInfo){
        .type = XR_TYPE_SESSION_CREATE_INFO, .next = b, .systemId = c->system};
}

static XrSpace make_space(struct client *c, XrReferenceSpaceType type) {
    XrReferenceSpaceCreateInfo info = {.type = XR_TYPE_REFERENCE_SPACE_CREATE_INFO,
                                       .referenceSpaceType = type,
                                       .poseInReferenceSpace.orientation.w = 1};
    XrSpace space;
    XR_OK(xrCreateReferenceSpace(c->session, &info, &space));
    return space;
}

void client_make_session(struct client *c) {
    XrGraphicsBindingVulkanKHR binding;
    XrSessionCreateInfo info = client_session_info(c, &binding);
    XR_OK(xrCreateSession(c->instance, &info, &c->session));
    c->view = make_space(c, XR_REFERENCE_SPACE_TYPE_VIEW);
    c->local = make_space(c, XR_REFERENCE_SPACE_TYPE_LOCAL);
    c->stage = make_space(c, XR_REFERENCE_SPACE_TYPE_STAGE);
}

void client_start(struct client *c) {
    client_make_instance(c);
    client_make_device(c);
    client_make_session(c);
    client_poll(c);
    assert_int_equal(c->state, XR_SESSION_STATE_READY);
    XrSessionBeginInfo begin = {.type = XR_TYPE_SESSION_BEGIN_INFO,
                                .primaryViewConfigurationType =
                                    XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO};
    XR_OK(xrBeginSession(c->session, &begin));
}

void client_stop(struct client *c) {
    if (c->session)
        XR_OK(xrDestroySession(c->session));
    if (c->device)
        vkDestroyDevice(c->device, NULL);
    if (c->vk)
        vkDestroyInstance(c->vk, NULL);
    if (c->instance)
        XR_OK(xrDestroyInstance(c->instance));
    last_instance = XR_NULL_HANDLE;
    *c = (struct client){0};
}

void client_poll(struct client *c) {
    for (;;) {
        XrEventDataBuffer event = {.type = XR_TYPE_EVENT_DATA_BUFFER};
        XrResult result = xrPollEvent(c->instance, &event);
        if (result == XR_EVENT_UNAVAILABLE)
            return;
        XR_OK(result);
        XrEventDataSessionStateChanged changed;
        memcpy(&changed, &event, sizeof changed);
        if (event.type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED)
            c->state = changed.state;
    }
}

XrFrameState client_wait(struct client *c) {
    XrFrameState state = {.type = XR_TYPE_FRAME_STATE};
    XR_OK(xrWaitFrame(c->session, NULL, &state));
    return state;
}

void client_begin(struct client *c) {
    XR_OK(xrBeginFrame(c->session, NULL));
}

void client_end_empty(struct client *c, XrTime time) {
    XrFrameEndInfo info = {.type = XR_TYPE_FRAME_END_INFO,
                           .displayTime = time,
                           .environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE};
    XR_OK(xrEndFrame(c->session, &info));
}

void client_views(const struct client *c, XrSpace space, XrTime time, XrView views[2]) {
    const XrViewLocateInfo info = {.type = XR_TYPE_VIEW_LOCATE_INFO,
                                   .viewConfigurationType =
                                       XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO,
                                   .displayTime = time,
                                   .space = space};
    XrViewState state = {.type = XR_TYPE_VIEW_STATE};
    uint32_t count;
    for (int eye = 0; eye < 2; eye++)
        views[eye] = (XrView){.type = XR_TYPE_VIEW};
    XR_OK(xrLocateViews(c->session, &info, &state, 2, &count, views));
}

XrSwapchainCreateInfo client_colour_info(int64_t format, uint32_t width, uint32_t height) {
    return (XrSwapchainCreateInfo){.type = XR_TYPE_SWAPCHAIN_CREATE_INFO,
                                   .usageFlags = XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT |
                                                 XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT,
                                   .format = format,
                                   .sampleCount = 1,
                                   .width = width,
                                   .height = height,
                                   .faceCount = 1,
                                   .arraySize = 2,
                                   .mipCount = 1};
}
