#include "tests/device/live/world.h"

// What the layer does for one model or the other: switching on, questions and answers, recentring,
// flying, and a place from another device.

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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_questions), cmocka_unit_test(test_recentre),
        cmocka_unit_test(test_flight),    cmocka_unit_test(test_position),
        cmocka_unit_test(test_start),     cmocka_unit_test(test_hydra),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
