#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "src/device/live/live.h"
#include "tests/device/hid/bytes_of.h"
#include "tests/device/live/devices.h"

// Live devices over the fake bus: the test sets the clock, and waits until everybody has done what
// there was to do.

static const int64_t MS = 1000000, START_NS = 1000000000;

struct world {
    struct fake_bus *fake;
    struct ap_live *live;
    int64_t now_ns;
};

static struct world begin(const struct ap_live_params *params) {
    struct world w = {.fake = fake_bus_create(START_NS), .now_ns = START_NS};
    struct ap_live_params p = params ? *params : (struct ap_live_params){0};
    struct ap_live_bus way = fake_way(w.fake);
    p.buses = &way;
    p.bus_count = 1;
    struct ap_error err = {""};
    if (ap_live_open(&err, &p, &w.live))
        fail_msg("%s", err.text);
    return w;
}

static void end(struct world *w) {
    ap_live_close(w->live);
    assert_true(w->fake->destroyed);
    fake_bus_free(w->fake);
}

static void settle(struct world *w) {
    assert_true(fake_settle(w->fake));
}

static void step(struct world *w, int64_t ns) {
    w->now_ns += ns;
    fake_set_now(w->fake, w->now_ns);
}

static struct ap_live_device device_at(struct world *w, int device) {
    static struct ap_live_device d;
    ap_live_device_at(w->live, device, &d);
    return d;
}

static void expect_near(const char *what, double got, double want, double tolerance) {
    if (!(fabs(got - want) <= tolerance))
        fail_msg("%s: %.9g, expected %.9g within %g", what, got, want, tolerance);
}

static void expect_state(struct world *w, int role, enum ap_pose_state want) {
    struct ap_live_answer a = ap_live_at(w->live, role, w->now_ns);
    if (a.state != want)
        fail_msg("%s: state %d, expected %d", ap_live_role_name(w->live, role), (int)a.state,
                 (int)want);
}

// A turning head, 10 ms a report.
static void play_slimevr(struct world *w, int device, int count, double from_rad, double step_rad) {
    for (int i = 0; i < count; i++) {
        step(w, 10 * MS);
        send_slimevr(w->fake, device, from_rad + i * step_rad, 0);
        settle(w);
    }
}

static void test_head(void **state) {
    (void)state;
    struct world w = begin(NULL);
    expect_state(&w, AP_LIVE_HEAD, AP_POSE_NONE);
    int d = plug_slimevr(w.fake, "A1");
    settle(&w);
    play_slimevr(&w, d, 20, 0, 0.02);
    struct ap_live_answer a = ap_live_at(w.live, AP_LIVE_HEAD, w.now_ns);
    assert_int_equal(a.state, AP_POSE_EXACT);
    expect_near("yaw", yaw_of(a.pose.q), 19 * 0.02, 1e-4);
    // The eyes are 8 cm above and before a neck at 1.5 m, turned with the head.
    expect_near("x", a.pose.p.x, -0.08 * sin(0.38), 1e-4);
    expect_near("y", a.pose.p.y, 1.58, 1e-4);
    expect_near("z", a.pose.p.z, -0.08 * cos(0.38), 1e-4);
    // 2 rad/s that fade by e in 0.1 s.
    a = ap_live_at(w.live, AP_LIVE_HEAD, w.now_ns + 20 * MS);
    assert_int_equal(a.state, AP_POSE_PREDICTED);
    expect_near("predicted yaw", yaw_of(a.pose.q), 0.38 + 2 * 0.1 * (1 - exp(-0.2)), 1e-3);
    assert_int_equal(a.age_ns, 20 * MS);
    struct ap_live_device about = device_at(&w, 0);
    assert_int_equal(about.state, AP_LIVE_RUNNING);
    assert_int_equal(about.reports, 20);
    assert_int_equal(about.bad, 0);
    assert_string_equal(about.driver->name, "slimevr");
    assert_string_equal(about.role[0], "head");
    end(&w);
}

