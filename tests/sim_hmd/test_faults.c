#include "tests/sim_hmd/client.h"

#include <dirent.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "src/base/file.h"
#include "src/image/image.h"

// Programs that stop where none should, that fork, that are killed, and devices that are lost. The
// runtime is linked into the test (meson.build), so that the device can be lost to it.

enum { SIZE = 256, FRAMES = 8, FORKS = 20 };

// ---- The device, as the runtime sees it

static atomic_bool submits_fail, fences_fail;

VkResult __real_vkQueueSubmit(VkQueue queue, uint32_t n, const VkSubmitInfo *infos, VkFence fence);
VkResult __real_vkQueueWaitIdle(VkQueue queue);
VkResult __real_vkWaitForFences(VkDevice device, uint32_t n, const VkFence *fences, VkBool32 all,
                                uint64_t timeout);
VkResult __wrap_vkQueueSubmit(VkQueue queue, uint32_t n, const VkSubmitInfo *infos, VkFence fence);
VkResult __wrap_vkQueueWaitIdle(VkQueue queue);
VkResult __wrap_vkWaitForFences(VkDevice device, uint32_t n, const VkFence *fences, VkBool32 all,
                                uint64_t timeout);

VkResult __wrap_vkQueueSubmit(VkQueue queue, uint32_t n, const VkSubmitInfo *infos, VkFence fence) {
    return submits_fail ? VK_ERROR_DEVICE_LOST : __real_vkQueueSubmit(queue, n, infos, fence);
}

// The driver beneath works on: it is waited for all the same.
VkResult __wrap_vkQueueWaitIdle(VkQueue queue) {
    VkResult result = __real_vkQueueWaitIdle(queue);
    return submits_fail || fences_fail ? VK_ERROR_DEVICE_LOST : result;
}

VkResult __wrap_vkWaitForFences(VkDevice device, uint32_t n, const VkFence *fences, VkBool32 all,
                                uint64_t timeout) {
    VkResult result = __real_vkWaitForFences(device, n, fences, all, timeout);
    return fences_fail ? VK_ERROR_DEVICE_LOST : result;
}

// ---- A program. Its folder is its own and not client_folder(), which a child's exit removes.

static char folder[64];

static void settings(const char *dir, const char *more) {
    char path[256], json[2048];
    snprintf(path, sizeof path, "%s/settings.json", folder);
    snprintf(json, sizeof json,
             "{\"clock\": \"virtual\", \"capture\": {\"dir\": \"%s/%s\", \"layers\": true%s}, "
             "\"headset\": {\"name\": \"small\", \"refresh_hz\": 90, \"ipd_m\": 0.06, \"eyes\": "
             "{\"left\": {\"resolution_px\": [%d, %d], \"fov_rad\": {\"left\": -0.8, \"right\": "
             "0.8, \"up\": 0.7, \"down\": -0.7}}, \"right\": {\"resolution_px\": [%d, %d], "
             "\"fov_rad\": {\"left\": -0.8, \"right\": 0.8, \"up\": 0.7, \"down\": -0.7}}}}}",
             folder, dir, more, SIZE, SIZE, SIZE, SIZE);
    struct ap_error err;
    assert_int_equal(ap_file_write(&err, path, json, strlen(json)), AP_OK);
    setenv("ANTIPODE_SIM", path, 1);
}

static XrSwapchain make_swapchain(struct client *c) {
    XrSwapchainCreateInfo info = {.type = XR_TYPE_SWAPCHAIN_CREATE_INFO,
                                  .usageFlags = XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT,
                                  .format = VK_FORMAT_R8G8B8A8_SRGB,
                                  .sampleCount = 1,
                                  .width = SIZE,
                                  .height = SIZE,
                                  .faceCount = 1,
                                  .arraySize = 2,
                                  .mipCount = 1};
    XrSwapchain swapchain;
    XR_OK(xrCreateSwapchain(c->session, &info, &swapchain));
    return swapchain;
}

static XrSwapchain start(struct client *c, const char *dir) {
    *c = (struct client){0};
    // Pictures without compression outgrow what is buffered of them.
    settings(dir, strcmp(dir, "forks") == 0 ? ", \"format\": \"raw\"" : "");
    client_start(c);
    return make_swapchain(c);
}

