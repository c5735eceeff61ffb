#include "tests/device/live/world.h"

// Devices that come, go, come back by another way, are many, refuse, and are nobody's.

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
        cmocka_unit_test(test_names),
        cmocka_unit_test(test_assignments),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