static void test_unplug(void **state) {
    (void)state;
    struct world w = begin(NULL);
    int d = plug_slimevr(w.fake, "A1");
    settle(&w);
    play_slimevr(&w, d, 5, 0, 0);
    expect_state(&w, AP_LIVE_HEAD, AP_POSE_EXACT);
    step(&w, 2 * MS);
    send_slimevr(w.fake, d, 0.5, 0); // still in the queue when it goes
    fake_unplug(w.fake, d);
    settle(&w);
    step(&w, MS);
    struct ap_live_answer a = ap_live_at(w.live, AP_LIVE_HEAD, w.now_ns);
    assert_int_equal(a.state, AP_POSE_LOST);
    expect_near("the last report counts", yaw_of(a.pose.q), 0.5, 1e-4);
    assert_int_equal(device_at(&w, 0).state, AP_LIVE_GONE);
    step(&w, 500 * MS);
    fake_replug(w.fake, d, "/dev/hidraw77");
    settle(&w);
    play_slimevr(&w, d, 1, 0.25, 0);
    assert_int_equal(ap_live_device_count(w.live), 1);
    assert_string_equal(device_at(&w, 0).place.path, "/dev/hidraw77");
    a = ap_live_at(w.live, AP_LIVE_HEAD, w.now_ns);
    assert_int_equal(a.state, AP_POSE_EXACT);
    expect_near("yaw again", yaw_of(a.pose.q), 0.25, 1e-4);
    assert_int_equal(device_at(&w, 0).unplugged_count, 1);
    end(&w);
}

// A node that is listed for a moment after its device has gone: it went once.
static void test_slow_unplug(void **state) {
    (void)state;
    struct world w = begin(NULL);
    int d = plug_slimevr(w.fake, "A1");
    settle(&w);
    for (int round = 1; round <= 3; round++) {
        play_slimevr(&w, d, 2, 0.1, 0);
        expect_state(&w, AP_LIVE_HEAD, AP_POSE_EXACT);
        fake_begin_unplug(w.fake, d);
        settle(&w);
        step(&w, MS);
        expect_state(&w, AP_LIVE_HEAD, AP_POSE_LOST);
        assert_int_equal(device_at(&w, 0).state, AP_LIVE_FAILED); // it was tried again
        fake_unplug(w.fake, d);
        settle(&w);
        assert_int_equal(device_at(&w, 0).state, AP_LIVE_GONE);
        assert_int_equal(device_at(&w, 0).unplugged_count, round);
        fake_replug(w.fake, d, NULL);
        settle(&w);
    }
    assert_int_equal(ap_live_device_count(w.live), 1);
    end(&w);
}

// Gone and back, on the same node, before the keeper has looked.
static void test_quick_replug(void **state) {
    (void)state;
    struct world w = begin(NULL);
    int d = plug_slimevr(w.fake, "A1");
    settle(&w);
    for (int i = 0; i < 30; i++) {
        fake_unplug(w.fake, d);
        if (i % 2)
            settle(&w);
        fake_replug(w.fake, d, NULL);
        settle(&w);
        play_slimevr(&w, d, 1, 0.1, 0);
        expect_state(&w, AP_LIVE_HEAD, AP_POSE_EXACT);
    }
    assert_int_equal(ap_live_device_count(w.live), 1);
    end(&w);
}

// A DualSense's report by USB, lying still, and what its place says.
static void send_dualsense(struct world *w, int device, int count) {
    for (int i = 0; i < count; i++) {
        uint8_t bytes[64] = {1, 128, 128, 128, 128};
        put16(bytes + 16 + 8, 8192); // 1 g up
        put16(bytes + 28, i * 12000 & 0xffff);
        bytes[30] = (uint8_t)(i * 12000 >> 16);
        step(w, 4 * MS);
        fake_send(w->fake, device, bytes, sizeof bytes);
        settle(w);
    }
}

