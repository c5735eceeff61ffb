#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include <cmocka.h>

#include "src/device/live/record.h"
#include "tests/device/live/devices.h"
#include "tests/memory.h"

// Memory that is not there, at the i-th wish for it, for every i of a life with devices: opened,
// plugged in, read, recorded, closed. Nothing breaks and nothing is left over (the leak checker
// looks); a life with memory succeeds afterwards.

static const int64_t MS = 1000000, START_NS = 1000000000;
static char folder[] = "/tmp/antipode-live-alloc.XXXXXX";

static void send_a_few(struct fake_bus *fake, const int *devices) {
    for (int i = 1; i <= 5; i++) {
        fake_set_now(fake, START_NS + i * 10 * MS);
        send_slimevr(fake, devices[0], 0.1, 0);
        send_xreal(fake, devices[1], START_NS + i * 10 * MS, 0.5);
    }
    fake_settle(fake);
}

// How many poses were recorded; −1: it did not come so far.
static int64_t live_a_life(const char *path) {
    static const char *const assign[] = {"cue=A"};
    static const struct ap_live_mount mounts[] = {
        {.serial = "A", .tracker_from_body = {0, 0, 0, 1}}};
    struct ap_recorder *recorder = NULL;
    struct fake_bus *fake = fake_bus_create(START_NS);
    struct ap_live *live = NULL;
    int64_t poses = -1;
    enum ap_status st = ap_recorder_create(NULL, path, START_NS, &recorder);
    struct ap_live_bus way = fake_way(fake);
    if (!st)
        st = ap_live_open(NULL,
                          &(struct ap_live_params){.buses = &way,
                                                   .bus_count = 1,
                                                   .assign = assign,
                                                   .assign_count = 1,
                                                   .mounts = mounts,
                                                   .mount_count = 1,
                                                   .listener = ap_recorder_listener(recorder)},
                          &live);
    if (!st) {
        const int devices[] = {plug_slimevr(fake, "A"), plug_xreal(fake, "B")};
        fake_settle(fake);
        send_a_few(fake, devices);
        st = ap_recorder_write(NULL, recorder, START_NS + 60 * MS);
        fake_unplug(fake, devices[0]);
        fake_settle(fake);
    }
    ap_live_close(live);
    if (!st)
        poses = ap_recorder_counts(recorder).poses;
    if (!st && ap_recorder_finish(NULL, recorder))
        poses = -1;
    ap_recorder_destroy(recorder);
    fake_bus_free(fake);
    return poses;
}

static void test_every_wish(void **state) {
    (void)state;
    static const char *const names[] = {"a.hid", "a.hid.gz", "a.hid.zst"};
    for (int n = 0; n < 3; n++) {
        char path[64];
        snprintf(path, sizeof path, "%s/%s", folder, names[n]);
        long i = 0, without = 0;
        for (; i < 400; i++) {
            memory_refuse(i + 1, false); // the first wish is the fake bus's
            int64_t poses = live_a_life(path);
            bool was_refused = memory_allow() > 0;
            without += was_refused;
            if (!was_refused) {
                assert_int_equal(poses, 10);
                break;
            }
        }
        printf("%s: %ld wishes refused, one in each life\n", names[n], without);
        assert_true(without > 20 && i < 400);
        unlink(path);
    }
    char csv[64];
    snprintf(csv, sizeof csv, "%s/a.csv", folder);
    unlink(csv);
    assert_int_equal(rmdir(folder), 0); // nothing half-written was left
}

int main(void) {
    if (!mkdtemp(folder))
        return 1;
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_every_wish)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
