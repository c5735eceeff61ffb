#include "tests/device/live/world.h"

// A reader that is away: when what stood in its devices' queues was measured.

// The reader is away for 300 ms; a device with a clock has 63 reports of the beginning queued.
static void test_stall_with_clock(void **state) {
    (void)state;
    struct world w = begin(NULL);
    int d = plug_xreal(w.fake, "X");
    settle(&w);
    int64_t device_ns = 5000000000;
    for (int i = 0; i < 400; i++) {
        step(&w, MS);
        send_xreal(w.fake, d, device_ns += MS, 0.5);
        if (i % 8 == 0)
            settle(&w);
    }
    settle(&w);
    int64_t stalled_ns = w.now_ns;
    fake_hold(w.fake, true);
    for (int i = 0; i < 300; i++) {
        step(&w, MS);
        send_xreal(w.fake, d, device_ns += MS, 0.5);
    }
    assert_int_equal(w.fake->devices[d].dropped, 300 - FAKE_QUEUE);
    fake_hold(w.fake, false);
    settle(&w);
    // What was queued is old, and is dated so; its newest is 237 ms before now.
    struct ap_live_device about = device_at(&w, 0);
    int64_t newest = stalled_ns + FAKE_QUEUE * MS;
    expect_near("newest report, ms", (double)(about.newest_ns - newest) / 1e6, 0, 0.6);
    expect_state(&w, AP_LIVE_HEAD, AP_POSE_LOST);
    step(&w, MS);
    send_xreal(w.fake, d, device_ns += MS, 0.5);
    settle(&w);
    about = device_at(&w, 0);
    expect_near("fresh report, ms", (double)(about.newest_ns - w.now_ns) / 1e6, 0, 0.6);
    assert_int_equal(about.lost, 300 - FAKE_QUEUE);
    end(&w);
}

static void test_stall_without_clock(void **state) {
    (void)state;
    struct world w = begin(NULL);
    int d = plug_slimevr(w.fake, "A");
    settle(&w);
    for (int i = 0; i < 300; i++) {
        step(&w, 2 * MS);
        send_slimevr(w.fake, d, 0, 0);
        settle(&w);
    }
    int64_t stalled_ns = w.now_ns;
    fake_hold(w.fake, true);
    for (int i = 0; i < 250; i++) {
        step(&w, 2 * MS);
        send_slimevr(w.fake, d, 0, 0);
    }
    fake_hold(w.fake, false);
    settle(&w);
    struct ap_live_device about = device_at(&w, 0);
    expect_near("newest report, ms", (double)(about.newest_ns - stalled_ns) / 1e6, FAKE_QUEUE * 2,
                5);
    // A short one: nothing was dropped, and the newest is now.
    for (int i = 0; i < 10; i++) {
        step(&w, 2 * MS);
        send_slimevr(w.fake, d, 0, 0);
    }
    settle(&w);
    about = device_at(&w, 0);
    assert_int_equal(about.newest_ns, w.now_ns);
    end(&w);
}

// A queue that was full before anybody looked: each report has a time of its own, or no recording
// of it could be read.
static int64_t newest_row_ns;
static int rows, rows_restarted;

static void count_row(void *user, const struct ap_live_pose_row *row) {
    (void)user;
    if (row->t_ns <= newest_row_ns)
        fail_msg("row %d at %lld ns, after %lld", rows, (long long)row->t_ns,
                 (long long)newest_row_ns);
    newest_row_ns = row->t_ns;
    rows++;
    rows_restarted += row->restarted;
}

static void test_first_queue(void **state) {
    (void)state;
    rows = rows_restarted = 0;
    newest_row_ns = INT64_MIN;
    struct world w = begin(&(struct ap_live_params){.listener = {.pose = count_row}});
    int d = plug_slimevr(w.fake, "A");
    settle(&w);
    for (int round = 0; round < 3; round++) {
        fake_hold(w.fake, true);
        for (int i = 0; i < FAKE_QUEUE; i++)
            send_slimevr(w.fake, d, 0, 0);
        fake_hold(w.fake, false);
        settle(&w);
    }
    assert_int_equal(rows, 3 * FAKE_QUEUE);
    assert_int_equal(rows_restarted, 0);
    expect_near("newest, ms", (double)(newest_row_ns - w.now_ns) / 1e6, 0, 0.2);
    fake_unplug(w.fake, d);
    settle(&w);
    fake_replug(w.fake, d, NULL);
    settle(&w);
    play_slimevr(&w, d, 3, 0, 0.01);
    assert_int_equal(rows, 3 * FAKE_QUEUE + 3);
    assert_int_equal(rows_restarted, 1);
    end(&w);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_stall_with_clock),
        cmocka_unit_test(test_stall_without_clock),
        cmocka_unit_test(test_first_queue),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