static int plug_dualsense(struct world *w, const char *serial, uint16_t bus, int interface) {
    struct ap_live_place place = {
        .bus = bus, .vendor = 0x054c, .product = 0x0ce6, .interface_number = interface};
    snprintf(place.serial, sizeof place.serial, "%s", serial);
    snprintf(place.name, sizeof place.name, "Wireless Controller %u", (unsigned)bus);
    place.descriptor_len =
        bytes_of(XREAL_DESCRIPTOR, strlen(XREAL_DESCRIPTOR), place.descriptor, 64);
    int device = fake_plug_place(w->fake, &place);
    settle(w);
    return device;
}

// Other numbers and names, the same serial (as each way writes it): the same device and role.
static void test_other_transport(void **state) {
    (void)state;
    struct world w = begin(NULL);
    int head = plug_slimevr(w.fake, "A1"), pad = plug_dualsense(&w, "10:18:49:AB:cd:ef", 3, 3);
    play_slimevr(&w, head, 1, 0, 0);
    send_dualsense(&w, pad, 3);
    assert_string_equal(device_at(&w, 1).role[0], "left");
    // USB, another model's number and interface, then Bluetooth's, whose reports are others.
    fake_unplug(w.fake, pad);
    settle(&w);
    step(&w, MS);
    expect_state(&w, AP_LIVE_LEFT, AP_POSE_LOST);
    struct ap_live_place edge = w.fake->devices[pad].place;
    edge.product = 0x0df2;
    edge.interface_number = 1;
    edge.path[0] = '\0';
    memcpy(edge.serial, "101849abcdef", 13);
    pad = fake_plug_place(w.fake, &edge);
    settle(&w);
    send_dualsense(&w, pad, 3);
    expect_state(&w, AP_LIVE_LEFT, AP_POSE_EXACT);
    assert_int_equal(ap_live_device_count(w.live), 2);
    fake_unplug(w.fake, pad);
    settle(&w);
    plug_dualsense(&w, "10:18:49:ab:cd:ef", 5, -1);
    assert_int_equal(ap_live_device_count(w.live), 2);
    assert_int_equal(device_at(&w, 1).place.bus, 5);
    assert_int_equal(device_at(&w, 1).state, AP_LIVE_RUNNING);
    // Another one's number, and a device without any, are others.
    plug_dualsense(&w, "10:18:49:ab:cd:e0", 3, 3);
    assert_int_equal(ap_live_device_count(w.live), 3);
    plug_dualsense(&w, "", 3, 3);
    assert_int_equal(ap_live_device_count(w.live), 4);
    end(&w);
}

// There twice for a while: one role, which goes to the one that stays, and back.
static void test_twice(void **state) {
    (void)state;
    static const char *const position[] = {"right=10:18:49:ab:cd:ef"};
    struct world w = begin(&(struct ap_live_params){.position = position, .position_count = 1});
    int head = plug_slimevr(w.fake, "A1"), pad[2];
    play_slimevr(&w, head, 1, 0, 0);
    for (int i = 0; i < 2; i++) {
        pad[i] = plug_dualsense(&w, "10:18:49:ab:cd:ef", 3, i ? 3 : 1);
        send_dualsense(&w, pad[i], 3);
    }
    assert_int_equal(ap_live_device_count(w.live), 3);
    assert_string_equal(device_at(&w, 1).role[0], "");
    end(&w);
    w = begin(NULL);
    head = plug_slimevr(w.fake, "A1");
    play_slimevr(&w, head, 1, 0, 0);
    for (int i = 0; i < 2; i++) {
        pad[i] = plug_dualsense(&w, "10:18:49:ab:cd:ef", 3, i ? 3 : 1);
        send_dualsense(&w, pad[i], 3);
    }
    for (int round = 0; round < 4; round++) {
        int stays = (round + 1) % 2;
        assert_string_equal(device_at(&w, 1 + !stays).role[0], "left");
        assert_string_equal(device_at(&w, 1 + stays).role[0], "");
        fake_unplug(w.fake, pad[!stays]);
        settle(&w);
        send_dualsense(&w, pad[stays], 3);
        expect_state(&w, AP_LIVE_LEFT, AP_POSE_EXACT);
        assert_string_equal(device_at(&w, 1 + stays).role[0], "left");
        fake_replug(w.fake, pad[!stays], NULL);
        settle(&w);
        send_dualsense(&w, pad[!stays], 3);
    }
    expect_state(&w, AP_LIVE_RIGHT, AP_POSE_NONE);
    assert_int_equal(ap_live_device_count(w.live), 3);
    end(&w);
}

