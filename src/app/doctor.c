#include <glob.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <vulkan/vulkan.h>

#include "src/app/command.h"
#include "src/app/runtime.h"
#include "src/base/file.h"
#include "src/base/json.h"
#include "src/render/logmap/logmap_device.h"
#include "xr/client.h"

static const char help[] =
    "Says what this machine has for antipode and what to do about what is missing: Vulkan devices,\n"
    "how exact the log map is on the one that draws, the OpenXR loader and runtime, the simulated headset, helper programs, permissions of HID\n"
    "devices. Exit status 0 where a session can be run, else 4.";

enum { MAX_DEVICES = 16 };

static void say(const char *mark, const char *what, const char *detail) {
    printf("%-5s %-18s %s\n", mark, what, detail);
}

static const char *device_type(VkPhysicalDeviceType type) {
    switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
        return "discrete GPU";
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
        return "integrated GPU";
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
        return "virtual GPU";
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
        return "software";
    default:
        return "other";
    }
}

static void say_device(VkPhysicalDevice device) {
    VkPhysicalDeviceProperties p;
    vkGetPhysicalDeviceProperties(device, &p);
    VkPhysicalDeviceMultiviewFeatures multiview = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MULTIVIEW_FEATURES};
    VkPhysicalDeviceFeatures2 features = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2,
                                          .pNext = &multiview};
    if (p.apiVersion >= VK_API_VERSION_1_1)
        vkGetPhysicalDeviceFeatures2(device, &features);
    char text[512];
    snprintf(text, sizeof text, "%s (%s), Vulkan %u.%u.%u, %s", p.deviceName,
             device_type(p.deviceType), VK_VERSION_MAJOR(p.apiVersion),
             VK_VERSION_MINOR(p.apiVersion), VK_VERSION_PATCH(p.apiVersion),
             multiview.multiview ? "both eyes in one pass (multiview)"
                                 : "no multiview: two passes, one an eye");
    say("ok", "Vulkan device", text);
}

static bool check_vulkan(void) {
    static const char *const cure =
        "none: install your GPU's driver, or mesa-vulkan-drivers for software rendering";
    VkApplicationInfo app = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                             .apiVersion = VK_API_VERSION_1_1};
    VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                 .pApplicationInfo = &app};
    VkInstance instance;
    if (vkCreateInstance(&info, NULL, &instance) != VK_SUCCESS) {
        say("MISS", "Vulkan device", cure);
        return false;
    }
    VkPhysicalDevice devices[MAX_DEVICES];
    uint32_t count = MAX_DEVICES;
    VkResult r = vkEnumeratePhysicalDevices(instance, &count, devices);
    bool found = (r == VK_SUCCESS || r == VK_INCOMPLETE) && count > 0;
    for (uint32_t i = 0; found && i < count; i++)
        say_device(devices[i]);
    if (!found)
        say("MISS", "Vulkan device", cure);
    vkDestroyInstance(instance, NULL);
    return found;
}

// How far what is seen may be off because of the device's arithmetic: docs/rendering.md.
static void check_logmap(void) {
    enum { POINTS = 30000 };
    static const int CASES[3][2] = {{1, 0}, {1, 1}, {-1, 0}};
    static const double ALLOWED = 4e-7;
    struct ap_error err;
    struct ap_gpu gpu;
    struct ap_logmap_device *device = NULL;
    double worst[3], at, most = 0;
    enum ap_status st = ap_gpu_create_headless(&err, &(struct ap_gpu_headless_params){0}, &gpu);
    if (st) {
        say("MISS", "log map", err.text);
        return;
    }
    st = ap_logmap_device_create(&err, &gpu, POINTS, &device);
    for (int i = 0; !st && i < 3; i++) {
        st = ap_logmap_device_error(&err, device, CASES[i], POINTS, &worst[i], &at);
        most = !st && !isnan(most) && !(worst[i] <= most) ? worst[i] : most;
    }
    char text[512];
    if (st)
        snprintf(text, sizeof text, "not measured: %.400s", err.text);
    else
        snprintf(text, sizeof text,
                 "off by %.2g (s3), %.2g (s3, the long way round), %.2g (h3) at most on %.200s; "
                 "%.1g is allowed%s",
                 worst[0], worst[1], worst[2], gpu.properties.deviceName, ALLOWED,
                 most <= ALLOWED ? "" : ": distances are wrong there, try another driver");
    say(!st && most <= ALLOWED ? "ok" : "note", "log map", text);
    ap_logmap_device_destroy(device);
    ap_gpu_finish(&gpu);
}

// The library_path of a runtime manifest exists, where it is a path.
static bool manifest_works(const char *path, char *why, size_t size) {
    struct ap_error err;
    json_t *root;
    if (ap_json_read(&err, path, &root)) {
        snprintf(why, size, "%.400s", err.text);
        return false;
    }
    const json_t *library = json_object_get(json_object_get(root, "runtime"), "library_path");
    const char *text = json_string_value(library);
    bool good = text != NULL;
    if (!good)
        snprintf(why, size, "%.200s: no runtime/library_path in it", path);
    if (good && strchr(text, '/')) {
        char full[8192];
        const char *slash = strrchr(path, '/');
        int dir = text[0] == '/' || !slash ? 0 : (int)(slash - path) + 1;
        snprintf(full, sizeof full, "%.*s%s", dir, path, text);
        good = ap_file_exists(full);
        if (!good)
            snprintf(why, size, "%.200s points to %.200s, which does not exist", path, full);
    }
    json_decref(root);
    return good;
}

