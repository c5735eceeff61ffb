#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "src/app/command.h"
#include "src/app/logs.h"
#include "src/app/room.h"
#include "src/app/runtime.h"
#include "src/base/clock.h"
#include "src/base/file.h"
#include "src/base/json.h"
#include "src/base/log.h"
#include "src/device/poselog_argument.h"
#include "src/gpu/gpu.h"
#include "src/render/renderer.h"

static const char help[] =
    "The room, live: on the OpenXR runtime that is active on this machine, or, where none is (or\n"
    "with --simulated), in the simulated headset's window. There WASD, Q and E move the head and the\n"
    "mouse turns it; hold 1 or 2 to move the left or right hand instead; left and right mouse button\n"
    "are trigger and squeeze. Y on a left controller switches between native and tourist view, B on a\n"
    "right one shuts an eye, the other, neither. Ctrl-C or closing the window ends it. With a LOG the simulated headset\n"
    "replays it in real time instead of listening to the keys.\n" AP_LOG_HELP;

static volatile sig_atomic_t end_asked;

static void on_signal(int sig) {
    (void)sig;
    end_asked = 1;
}

struct play {
    struct ap_room room;
    struct ap_xr *xr;
    struct ap_gpu gpu;
    struct ap_renderer *renderer;
    uint32_t width, height;
    struct ap_frame_input input;
    bool head_known;
    bool was_down[2]; // the switches of the left and the right hand
    int64_t frames, drawn;
};

struct play_options {
    struct ap_room_options room;
    const char *headset;
    bool simulated, no_window, older_vulkan, stats;
    double seconds;
};

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
static char *choose_headset(const char *asked) {
    if (asked) {
        char *real = realpath(asked, NULL);
        return real ? real : strdup(asked);
    }
    char *small = vulkan_is_software() ? ap_shared_path("headsets/ci.json") : NULL;
    if (small)
        ap_log(AP_LOG_INFO, "Vulkan runs in software here: the small ci headset (--headset FILE "
                            "chooses another)");
    return small;
}