static void test_equal_devices(void **state) {
    (void)state;
    static const char *const assign[] = {"left=B:2", "right=A"};
    struct world w = begin(&(struct ap_live_params){.assign = assign, .assign_count = 2});
    int a = plug_slimevr(w.fake, "A"), b = plug_slimevr(w.fake, "B:2");
    settle(&w);
    play_slimevr(&w, a, 1, 0.1, 0);
    play_slimevr(&w, b, 1, 0.2, 0);
    fake_unplug(w.fake, a);
    fake_unplug(w.fake, b);
    settle(&w);
    // They come back in the other order, each where the other was.
    fake_replug(w.fake, b, "/dev/hidraw0");
    settle(&w);
    fake_replug(w.fake, a, "/dev/hidraw1");
    settle(&w);
    play_slimevr(&w, a, 1, 0.3, 0);
    play_slimevr(&w, b, 1, 0.4, 0);
    struct ap_live_answer right = ap_live_at(w.live, AP_LIVE_RIGHT, w.now_ns);
    struct ap_live_answer left = ap_live_at(w.live, AP_LIVE_LEFT, w.now_ns);
    expect_near("A is right", yaw_of(right.pose.q), 0.3, 1e-4);
    expect_near("B is left", yaw_of(left.pose.q), 0.4, 1e-4);
    expect_state(&w, AP_LIVE_HEAD, AP_POSE_NONE);
    assert_int_equal(ap_live_device_count(w.live), 2);
    end(&w);
}

static void test_garbage(void **state) {
    (void)state;
    struct world w = begin(NULL);
    int good = plug_slimevr(w.fake, "A"), bad = plug_slimevr(w.fake, "B");
    int broken = fake_plug(w.fake, "C", 3, 0x1209, 0x7690, "broken", "05 01 09");
    settle(&w);
    unsigned seed = 1;
    for (int i = 0; i < 50; i++) {
        uint8_t junk[64];
        for (size_t k = 0; k < sizeof junk; k++)
            junk[k] = (uint8_t)((seed = seed * 1103515245 + 12345) >> 16);
        fake_send(w.fake, bad, junk, 1 + seed % 63);
        play_slimevr(&w, good, 1, 0.01 * i, 0);
        expect_state(&w, AP_LIVE_HEAD, AP_POSE_EXACT);
    }
    assert_int_equal(device_at(&w, 0).bad, 0);
    assert_true(device_at(&w, 1).bad > 40);
    assert_int_equal(device_at(&w, broken).state, AP_LIVE_FAILED);
    assert_non_null(strstr(device_at(&w, broken).why, "descriptor"));
    end(&w);
}