static XrResult acquire(XrSwapchain swapchain) {
    uint32_t index;
    XrSwapchainImageWaitInfo wait = {.type = XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO};
    XrResult result = xrAcquireSwapchainImage(swapchain, NULL, &index);
    return result == XR_SUCCESS ? xrWaitSwapchainImage(swapchain, &wait) : result;
}

static XrResult end(struct client *c, XrSwapchain swapchain, XrTime time) {
    XrView views[2];
    client_views(c, c->stage, time, views);
    XrCompositionLayerProjectionView shown[2];
    for (uint32_t eye = 0; eye < 2; eye++)
        shown[eye] = (XrCompositionLayerProjectionView){
            .type = XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW,
            .pose = views[eye].pose,
            .fov = views[eye].fov,
            .subImage = {swapchain, {{0, 0}, {SIZE, SIZE}}, eye}};
    XrCompositionLayerProjection projection = {.type = XR_TYPE_COMPOSITION_LAYER_PROJECTION,
                                               .space = c->stage,
                                               .viewCount = 2,
                                               .views = shown};
    const XrCompositionLayerBaseHeader *layers[] = {(XrCompositionLayerBaseHeader *)&projection};
    XrFrameEndInfo frame = {.type = XR_TYPE_FRAME_END_INFO,
                            .displayTime = time,
                            .environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE,
                            .layerCount = 1,
                            .layers = layers};
    return xrEndFrame(c->session, &frame);
}

static XrResult try_frame(struct client *c, XrSwapchain swapchain) {
    XrFrameState f = {.type = XR_TYPE_FRAME_STATE};
    XrResult result = xrWaitFrame(c->session, NULL, &f);
    if (result == XR_SUCCESS)
        result = xrBeginFrame(c->session, NULL);
    if (result == XR_SUCCESS)
        result = acquire(swapchain);
    if (result == XR_SUCCESS)
        result = xrReleaseSwapchainImage(swapchain, NULL);
    return result == XR_SUCCESS ? end(c, swapchain, f.predictedDisplayTime) : result;
}

static void end_session(struct client *c) {
    XR_OK(xrRequestExitSession(c->session));
    XR_OK(xrEndSession(c->session));
}

// ---- What is under a final name is whole

static int check_pictures(const char *dir) {
    char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, dir);
    DIR *d = opendir(path);
    assert_non_null(d);
    int pictures = 0;
    for (struct dirent *e; (e = readdir(d));) {
        size_t len = strlen(e->d_name);
        if (len < 4 || strcmp(e->d_name + len - 4, ".png") != 0)
            continue;
        struct ap_error err;
        struct ap_image image = {0};
        snprintf(path, sizeof path, "%s/%s/%s", folder, dir, e->d_name);
        if (ap_png_read(&err, path, &image))
            fail_msg("%s", err.text);
        assert_int_equal(image.width, SIZE);
        ap_image_finish(&image);
        pictures++;
    }
    closedir(d);
    return pictures;
}

// Pictures without compression, all of one size.
static int check_sizes(const char *dir) {
    char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, dir);
    DIR *d = opendir(path);
    assert_non_null(d);
    int pictures = 0;
    for (struct dirent *e; (e = readdir(d));) {
        struct stat file;
        size_t len = strlen(e->d_name);
        if (len < 4 || strcmp(e->d_name + len - 4, ".pam") != 0)
            continue;
        snprintf(path, sizeof path, "%s/%s/%s", folder, dir, e->d_name);
        assert_int_equal(stat(path, &file), 0);
        if (file.st_size < 4 * SIZE * SIZE || file.st_size > 4 * SIZE * SIZE + 200)
            fail_msg("%s: %lld bytes", path, (long long)file.st_size);
        pictures++;
    }
    closedir(d);
    return pictures;
}

