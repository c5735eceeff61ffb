// The writers' threads, without a GPU.

#include <dirent.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cmocka.h>

#include "sim_hmd/capture/capture.h"
#include "sim_hmd/capture/depth.h"
#include "src/base/file.h"

static char folder[] = "/tmp/antipode-capture-XXXXXX";

struct work {
    struct sim_capture *capture;
    atomic_int runs, running, most;
    int fail_from;
};

static enum ap_status count(struct ap_error *err, void *user, int what) {
    struct work *w = user;
    int now = atomic_fetch_add(&w->running, 1) + 1, most = atomic_load(&w->most);
    while (now > most && !atomic_compare_exchange_weak(&w->most, &most, now))
        ;
    sigset_t blocked;
    pthread_sigmask(SIG_SETMASK, NULL, &blocked);
    enum ap_status st = sigismember(&blocked, SIGINT) && sigismember(&blocked, SIGALRM)
                            ? AP_OK
                            : ap_fail(err, AP_USAGE, "signals are not blocked");
    usleep(500);
    atomic_fetch_add(&w->runs, 1);
    atomic_fetch_sub(&w->running, 1);
    if (what >= w->fail_from)
        return ap_fail(err, AP_ENVIRONMENT, "job %d", what);
    return st;
}

static void every_job_runs(void **state) {
    (void)state;
    enum { JOBS = 200 }; // more than the queue holds
    struct work w = {.fail_from = JOBS};
    assert_int_equal(sim_capture_create(NULL, NULL, 3, &w.capture), AP_OK);
    for (int k = 0; k < JOBS; k++)
        sim_capture_add(w.capture, &(struct sim_capture_job){count, &w, k});
    assert_int_equal(sim_capture_flush(NULL, w.capture), AP_OK);
    assert_int_equal(atomic_load(&w.runs), JOBS);
    if (atomic_load(&w.most) > 3)
        fail_msg("%d jobs at once, expected at most 3", atomic_load(&w.most));
    // Without a drain: destroy runs what still waits.
    for (int k = 0; k < 20; k++)
        sim_capture_add(w.capture, &(struct sim_capture_job){count, &w, k});
    sim_capture_destroy(w.capture);
    assert_int_equal(atomic_load(&w.runs), JOBS + 20);
    sim_capture_destroy(NULL);
}

static void first_error_once(void **state) {
    (void)state;
    struct work w = {.fail_from = 4};
    struct ap_error err = {{0}};
    assert_int_equal(sim_capture_create(NULL, NULL, 1, &w.capture), AP_OK);
    for (int k = 0; k < 8; k++)
        sim_capture_add(w.capture, &(struct sim_capture_job){count, &w, k});
    assert_int_equal(sim_capture_flush(&err, w.capture), AP_ENVIRONMENT);
    assert_string_equal(err.text, "job 4");
    assert_int_equal(sim_capture_error(&err, w.capture), AP_OK);
    sim_capture_destroy(w.capture);
}

static int files(void) {
    DIR *dir = opendir(folder);
    assert_non_null(dir);
    int n = -2;
    while (readdir(dir))
        n++;
    closedir(dir);
    return n;
}

// A file-size limit stands for the full disk.
static void full_disk(void **state) {
    (void)state;
    enum { W = 100, H = 100 };
    static uint8_t bytes[W * H * 4];
    struct sim_capture *c;
    struct ap_error err = {{0}};
    uint32_t seed = 1;
    for (int k = 0; k < W * H * 4; k++) {
        seed = seed * 1664525u + 1013904223u;
        bytes[k] = (uint8_t)(seed >> 24);
    }
    struct ap_pixels pixels = {bytes, W, H, W * 4, false};
    struct sim_settings settings = {.capture_dir = folder};
    assert_int_equal(sim_capture_create(NULL, &settings, 1, &c), AP_OK);
    assert_int_equal(sim_capture_write(&err, c, 12, 0, &pixels), AP_OK);
    assert_int_equal(sim_capture_write(&err, c, 1234567, 1, &pixels), AP_OK);
    assert_int_equal(files(), 2);
    signal(SIGXFSZ, SIG_IGN);
    struct rlimit old, small;
    getrlimit(RLIMIT_FSIZE, &old);
    small = old;
    small.rlim_cur = 9000;
    setrlimit(RLIMIT_FSIZE, &small);
    enum ap_status st = sim_capture_write(&err, c, 13, 1, &pixels);
    setrlimit(RLIMIT_FSIZE, &old);
    assert_int_equal(st, AP_ENVIRONMENT);
    assert_non_null(strstr(err.text, "000013-right.png"));
    assert_int_equal(files(), 2);
    sim_capture_destroy(c);
    char path[300];
    snprintf(path, sizeof path, "%s/000012-left.png", folder);
    assert_int_equal(unlink(path), 0);
    snprintf(path, sizeof path, "%s/1234567-right.png", folder);
    assert_int_equal(unlink(path), 0);
}

static void bad_folder(void **state) {
    (void)state;
    struct sim_capture *c = NULL;
    struct ap_error err = {{0}};
    struct sim_settings settings = {.capture_dir = (char[]){"/dev/null/x"}};
    assert_int_equal(sim_capture_create(&err, &settings, 1, &c), AP_ENVIRONMENT);
    assert_non_null(strstr(err.text, "/dev/null"));
    assert_null(c);
}

// Each format's texels; the bits that D24 leaves undefined do not count.
static void depth_texels(void **state) {
    (void)state;
    static const uint16_t d16[] = {0, 1, 40000, 65535};
    static const uint32_t d24[] = {0xab000000, 0xff7fffff, 0x00ffffff, 256};
    static const float d32[] = {0.5f, -1, 1.0f / 65535, 1.5f};
    uint16_t got[4];
    sim_depth_values(d16, VK_FORMAT_D16_UNORM, 4, 0, 1, got);
    assert_memory_equal(got, d16, sizeof got);
    const uint16_t want24[] = {0, 32767, 65535, 1};
    sim_depth_values(d24, VK_FORMAT_D24_UNORM_S8_UINT, 4, 0, 1, got);
    assert_memory_equal(got, want24, sizeof got);
    const uint16_t want32[] = {32768, 0, 1, 65535};
    sim_depth_values(d32, VK_FORMAT_D32_SFLOAT_S8_UINT, 4, 0, 1, got);
    assert_memory_equal(got, want32, sizeof got);
    const uint16_t half[] = {0, 0, 14465, 65535}; // of 40000/65535 from 1/2 to 1
    sim_depth_values(d16, VK_FORMAT_D16_UNORM, 4, 0.5f, 1, got);
    assert_memory_equal(got, half, sizeof got);
    assert_int_equal(sim_depth_texel_bytes(VK_FORMAT_D16_UNORM), 2);
    assert_int_equal(sim_depth_texel_bytes(VK_FORMAT_D24_UNORM_S8_UINT), 4);
}

int main(void) {
    if (!mkdtemp(folder))
        return 1;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_job_runs), cmocka_unit_test(first_error_once),
        cmocka_unit_test(full_disk),      cmocka_unit_test(bad_folder),
        cmocka_unit_test(depth_texels),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    rmdir(folder);
    return failed;
}