static void test_refusals(void **state) {
    (void)state;
    struct world w = begin(NULL);
    pthread_mutex_lock(&w.fake->lock);
    w.fake->devices[0].refuses_open = true;
    pthread_mutex_unlock(&w.fake->lock);
    plug_slimevr(w.fake, "A");
    settle(&w);
    assert_int_equal(device_at(&w, 0).state, AP_LIVE_FAILED);
    assert_non_null(strstr(device_at(&w, 0).why, "/dev/hidraw0"));
    int before = w.fake->devices[0].opened_count;
    step(&w, 10 * MS);
    settle(&w);
    assert_int_equal(w.fake->devices[0].opened_count, before); // not at once again
    pthread_mutex_lock(&w.fake->lock);
    w.fake->devices[0].refuses_open = false;
    pthread_mutex_unlock(&w.fake->lock);
    step(&w, 300 * MS);
    settle(&w);
    assert_int_equal(device_at(&w, 0).state, AP_LIVE_RUNNING);
    struct ap_live_place place = w.fake->devices[0].place;
    place.path[0] = '\0';
    place.denied = true;
    memcpy(place.serial, "D", 2);
    int denied = fake_plug_place(w.fake, &place);
    settle(&w);
    struct ap_live_device about = device_at(&w, denied);
    assert_int_equal(about.state, AP_LIVE_DENIED);
    assert_non_null(strstr(about.why, "70-antipode.rules"));
    assert_non_null(strstr(about.why, "/etc/udev/rules.d"));
    pthread_mutex_lock(&w.fake->lock);
    w.fake->devices[denied].place.denied = false; // udev has come
    pthread_mutex_unlock(&w.fake->lock);
    settle(&w);
    assert_int_equal(device_at(&w, denied).state, AP_LIVE_RUNNING);
    end(&w);
}

// Of 320 trackers 256 get a role; who was promised one gets it though he comes last.
static void test_many(void **state) {
    (void)state;
    enum { MANY = 64, TRACKERS = 5 };
    static const char *const assign[] = {"knee=S63:5"};
    struct world w = begin(&(struct ap_live_params){.assign = assign, .assign_count = 1});
    int d[MANY];
    for (int i = 0; i < MANY; i++) {
        char serial[8];
        snprintf(serial, sizeof serial, "S%d", i);
        d[i] = plug_slimevr(w.fake, serial);
    }
    settle(&w);
    for (int t = 0; t < TRACKERS; t++) {
        step(&w, 10 * MS);
        for (int i = 0; i < MANY; i++) {
            uint8_t report[64];
            slimevr_report(report, 0.01 * i, 0);
            for (int k = 0; k < 4; k++)
                report[16 * k + 1] = (uint8_t)t;
            fake_send(w.fake, d[i], report, sizeof report);
        }
        settle(&w);
    }
    assert_int_equal(ap_live_device_count(w.live), MANY);
    int roles = ap_live_role_count(w.live), seen = 0;
    for (int r = 0; r < roles; r++)
        seen += ap_live_at(w.live, r, w.now_ns).state != AP_POSE_NONE;
    assert_int_equal(seen, AP_LIVE_ROLES_MAX - 1); // nobody flies the table
    expect_state(&w, ap_live_role(w.live, "knee"), AP_POSE_EXACT);
    end(&w);
}

static void answer(struct world *w, int d, uint8_t command, const char *text) {
    uint8_t bytes[64] = {0xaa, [5] = (uint8_t)(3 + strlen(text)), [7] = command};
    memcpy(bytes + 8, text, strlen(text));
    if (command == 0x14)
        put16(bytes + 5, 7), bytes[8] = 80, bytes[9] = bytes[10] = bytes[11] = 0;
    step(w, MS);
    fake_send(w->fake, d, bytes, sizeof bytes);
    settle(w); // the reader, and behind it the keeper
    settle(w);
}

static void expect_sent(struct world *w, int d, int count, uint8_t command) {
    assert_int_equal(w->fake->devices[d].sent_count, count);
    assert_int_equal(w->fake->devices[d].sent[count - 1].bytes[8], command);
}