static bool check_active_runtime(void) {
    char text[1024];
    char *path = ap_runtime_configured();
    if (!path) {
        say("ok", "OpenXR runtime",
            "none is configured: the simulated headset stands in (for a real one, start its runtime "
            "or set XR_RUNTIME_JSON)");
        return true;
    }
    bool good = manifest_works(path, text, sizeof text - 128);
    if (good)
        snprintf(text, sizeof text, "%.900s", path);
    else
        strcat(text, ": set XR_RUNTIME_JSON to a runtime's manifest, or unset it");
    say(good ? "ok" : "MISS", "OpenXR runtime", text);
    free(path);
    return good;
}

static bool check_simulated(void) {
    struct ap_error err;
    char *path;
    if (ap_runtime_manifest(&err, &path)) {
        say("MISS", "simulated headset", err.text);
        return false;
    }
    char why[512];
    bool good = manifest_works(path, why, sizeof why);
    say(good ? "ok" : "MISS", "simulated headset", good ? path : why);
    free(path);
    return good;
}

// Opens a session's worth of OpenXR on the runtime that play would use.
static bool check_session(void) {
    struct ap_error err;
    char *configured = ap_runtime_configured();
    enum ap_status st = configured ? AP_OK : ap_runtime_use_simulated(&err, NULL);
    free(configured);
    struct ap_xr *xr = NULL;
    const struct ap_xr_params params = {.application = "antipode doctor"};
    if (!st)
        st = ap_xr_create(&err, &params, &xr);
    if (st) {
        say("MISS", "OpenXR session", err.text);
        return false;
    }
    char text[512];
    struct ap_xr_vulkan vk = ap_xr_vulkan(xr);
    snprintf(text, sizeof text, "%.120s, %.120s, %u x %u an eye%s", ap_xr_runtime_name(xr),
             ap_xr_system_name(xr), vk.width_px, vk.height_px,
             ap_xr_has_stage(xr) ? "" : "; no STAGE: set up the runtime's room");
    say("ok", "OpenXR session", text);
    ap_xr_destroy(xr);
    return true;
}

static bool in_path(const char *program) {
    const char *path = getenv("PATH");
    char full[4096];
    for (const char *d = path ? path : ""; *d;) {
        size_t len = strcspn(d, ":");
        snprintf(full, sizeof full, "%.*s/%s", (int)len, d, program);
        if (access(full, X_OK) == 0)
            return true;
        d += len + (d[len] == ':');
    }
    return false;
}

static void check_hid(void) {
    glob_t nodes;
    char text[512];
    int denied = 0, count = 0;
    if (glob("/dev/hidraw*", 0, NULL, &nodes) == 0) {
        count = (int)nodes.gl_pathc;
        for (size_t i = 0; i < nodes.gl_pathc; i++)
            denied += access(nodes.gl_pathv[i], R_OK | W_OK) != 0;
        globfree(&nodes);
    }
    if (denied > 0)
        snprintf(text, sizeof text,
                 "%d of %d /dev/hidraw* nodes are closed to you: a udev rule with TAG+=\"uaccess\" "
                 "in /etc/udev/rules.d opens them",
                 denied, count);
    else
        snprintf(text, sizeof text, "%d /dev/hidraw* nodes, all open to you", count);
    say(denied ? "note" : "ok", "HID devices", text);
}

static enum ap_status run(struct ap_error *err, int argc, char **argv) {
    const struct ap_usage usage = {.command = "doctor", .operands = "", .text = help};
    int operands;
    bool done;
    enum ap_status st = ap_parse_options(err, &usage, argc, argv, &operands, &done);
    if (st || done)
        return st;
    bool vulkan = check_vulkan();
    if (vulkan)
        check_logmap();
    bool simulated = check_simulated();
    bool active = check_active_runtime();
    bool session = vulkan && active && check_session();
    say(in_path("gnuplot") ? "ok" : "note", "gnuplot",
        in_path("gnuplot") ? "found" : "not found: plots are left out (install gnuplot-nox)");
    check_hid();
    const char *display = getenv("DISPLAY"), *wayland = getenv("WAYLAND_DISPLAY");
    bool has_display = (display && *display) || (wayland && *wayland);
    say(has_display ? "ok" : "note", "display",
        has_display ? "found" : "none: no window, but replay and --no-window work");
    return vulkan && active && session && simulated
               ? AP_OK
               : ap_fail(err, AP_ENVIRONMENT, "no session can be run: see the lines marked MISS");
}

const struct ap_command ap_command_doctor = {"doctor",
                                             "say what this machine has and what is missing", run};
