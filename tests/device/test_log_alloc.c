#include <jansson.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "src/device/handlog.h"
#include "src/device/inputlog.h"
#include "src/device/poselog.h"
#include "src/device/timeline.h"
#include "tests/device/memory_file.h"
#include "tests/device/log_seeds.h"
#include "tests/memory.h"

// Memory that is not there, at every wish for it in the life of a log of each format: opening,
// reading, closing. Either there is an error with a sentence, or everything was read; never less
// than everything without a word, and nothing is left over (the leak checker looks). Drivers wish
// for none: their state is the log's.

static const char csv[] = "t_ns,device,px,py,pz,qx,qy,qz,qw\n0,head,1,2,3,0,0,0,1\n"
                          "5,left,1,2,3,0,0,0,1\n";
static const char named[] = "t_ms,hmd_pos_x,hmd_pos_y,hmd_pos_z,hmd_rot_x,hmd_rot_y,hmd_rot_z,"
                            "hmd_rot_w\n1,1,2,3,0,0,0,1\n2,1,2,3,0,0,0,1\n";
static const char imu[] = "1,0,0,0,0,9,0\n2000000,0,0,0,0,9,0\n4000000,0,0,0,0,9,0\n"
                          "6000000,0,0,0,0,9,0\n8000000,0,0,0,0,9,0\n9000000,0,0,0,0,9,0\n"
                          "10000000,0,0,0,0,9,0\n11000000,0,0,0,0,9,0\n12000000,0,0,0,0,9,0\n"
                          "13000000,0,0,0,0,9,0\n";
static const char hid[] =
    "# F: 2 01 1f\nD: 0\nR: 12 05 20 0a 83 04 75 10 95 04 81 02 00\nN: a b\nI: 5 054c 0df0\n"
    "E: 000000.000000 8 00 00 00 00 00 00 ff 7f\nE: 000000.010000 8 00 00 00 00 82 5a 82 5a\n"
    "D: 1\nI: 3 1209 7690\nE: 000000.010000 32 ff 00 01 00 00 ee ff c0 00 00 00 00 00 00 00 00 "
    "01 00 00 00 00 00 82 5a 82 5a 00 00 00 00 00 00\n";
static const char iwer[] =
    "{\"schema\":[[0,{\"handedness\":\"left\",\"hasGrip\":true,\"hasGamepad\":true,"
    "\"numButtons\":1,\"numAxes\":0}]],\"frames\":[[5,1,2,3,0,0,0,1,[0,1,2,3,0,0,0,1,"
    "[1,2,3,0,0,0,1],[[1,1,1]]]],[16.1,1,2,3,0,0,0,1]]}";
static const char aframe[] =
    "{\"camera\":{\"poses\":[{\"position\":{\"x\":1,\"y\":2,\"z\":3},\"rotation\":{\"x\":1,"
    "\"y\":2,\"z\":3},\"timestamp\":5}]}}";

static const struct log {
    const char *name, *bytes;
    size_t len;
} logs[] = {
    {"csv", csv, sizeof csv - 1},
    {"named", named, sizeof named - 1},
    {"imu", imu, sizeof imu - 1},
    {"hid", hid, sizeof hid - 1},
    {"iwer", iwer, sizeof iwer - 1},
    {"aframe", aframe, sizeof aframe - 1},
    {"bsor", bsor, sizeof bsor - 1},
    {"gzip", gzipped, sizeof gzipped - 1},
    {"zstd", zstandard, sizeof zstandard - 1},
};

static struct ap_error err;

static enum ap_status live(const char *path, int *rows) {
    struct ap_poselog_params params = {.sources = &path, .source_count = 1};
    struct ap_poselog *log = NULL;
    *rows = 0;
    enum ap_status st = ap_poselog_open(&err, &params, &log);
    for (bool got = true; !st && got;) {
        struct ap_sample sample;
        st = ap_poselog_next(&err, log, &sample, &got);
        *rows += !st && got;
    }
    ap_poselog_close(log);
    return st;
}

// Poses by time; in a recording without a head, none.
static enum ap_status live_timeline(const char *path, int *rows) {
    struct ap_poselog_params params = {.sources = &path, .source_count = 1};
    struct ap_poselog *log = NULL;
    struct ap_timeline *timeline = NULL;
    enum ap_status st = ap_poselog_open(&err, &params, &log);
    if (!st)
        st = ap_timeline_load(&err, log, &timeline);
    *rows = st ? 0 : (int)ap_timeline_frame_count(timeline, 90);
    ap_timeline_destroy(timeline);
    ap_poselog_close(log);
    return st;
}

static enum ap_status live_inputs(const char *path, int *rows) {
    struct ap_inputlog *log = NULL;
    enum ap_status st = ap_inputlog_load(&err, &path, 1, &log);
    *rows = st ? 0 : ap_inputlog_channel_count(log);
    ap_inputlog_destroy(log);
    return st;
}

typedef enum ap_status life(const char *path, int *rows);

static void check_life(const struct log *log, life *lead) {
    struct memory_file file = memory_file(log->bytes, log->len);
    int want, rows;
    long before = memory_wishes();
    if (lead(file.path, &want) || want == 0)
        fail_msg("%s: %s", log->name, err.text);
    long all = memory_wishes() - before;
    for (long i = 0; i < all; i++) {
        err.text[0] = 0;
        memory_refuse(i, false);
        enum ap_status st = lead(file.path, &rows);
        if (!memory_allow())
            fail_msg("%s: wish %ld of %ld did not come", log->name, i, all);
        if (st ? !err.text[0] : rows != want)
            fail_msg("%s, wish %ld: status %d '%s', %d rows of %d", log->name, i, st, err.text,
                     rows, want);
    }
    assert_int_equal(lead(file.path, &rows), AP_OK);
    assert_int_equal(rows, want);
    print_message("%s: %ld wishes, each refused once\n", log->name, all);
    close(file.fd);
}

static void test_formats(void **unused) {
    (void)unused;
    for (size_t i = 0; i < sizeof logs / sizeof *logs; i++)
        check_life(&logs[i], live);
}

static void test_timelines(void **unused) {
    (void)unused;
    for (size_t i = 0; i < sizeof logs / sizeof *logs; i++)
        check_life(&logs[i], live_timeline);
}

static void test_inputs(void **unused) {
    (void)unused;
    check_life(&logs[4], live_inputs);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_formats),
                                       cmocka_unit_test(test_timelines),
                                       cmocka_unit_test(test_inputs)};
    json_set_alloc_funcs(malloc, free); // the linker makes it ours
    return cmocka_run_group_tests(tests, NULL, NULL);
}