// A device that is asked for its calibration, piece by piece, each answer calling for the next.
static void test_questions(void **state) {
    (void)state;
    struct world w = begin(NULL);
    int d = plug_xreal(w.fake, "X");
    settle(&w);
    expect_sent(&w, d, 1, 0x19); // off
    step(&w, 60 * MS);
    settle(&w);
    expect_sent(&w, d, 2, 0x14);
    answer(&w, d, 0x14, "");
    expect_sent(&w, d, 3, 0x15);
    answer(&w, d, 0x15, "{\"IMU\":{\"device_1\":{\"gyro_bias\":[0.01,0,");
    expect_sent(&w, d, 4, 0x15);
    answer(&w, d, 0x15, "0],\"accel_bias\":[0,0,0]}}}                 ");
    expect_sent(&w, d, 5, 0x19); // on
    for (int i = 0; i < 3; i++) {
        step(&w, MS);
        send_xreal(w.fake, d, (1000 + i) * MS, 0);
        settle(&w);
    }
    expect_near("rate", ap_live_at(w.live, AP_LIVE_HEAD, w.now_ns).angular_rad_s.x, -0.01, 2e-5);
    step(&w, 1500 * MS); // on in any case, and then nothing more
    settle(&w);
    expect_sent(&w, d, 6, 0x19);
    assert_int_equal(device_at(&w, 0).state, AP_LIVE_RUNNING);
    end(&w);
}

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

// Names that are none.
static void test_names(void **state) {
    (void)state;
    struct world w = begin(NULL);
    fake_plug(w.fake, "S\n\xff", 3, 0x1209, 0x7690, "red\x1b[31m \xe9\nE: 0", SLIMEVR_DESCRIPTOR);
    settle(&w);
    struct ap_live_device about = device_at(&w, 0);
    assert_string_equal(about.place.name, "red?[31m ??E: 0");
    assert_string_equal(about.place.serial, "S??");
    end(&w);
}

static void test_recentre(void **state) {
    (void)state;
    struct world w = begin(NULL);
    int head = plug_slimevr(w.fake, "A"), hand = plug_slimevr(w.fake, "B");
    settle(&w);
    play_slimevr(&w, head, 3, 0.7, 0);
    play_slimevr(&w, hand, 3, -0.4, 0);
    ap_live_recentre(w.live);
    play_slimevr(&w, head, 1, 0.7, 0);
    play_slimevr(&w, hand, 1, -0.3, 0);
    struct ap_live_answer a = ap_live_at(w.live, AP_LIVE_HEAD, w.now_ns - 10 * MS);
    expect_near("head", yaw_of(a.pose.q), 0, 1e-4);
    play_slimevr(&w, head, 1, 0.9, 0);
    expect_near("head later", yaw_of(ap_live_at(w.live, AP_LIVE_HEAD, w.now_ns).pose.q), 0.2, 1e-4);
    // The second button of any tracker does the same for all.
    step(&w, 10 * MS);
    send_slimevr(w.fake, hand, 1.0, 2);
    settle(&w);
    step(&w, 10 * MS);
    send_slimevr(w.fake, hand, 1.1, 2); // held: not again
    send_slimevr(w.fake, head, 1.0, 0);
    settle(&w);
    expect_near("hand", yaw_of(ap_live_at(w.live, AP_LIVE_LEFT, w.now_ns).pose.q), 0.1, 1e-4);
    expect_near("head", yaw_of(ap_live_at(w.live, AP_LIVE_HEAD, w.now_ns).pose.q), 0, 1e-4);
    end(&w);
}

static void test_flight(void **state) {
    (void)state;
    static const char *const assign[] = {"table=CAP"};
    struct world w = begin(&(struct ap_live_params){.assign = assign, .assign_count = 1});
    int head = plug_slimevr(w.fake, "A");
    int cap = fake_plug(w.fake, "CAP", 3, 0x256f, 0xc635, "SpaceMouse", CAP_DESCRIPTOR);
    settle(&w);
    play_slimevr(&w, head, 2, 0, 0);
    double before = ap_live_at(w.live, AP_LIVE_HEAD, w.now_ns).pose.p.x;
    // Descriptor: usages 31 30 32 = y x z; x is the second byte. Full deflection: 1 m/s.
    const uint8_t push[] = {1, 0, 127, 0}, rest[] = {1, 0, 0, 0};
    for (int i = 0; i < 10; i++) {
        step(&w, 10 * MS);
        fake_send(w.fake, cap, push, sizeof push);
        send_slimevr(w.fake, head, 0, 0);
        settle(&w);
    }
    step(&w, MS);
    fake_send(w.fake, cap, rest, sizeof rest);
    settle(&w);
    step(&w, 10 * MS);
    send_slimevr(w.fake, head, 0, 0);
    settle(&w);
    // The table went 9 cm to the right; so everybody is 9 cm to the left of it. The cap says
    // nothing any more, and is there all the same.
    double after = ap_live_at(w.live, AP_LIVE_HEAD, w.now_ns).pose.p.x;
    expect_near("flown", after - before, -0.09, 0.011);
    play_slimevr(&w, head, 50, 0, 0);
    settle(&w);
    expect_near("stays", ap_live_at(w.live, AP_LIVE_HEAD, w.now_ns).pose.p.x, after, 1e-3);
    expect_state(&w, AP_LIVE_TABLE, AP_POSE_EXACT);
    end(&w);
}