static int count_lines(const char *dir, const char *name) {
    char path[512];
    snprintf(path, sizeof path, "%s/%s/%s", folder, dir, name);
    struct ap_error err;
    char *bytes;
    size_t len;
    if (ap_file_read(&err, path, 1 << 24, &bytes, &len))
        fail_msg("%s", err.text);
    int lines = 0;
    for (size_t k = 0; k < len; k++)
        lines += bytes[k] == '\n';
    free(bytes);
    return lines;
}

// ---- The programs

// A leak checker cannot stop a parent's threads to look for a child's leaks.
int __lsan_is_turned_off(void);
static pid_t parent;

int __lsan_is_turned_off(void) {
    return getpid() != parent;
}

static void a_killed_program_leaves_whole_pictures(void **state) {
    (void)state;
    pid_t child = fork();
    if (child == 0) {
        struct client c;
        XrSwapchain swapchain = start(&c, "killed");
        for (int k = 0; k < FRAMES; k++)
            XR_OK(try_frame(&c, swapchain));
        kill(getpid(), SIGKILL); // while the last ones are being written
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
    int pictures = check_pictures("killed");
    print_message("%d of %d pictures\n", pictures, 4 * FRAMES);
    assert_true(pictures > 0);
}

static void frames_that_never_end(void **state) {
    (void)state;
    struct client c;
    XrSwapchain swapchain = start(&c, "never");
    XrFrameState f = client_wait(&c);
    client_begin(&c);
    for (int k = 0; k < 100; k++) {
        f = client_wait(&c);
        XR_IS(XR_FRAME_DISCARDED, xrBeginFrame(c.session, NULL));
    }
    XR_OK(acquire(swapchain));
    XR_OK(xrReleaseSwapchainImage(swapchain, NULL));
    XR_OK(end(&c, swapchain, f.predictedDisplayTime));
    XR_IS(XR_ERROR_CALL_ORDER_INVALID, end(&c, swapchain, f.predictedDisplayTime));
    XR_OK(try_frame(&c, swapchain));
    end_session(&c);
    client_stop(&c);
    assert_int_equal(check_pictures("never"), 8);
}

static void destroyed_in_mid_frame(void **state) {
    (void)state;
    for (int whole = 0; whole < 2; whole++) {
        struct client c;
        XrSwapchain swapchain = start(&c, whole ? "instance" : "session");
        for (int k = 0; k < 3; k++)
            XR_OK(try_frame(&c, swapchain));
        client_wait(&c);
        client_begin(&c);
        XR_OK(acquire(swapchain));
        if (whole) {
            XR_OK(xrDestroyInstance(c.instance));
            c.instance = XR_NULL_HANDLE;
        } else {
            XR_OK(xrDestroySession(c.session));
        }
        XR_IS(XR_ERROR_HANDLE_INVALID, xrReleaseSwapchainImage(swapchain, NULL));
        XR_IS(XR_ERROR_HANDLE_INVALID, xrEndFrame(c.session, NULL));
        c.session = XR_NULL_HANDLE;
        if (!whole) // another one, on the same device
            client_make_session(&c);
        client_stop(&c);
        assert_int_equal(check_pictures(whole ? "instance" : "session"), 12);
    }
}

// A file that may grow no longer ends the session and not the program, whose signals are as they
// were.
static void files_no_longer_than_allowed(void **state) {
    (void)state;
    struct client c;
    XrSwapchain swapchain = start(&c, "limit");
    struct rlimit old, small;
    getrlimit(RLIMIT_FSIZE, &old);
    small = old;
    small.rlim_cur = 6000; // a few lines of the log; a picture of one colour is smaller
    setrlimit(RLIMIT_FSIZE, &small);
    XrResult result = XR_SUCCESS;
    for (int k = 0; k < 100 && result == XR_SUCCESS; k++)
        result = try_frame(&c, swapchain);
    setrlimit(RLIMIT_FSIZE, &old);
    XR_IS(XR_ERROR_SESSION_LOST, result);
    client_stop(&c);
    check_pictures("limit");
}

// What a child does that was not made to be a program of its own: cleans up and leaves.
static void live_as_child(struct client *c, XrSwapchain swapchain) {
    alarm(20);
    bool right = xrEndFrame(c->session, NULL) == XR_ERROR_HANDLE_INVALID;
    right &= xrDestroySwapchain(swapchain) == XR_ERROR_HANDLE_INVALID;
    right &= xrDestroySession(c->session) == XR_ERROR_HANDLE_INVALID;
    right &= xrDestroyInstance(c->instance) == XR_ERROR_HANDLE_INVALID;
    unsetenv("ANTIPODE_SIM");
    XrInstance own;
    right &= client_try_instance(&own) == XR_SUCCESS && xrDestroyInstance(own) == XR_SUCCESS;
    exit(right ? 0 : 1); // not _exit: what is buffered is written
}

static void a_forks_child_does_no_harm(void **state) {
    (void)state;
#ifdef __SANITIZE_THREAD__
    print_message("not under ThreadSanitizer: the software driver joins its threads at exit, and "
                  "there a child waits forever for its parent's\n");
    skip();
#endif
    struct client c;
    XrSwapchain swapchain = start(&c, "forks");
    for (int k = 0; k < FORKS; k++) {
        XR_OK(try_frame(&c, swapchain));
        nanosleep(&(struct timespec){.tv_nsec = k * 100000}, NULL);
        pid_t child = fork();
        if (child == 0)
            live_as_child(&c, swapchain);
        int status;
        assert_int_equal(waitpid(child, &status, 0), child);
        if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
            fail_msg("frame %d: the child's status is 0x%x", k, (unsigned)status);
    }
    end_session(&c);
    client_stop(&c);
    assert_int_equal(check_sizes("forks"), 4 * FORKS);
    assert_int_equal(count_lines("forks", "frames.jsonl"), FORKS);
}

// The device is lost at the first use of a swapchain, at a frame's end, and to the writers.
static void a_lost_device_is_a_lost_session(void **state) {
    (void)state;
    for (int when = 0; when < 3; when++) {
        char name[16], path[128];
        snprintf(name, sizeof name, "lost%d", when);
        struct client c;
        XrSwapchain swapchain = start(&c, name);
        if (when)
            XR_OK(try_frame(&c, swapchain));
        snprintf(path, sizeof path, "%s/said", folder);
        int old = dup(STDERR_FILENO);
        assert_non_null(freopen(path, "w", stderr));
        submits_fail = when < 2;
        fences_fail = when == 2;
        XrResult result = XR_SUCCESS;
        for (int k = 0; k < 50 && result == XR_SUCCESS; k++)
            result = try_frame(&c, swapchain);
        XrResult again = try_frame(&c, swapchain), ended = xrEndSession(c.session);
        client_poll(&c);
        XrSessionState last = c.state;
        client_stop(&c);
        submits_fail = fences_fail = false;
        fflush(stderr);
        dup2(old, STDERR_FILENO);
        close(old);
        XR_IS(XR_ERROR_SESSION_LOST, result);
        XR_IS(XR_ERROR_SESSION_LOST, again);
        XR_IS(XR_ERROR_SESSION_LOST, ended);
        assert_int_equal(last, XR_SESSION_STATE_LOSS_PENDING);
        assert_int_equal(count_lines("", "said"), 1);
        check_pictures(name);
    }
    struct client c; // and life goes on
    XrSwapchain swapchain = start(&c, "found");
    XR_OK(try_frame(&c, swapchain));
    end_session(&c);
    client_stop(&c);
    assert_int_equal(check_pictures("found"), 4);
}

int main(void) {
    parent = getpid();
    strcpy(folder, "/tmp/antipode-test-XXXXXX");
    if (!mkdtemp(folder))
        return 1;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_killed_program_leaves_whole_pictures), // first: it forks
        cmocka_unit_test_teardown(frames_that_never_end, client_teardown),
        cmocka_unit_test_teardown(destroyed_in_mid_frame, client_teardown),
        cmocka_unit_test_teardown(files_no_longer_than_allowed, client_teardown),
        cmocka_unit_test_teardown(a_forks_child_does_no_harm, client_teardown),
        cmocka_unit_test_teardown(a_lost_device_is_a_lost_session, client_teardown),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    char command[128];
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command) != 0 || failed;
}
