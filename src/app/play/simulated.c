#include "src/app/play/simulated.h"

#include <errno.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <vulkan/vulkan.h>

#include "src/app/logs.h"
#include "src/app/runtime.h"
#include "src/base/log.h"
#include "src/device/log/poselog_argument.h"

// Whether Vulkan here is a program rather than a chip: then a full headset's pictures take too long
// to walk about in.
static bool vulkan_is_software(void) {
    VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    VkInstance instance;
    if (vkCreateInstance(&info, NULL, &instance) != VK_SUCCESS)
        return false;
    VkPhysicalDevice devices[8];
    uint32_t count = 8;
    VkResult r = vkEnumeratePhysicalDevices(instance, &count, devices);
    bool software = r == VK_SUCCESS || r == VK_INCOMPLETE;
    for (uint32_t i = 0; software && i < count; i++) {
        VkPhysicalDeviceProperties properties;
        vkGetPhysicalDeviceProperties(devices[i], &properties);
        software = properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
    }
    vkDestroyInstance(instance, NULL);
    return software;
}

// The profile's absolute path, malloc'ed; NULL: the built-in one.
static char *choose_headset(const struct ap_play_simulated *how) {
    if (how->headset) {
        char *real = realpath(how->headset, NULL);
        return real ? real : strdup(how->headset);
    }
    if (how->window)
        return ap_shared_path("headsets/desktop.json");
    char *small = vulkan_is_software() ? ap_shared_path("headsets/ci.json") : NULL;
    if (small)
        ap_log(AP_LOG_INFO, "Vulkan runs in software here: the small ci headset (--headset FILE "
                            "chooses another)");
    return small;
}

// Relative paths in the settings would be relative to the settings file.
static json_t *absolute(char *const *paths, int count, bool logs) {
    json_t *list = json_array();
    char *here = getcwd(NULL, 0);
    for (int i = 0; i < count; i++) {
        char *whole = !here  ? NULL
                      : logs ? ap_log_argument_in(paths[i], here)
                             : realpath(paths[i], NULL);
        json_array_append_new(list, json_string(whole ? whole : paths[i]));
        free(whole);
    }
    free(here);
    return list;
}

static json_t *poses_of(const struct ap_play_simulated *how) {
    if (how->log_count > 0)
        return json_pack("{s:o}", "logs", absolute(how->logs, how->log_count, true));
    if (how->live)
        return ap_live_options_json(how->live, how->stats);
    if (how->window)
        return json_pack("{s:b}", "window", 1);
    json_t *walk = json_pack("{s:s}", "script", "walk");
    if (walk && !isnan(how->walk_s))
        json_object_set_new(walk, "duration_s", json_real(how->walk_s));
    return walk;
}

static char *settings_text(const struct ap_play_simulated *how) {
    json_t *shown =
        how->window && how->layout ? json_string(how->layout) : json_boolean(how->window);
    json_t *root =
        json_pack("{s:s, s:s, s:o, s:o}", "clock", how->virtual_clock ? "virtual" : "real", "draw",
                  "all", "poses", poses_of(how), "window", shown);
    char *headset = choose_headset(how);
    if (root && headset)
        json_object_set_new(root, "headset", json_string(headset));
    if (root && how->input_count > 0)
        json_object_set_new(root, "inputs", absolute(how->inputs, how->input_count, false));
    free(headset);
    char *text = root ? json_dumps(root, 0) : NULL;
    json_decref(root);
    return text;
}

static enum ap_status write_file(struct ap_error *err, const struct ap_play_simulated *how,
                                 char path[64]) {
    char *text = settings_text(how);
    if (!text)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    snprintf(path, 64, "/tmp/antipode-play-XXXXXX");
    int fd = mkstemp(path);
    FILE *f = fd >= 0 ? fdopen(fd, "w") : NULL;
    bool good = f && fputs(text, f) >= 0;
    good = f && fclose(f) == 0 && good;
    free(text);
    return good ? AP_OK : ap_fail(err, AP_ENVIRONMENT, "%s: %s", path, strerror(errno));
}

enum ap_status ap_play_simulate(struct ap_error *err, const struct ap_play_simulated *how,
                                char path[64]) {
    enum ap_status st = write_file(err, how, path);
    if (!st)
        st = ap_runtime_use_simulated(err, path);
    if (st && path[0])
        unlink(path);
    return st;
}