static void test_position(void **state) {
    (void)state;
    static const char *const position[] = {"head=CAP"};
    struct world w = begin(&(struct ap_live_params){.position = position, .position_count = 1});
    int head = plug_slimevr(w.fake, "A");
    int cap = fake_plug(w.fake, "CAP", 3, 0x256f, 0xc635, "SpaceMouse", CAP_DESCRIPTOR);
    const uint8_t rest[] = {1, 0, 0, 0};
    settle(&w);
    fake_send(w.fake, cap, rest, sizeof rest);
    play_slimevr(&w, head, 2, 0.5, 0);
    struct ap_live_answer a = ap_live_at(w.live, AP_LIVE_HEAD, w.now_ns);
    expect_near("yaw is the head's", yaw_of(a.pose.q), 0.5, 1e-4);
    expect_near("y is the cap's", a.pose.p.y, 1, 1e-9);
    end(&w);
}

static const uint8_t android_text[26] = {5,   '#', 'A', 'n', 'd', 'r', 'o', 'i', 'd',
                                         'H', 'e', 'a', 'd', 'T', 'r', 'a', 'c', 'k',
                                         'e', 'r', '#', '2', '.', '0', '#', '1'};

// Switched on by feature reports that the descriptor tells; refusals are said, and read on.
static void test_start(void **state) {
    (void)state;
    struct world w = begin(NULL);
    int d = -1;
    for (int round = 0; round < 2; round++) {
        const uint8_t control[] = {9, 0};
        pthread_mutex_lock(&w.fake->lock);
        w.fake->devices[round].refuses_features = round == 1;
        pthread_mutex_unlock(&w.fake->lock);
        fake_feature(w.fake, round, android_text, sizeof android_text);
        fake_feature(w.fake, round, control, sizeof control);
        d = fake_plug(w.fake, round ? "S" : "R", 5, 0x054c, 0x0e4c, "WH-1000XM5",
                      ANDROID_DESCRIPTOR);
        settle(&w);
        struct ap_live_device about = device_at(&w, d);
        assert_int_equal(about.state, AP_LIVE_RUNNING);
        assert_string_equal(about.driver->name, "android-head-tracker");
        if (round == 1)
            assert_non_null(strstr(about.why, "refused feature report 09"));
    }
    assert_int_equal(w.fake->devices[0].sent_count, 1);
    assert_int_equal(w.fake->devices[0].sent[0].bytes[0], 9);
    assert_int_equal(w.fake->devices[0].sent[0].bytes[1] & 3, 3); // all events, full power
    end(&w);
}