// A temporary settings file; the runtime reads it once, when the instance is made.
static enum ap_status write_settings(struct ap_error *err, const struct play_options *o,
                                     char **logs, int log_count, char path[64]) {
    json_t *sources = json_array();
    for (int i = 0; i < log_count; i++) {
        // Relative paths in the settings are relative to the settings file.
        char *here = getcwd(NULL, 0), *whole = here ? ap_log_argument_in(logs[i], here) : NULL;
        json_array_append_new(sources, json_string(whole ? whole : logs[i]));
        free(whole);
        free(here);
    }
    json_t *poses = log_count > 0  ? json_pack("{s:O}", "logs", sources)
                    : o->no_window ? json_pack("{s:s}", "script", "walk")
                                   : json_pack("{s:b}", "window", 1);
    json_t *root =
        json_pack("{s:s, s:o, s:b}", "clock", "real", "poses", poses, "window", !o->no_window);
    json_decref(sources);
    char *headset = choose_headset(o->headset);
    if (root && headset)
        json_object_set_new(root, "headset", json_string(headset));
    free(headset);
    char *text = root ? json_dumps(root, 0) : NULL;
    json_decref(root);
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

static void place(enum ap_status *st, struct ap_error *err, struct play *play, const char *device,
                  const struct ap_xr_located *located, bool *has_row, struct ap_iso *iso) {
    *has_row = false;
    if (!*st && located->valid)
        *st = ap_tracker_feed(err, play->room.tracker, device, located->pose, has_row, iso);
}

static const char *const hand_names[2] = {"left", "right"};

static void place_head(enum ap_status *st, struct ap_error *err, struct play *play,
                       const struct ap_xr_frame *frame) {
    bool head = false;
    place(st, err, play, "head", &frame->head, &head, &play->input.viewer.world_from_nose);
    play->head_known |= head;
}

static enum ap_status draw(struct ap_error *err, struct play *play,
                           const struct ap_xr_frame *frame) {
    struct ap_xr_images images;
    enum ap_status st = ap_xr_acquire(err, play->xr, &images);
    if (st)
        return st;
    play->input.viewer = ap_room_viewer(&play->room, play->input.viewer.world_from_nose,
                                        frame->view, play->width, play->height);
    play->input.closed_eyes = play->room.closed_eyes;
    const struct ap_target target = {.image = {images.image[0], images.image[1]},
                                     .layer = {images.layer[0], images.layer[1]}};
    struct ap_frame_stats stats;
    play->drawn++;
    return ap_renderer_draw(err, play->renderer, &play->input, &target, &stats);
}

// The upper button of a hand: the left one's switches the view, the right one's the eyes.
static void take_switches(struct play *play, const struct ap_xr_frame *frame) {
    static const unsigned next_closed[4] = {1, 2, 0, 0}; // both open, then only right, only left
    for (int h = 0; h < 2; h++) {
        bool down = frame->hand[h].secondary, pressed = down && !play->was_down[h];
        play->was_down[h] = down;
        if (pressed && h == 0)
            ap_room_switch_view(&play->room);
        else if (pressed)
            play->room.closed_eyes = next_closed[play->room.closed_eyes & 3];
    }
}

static enum ap_status step(struct ap_error *err, struct play *play) {
    struct ap_xr_frame frame;
    enum ap_status st = ap_xr_begin_frame(err, play->xr, &frame);
    if (st)
        return st;
    // What the others are placed by comes first.
    for (int turn = 0; turn < 2; turn++) {
        if (ap_tracker_leads(play->room.tracker, "head") == !turn)
            place_head(&st, err, play, &frame);
        for (int h = 0; h < 2; h++)
            if (ap_tracker_leads(play->room.tracker, hand_names[h]) == !turn)
                place(&st, err, play, hand_names[h], &frame.hand[h].grip,
                      &play->input.hand_tracked[h], &play->input.world_from_hand[h]);
    }
    take_switches(play, &frame);
    // Until the head has been seen once there is nowhere to look from.
    if (!st && frame.should_render && play->head_known)
        st = draw(err, play, &frame);
    play->frames++;
    return st ? st : ap_xr_end_frame(err, play->xr, &frame);
}

static enum ap_status loop(struct ap_error *err, struct play *play, double seconds) {
    int64_t end = isnan(seconds) ? INT64_MAX : ap_clock_now_ns() + (int64_t)(seconds * 1e9);
    bool asked = false;
    for (;;) {
        enum ap_status st = AP_OK;
        if (!asked && (end_asked || ap_clock_now_ns() >= end)) {
            asked = true;
            st = ap_xr_request_exit(err, play->xr);
        }
        enum ap_xr_state state = AP_XR_WAITING;
        if (!st)
            st = ap_xr_poll(err, play->xr, &state);
        if (st || state == AP_XR_ENDED)
            return st;
        if (state == AP_XR_LOST)
            return ap_fail(err, AP_ENVIRONMENT, "%s: the session was lost",
                           ap_xr_runtime_name(play->xr));
        if (state == AP_XR_WAITING)
            ap_clock_sleep_until_ns(ap_clock_now_ns() + 5000000);
        else
            st = step(err, play);
        if (st)
            return st;
    }
}

static enum ap_status open_play(struct ap_error *err, bool older_vulkan, struct play *play) {
    const struct ap_xr_params params = {.application = "antipode", .older_vulkan = older_vulkan};
    enum ap_status st = ap_xr_create(err, &params, &play->xr);
    if (st)
        return st;
    struct ap_xr_vulkan vk = ap_xr_vulkan(play->xr);
    st = ap_gpu_init(err, vk.instance, vk.physical_device, vk.device, vk.queue_family, 0,
                     &play->gpu);
    if (st)
        return st;
    play->width = vk.width_px;
    play->height = vk.height_px;
    printf("%s, %s, %u x %u an eye\n", ap_xr_runtime_name(play->xr), ap_xr_system_name(play->xr),
           vk.width_px, vk.height_px);
    fflush(stdout);
    if (!ap_xr_has_stage(play->xr))
        ap_log(AP_LOG_WARNING, "the runtime has no STAGE space: set up its room, or the floor and "
                               "the table will not be where they are");
    struct ap_renderer_params render = {.color_format = vk.color_format,
                                        .width = vk.width_px,
                                        .height = vk.height_px,
                                        .no_multiview = !vk.multiview};
    ap_room_renderer_params(&play->room, &render);
    return ap_renderer_create(err, &play->gpu, play->room.scene, &render, &play->renderer);
}

static void close_play(struct play *play) {
    ap_renderer_destroy(play->renderer);
    if (play->gpu.device)
        ap_gpu_finish(&play->gpu);
    ap_xr_destroy(play->xr);
    ap_room_close(&play->room);
}

// The active runtime, or the simulated headset where there is none.
static enum ap_status choose_runtime(struct ap_error *err, const struct play_options *o,
                                     char **logs, int log_count, char settings[64]) {
    char *configured = ap_runtime_configured();
    bool simulate = o->simulated || log_count > 0 || o->headset || !configured;
    free(configured);
    if (!simulate)
        return AP_OK;
    enum ap_status st = write_settings(err, o, logs, log_count, settings);
    return st ? st : ap_runtime_use_simulated(err, settings);
}

static enum ap_status run(struct ap_error *err, int argc, char **argv) {
    struct play_options o = {.room = AP_ROOM_OPTIONS_NONE, .seconds = NAN};
    const struct ap_option options[] = {
        AP_ROOM_OPTION_TABLE(o.room),
        {"headset", AP_OPTION_TEXT, &o.headset, "FILE", "profile of the simulated headset"},
        {"simulated", AP_OPTION_FLAG, &o.simulated, "",
         "the simulated headset, whatever is active"},
        {"no-window", AP_OPTION_FLAG, &o.no_window, "", "no window: poses from the scripted walk"},
        {"older-vulkan", AP_OPTION_FLAG, &o.older_vulkan, "",
         "XR_KHR_vulkan_enable, where the runtime's _enable2 does not work"},
        {"seconds", AP_OPTION_NUMBER, &o.seconds, "S", "end after so long"},
        {"stats", AP_OPTION_FLAG, &o.stats, "", "say at the end how many frames were drawn"},
    };
    const struct ap_usage usage = {.command = "play",
                                   .operands = "[LOG...]",
                                   .text = help,
                                   .options = options,
                                   .option_count = sizeof options / sizeof options[0],
                                   .max_operands = -1};
    int logs;
    bool done;
    enum ap_status st = ap_parse_options(err, &usage, argc, argv, &logs, &done);
    if (st || done)
        return st;
    struct play play = {0};
    char settings[64] = "";
    signal(SIGINT, on_signal);
    signal(SIGTERM, on_signal);
    st = ap_room_open(err, &o.room, &play.room);
    if (!st)
        st = choose_runtime(err, &o, argv + 1, logs, settings);
    int64_t start = ap_clock_now_ns();
    if (!st)
        st = open_play(err, o.older_vulkan, &play);
    if (settings[0])
        unlink(settings);
    if (!st)
        st = loop(err, &play, o.seconds);
    if (!st && o.stats)
        printf("%lld frames in %.2f s, %lld drawn\n", (long long)play.frames,
               (double)(ap_clock_now_ns() - start) * 1e-9, (long long)play.drawn);
    close_play(&play);
    return st;
}

const struct ap_command ap_command_play = {
    "play", "walk about in the room, with a headset or in a window", run};