// Its reports come from one interface, its commands belong to the other.
static void test_hydra(void **state) {
    (void)state;
    struct world w = begin(NULL);
    int d[2];
    for (int i = 0; i < 2; i++) {
        struct ap_live_place place = {
            .bus = 3, .vendor = 0x1532, .product = 0x0300, .interface_number = i};
        snprintf(place.port, sizeof place.port, "usb-1/input%d", i);
        place.descriptor_len =
            bytes_of(XREAL_DESCRIPTOR, strlen(XREAL_DESCRIPTOR), place.descriptor, 64);
        d[i] = fake_plug_place(w.fake, &place);
        fake_feature(w.fake, d[i], (const uint8_t[91]){0}, 91);
    }
    for (int round = 1; round <= 2; round++) {
        settle(&w);
        assert_int_equal(w.fake->devices[d[0]].sent_count, 0);
        assert_int_equal(w.fake->devices[d[1]].sent_count, 1);
        const struct fake_report *sent = &w.fake->devices[d[1]].sent[0];
        assert_int_equal(sent->len, 91);
        const uint8_t motion[91] = {[6] = 1, [8] = 4, [9] = 3, [89] = 6};
        assert_memory_equal(sent->bytes, motion, 91);
        step(&w, 4980 * MS); // it may not have taken
        settle(&w);
        assert_int_equal(w.fake->devices[d[1]].sent_count, 1);
        step(&w, 40 * MS);
        settle(&w);
        assert_int_equal(w.fake->devices[d[1]].sent_count, 2);
        assert_memory_equal(w.fake->devices[d[1]].sent[1].bytes, motion, 91);
        uint8_t report[52] = {0};
        put16(report + 8, 100 * round); // millimetres to the right
        put16(report + 14, 32767);      // upright
        put16(report + 36, 32767);
        step(&w, 10 * MS);
        fake_send(w.fake, d[0], report, sizeof report);
        fake_send(w.fake, d[1], report, 8); // as a mouse would
        settle(&w);
        struct ap_live_answer a = ap_live_at(w.live, AP_LIVE_LEFT, w.now_ns);
        assert_int_equal(a.state, AP_POSE_EXACT);
        expect_near("x", a.pose.p.x, 0.1 * round, 1e-9);
        expect_state(&w, AP_LIVE_RIGHT, AP_POSE_EXACT);
        assert_int_equal(device_at(&w, 1).bad, 0);
        step(&w, 4995 * MS); // one that says where it is need not be told
        settle(&w);
        assert_int_equal(w.fake->devices[d[1]].sent_count, 2);
        fake_unplug(w.fake, d[0]);
        fake_unplug(w.fake, d[1]);
        settle(&w);
        fake_replug(w.fake, d[1], NULL);
        fake_replug(w.fake, d[0], NULL);
    }
    settle(&w);
    assert_int_equal(ap_live_device_count(w.live), 2);
    end(&w);
}

static void test_assignments(void **state) {
    (void)state;
    static const char *const wrong[] = {"head", "=x",
                                        "head=", "a-name-that-is-longer-than-names-may-be=x"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        struct fake_bus *fake = fake_bus_create(START_NS);
        struct ap_live_bus way = fake_way(fake);
        struct ap_live *live = NULL;
        struct ap_error err = {""};
        const struct ap_live_params params = {
            .buses = &way, .bus_count = 1, .assign = &wrong[i], .assign_count = 1};
        assert_int_equal(ap_live_open(&err, &params, &live), AP_USAGE);
        assert_null(live);
        assert_non_null(strstr(err.text, "ROLE=WHICH"));
        assert_true(fake->destroyed);
        fake_bus_free(fake);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_head),
        cmocka_unit_test(test_unplug),
        cmocka_unit_test(test_slow_unplug),
        cmocka_unit_test(test_quick_replug),
        cmocka_unit_test(test_other_transport),
        cmocka_unit_test(test_twice),
        cmocka_unit_test(test_equal_devices),
        cmocka_unit_test(test_garbage),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_many),
        cmocka_unit_test(test_stall_with_clock),
        cmocka_unit_test(test_stall_without_clock),
        cmocka_unit_test(test_first_queue),
        cmocka_unit_test(test_names),
        cmocka_unit_test(test_recentre),
        cmocka_unit_test(test_flight),
        cmocka_unit_test(test_position),
        cmocka_unit_test(test_start),
        cmocka_unit_test(test_questions),
        cmocka_unit_test(test_hydra),
        cmocka_unit_test(test_assignments),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
