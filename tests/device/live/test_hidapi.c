#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "src/base/clock.h"
#include "src/device/live/live.h"
#include "tests/device/hid/bytes_of.h"
#include "tests/device/live/devices.h"
#include "tests/device/live/fake_hidapi.h"
#include "tests/memory.h"

// The way by hidapi, on a library of the test's own.

static const int64_t MS = 1000000;
enum { RECEIVER, CAP, GLASSES, KEYBOARD };

static void plug_receiver(void) {
    static wchar_t serial[] = L"\u00c41", name[] = L"Empf\u00e4nger \U0001f3b1";
    fake_hid_reset();
    fake_hid[RECEIVER] = (struct fake_hid){.path = "1-2:1.0",
                                           .vendor = 0x1209,
                                           .product = 0x7690,
                                           .serial = serial,
                                           .name = name,
                                           .collections = 3};
    fake_hid_plug(RECEIVER, true);
}

static struct ap_live *open_live(struct ap_error *err) {
    struct ap_live_bus way;
    struct ap_live *live = NULL;
    if (!ap_live_hidapi(err, &way))
        ap_live_open(err, &(struct ap_live_params){.buses = &way, .bus_count = 1}, &live);
    return live;
}

static struct ap_live *must_open(void) {
    struct ap_error err = {""};
    struct ap_live *live = open_live(&err);
    if (!live)
        fail_msg("%s", err.text);
    assert_true(ap_live_settle(live, ap_clock_now_ns() + 3000 * MS));
    return live;
}

static const struct ap_live_device *find(const struct ap_live *live, const char *path) {
    static struct ap_live_device d;
    for (int i = 0; i < ap_live_device_count(live); i++) {
        ap_live_device_at(live, i, &d);
        if (strcmp(d.place.path, path) == 0)
            return &d;
    }
    return NULL;
}

// Until the device has so many reports and is in this state; false after a while.
static bool comes_to(const struct ap_live *live, const char *path, int64_t reports,
                     enum ap_live_state state, int64_t within_ns) {
    for (int64_t end = ap_clock_now_ns() + within_ns; ap_clock_now_ns() < end;) {
        const struct ap_live_device *d = find(live, path);
        if (d && d->reports >= reports && d->state == state)
            return true;
        ap_clock_sleep_until_ns(ap_clock_now_ns() + MS);
    }
    return false;
}

static void check_comes_to(const struct ap_live *live, const char *path, int64_t reports,
                           enum ap_live_state state) {
    if (comes_to(live, path, reports, state, 5000 * MS))
        return;
    const struct ap_live_device *d = find(live, path);
    fail_msg("%s: %s, %lld reports; expected %s, %lld reports", path,
             d ? ap_live_state_name(d->state) : "not there", d ? (long long)d->reports : -1,
             ap_live_state_name(state), (long long)reports);
}

static void send(double yaw_rad) {
    uint8_t bytes[64];
    slimevr_report(bytes, yaw_rad, 0);
    fake_hid_report(RECEIVER, bytes, sizeof bytes);
}

static void test_poses(void **unused) {
    (void)unused;
    plug_receiver();
    struct ap_live *live = must_open();
    check_comes_to(live, "1-2:1.0", 0, AP_LIVE_RUNNING);
    for (int i = 0; i < 5; i++)
        send(0.3);
    check_comes_to(live, "1-2:1.0", 5, AP_LIVE_RUNNING);
    assert_int_equal(ap_live_device_count(live), 1); // three collections are one device
    const struct ap_live_device *d = find(live, "1-2:1.0");
    assert_string_equal(d->way, "hidapi");
    assert_string_equal(d->driver->name, "slimevr");
    assert_string_equal(d->place.serial, "\xc3\x84"
                                         "1");
    assert_string_equal(d->place.name, "Empf\xc3\xa4nger \xf0\x9f\x8e\xb1");
    struct ap_live_answer a = ap_live_at(live, AP_LIVE_HEAD, ap_live_now_ns(live));
    if (fabs(yaw_of(a.pose.q) - 0.3) > 1e-4)
        fail_msg("yaw %.9f, expected 0.3, tolerance 1e-4", yaw_of(a.pose.q));
    ap_live_close(live);
    assert_int_equal(fake_hid[RECEIVER].closed, 1);
    assert_int_equal(fake_hid_users(), 0);
}

// A descriptor that nobody knows before the device is open: only what may be for us is opened.
static void test_descriptor_asked_for(void **unused) {
    (void)unused;
    static uint8_t bytes[256];
    size_t len = bytes_of(CAP_DESCRIPTOR, sizeof CAP_DESCRIPTOR - 1, bytes, sizeof bytes);
    fake_hid_reset();
    fake_hid[CAP] = (struct fake_hid){.path = "cap",
                                      .vendor = 0x256f,
                                      .product = 0xc6ff,
                                      .usage_page = 1,
                                      .usage = 8,
                                      .collections = 1,
                                      .descriptor = bytes,
                                      .descriptor_len = len};
    fake_hid[KEYBOARD] = (struct fake_hid){
        .path = "keyboard", .vendor = 1, .usage_page = 1, .usage = 6, .collections = 1};
    fake_hid[GLASSES] = (struct fake_hid){
        .path = "/dev/null", .vendor = 2, .usage_page = 0x20, .usage = 0xe1, .collections = 1};
    for (int i = CAP; i <= KEYBOARD; i++)
        fake_hid_plug(i, true);
    struct ap_live *live = must_open();
    check_comes_to(live, "cap", 0, AP_LIVE_RUNNING);
    assert_string_equal(find(live, "cap")->driver->name, "spacemouse");
    assert_int_equal(fake_hid[KEYBOARD].opened, 0);
    // The library would end the program.
    check_comes_to(live, "/dev/null", 0, AP_LIVE_FAILED);
    assert_non_null(strstr(find(live, "/dev/null")->why, "is no hidraw node"));
    ap_live_close(live);
}

static void test_unplugged(void **unused) {
    (void)unused;
    plug_receiver();
    struct ap_live *live = must_open();
    check_comes_to(live, "1-2:1.0", 0, AP_LIVE_RUNNING);
    send(0.1);
    check_comes_to(live, "1-2:1.0", 1, AP_LIVE_RUNNING);
    fake_hid_hold(true);
    for (int i = 0; i < 9; i++)
        send(0.2);
    fake_hid_plug(RECEIVER, false);
    fake_hid_hold(false);
    check_comes_to(live, "1-2:1.0", 10, AP_LIVE_GONE); // what was queued counts
    assert_int_equal(ap_live_at(live, AP_LIVE_HEAD, ap_live_now_ns(live)).state, AP_POSE_LOST);
    fake_hid_plug(RECEIVER, true);
    check_comes_to(live, "1-2:1.0", 10, AP_LIVE_RUNNING);
    send(0.3);
    check_comes_to(live, "1-2:1.0", 11, AP_LIVE_RUNNING);
    assert_int_equal(find(live, "1-2:1.0")->unplugged_count, 1);
    assert_string_equal(find(live, "1-2:1.0")->role[0], "head");
    ap_live_close(live);
    assert_int_equal(fake_hid[RECEIVER].opened, 2);
    assert_int_equal(fake_hid[RECEIVER].closed, 2);
}

// What switches a device on gets through although somebody reads it all the time.
static void test_sent(void **unused) {
    (void)unused;
    fake_hid_reset();
    fake_hid[GLASSES] =
        (struct fake_hid){.path = "glasses", .vendor = 0x3318, .product = 0x0424, .collections = 1};
    fake_hid_plug(GLASSES, true);
    struct ap_live *live = must_open();
    check_comes_to(live, "glasses", 0, AP_LIVE_RUNNING);
    uint8_t bytes[64];
    xreal_report(bytes, 5 * MS, 0);
    fake_hid_report(GLASSES, bytes, sizeof bytes);
    check_comes_to(live, "glasses", 1, AP_LIVE_RUNNING);
    assert_true(fake_hid[GLASSES].sent_count > 0);
    assert_int_equal(fake_hid[GLASSES].sent[0][1], 0xaa); // behind the number, which is 0
    ap_live_close(live);
}

static void test_two_users(void **unused) {
    (void)unused;
    plug_receiver();
    struct ap_live *first = must_open(), *second = must_open();
    ap_live_close(first);
    assert_int_equal(fake_hid_users(), 1);
    ap_live_close(second);
    assert_int_equal(fake_hid_users(), 0);
}

// How many reports were read in a life with this device; −1: it did not begin.
static int64_t live_a_life(void) {
    struct ap_error err = {""};
    plug_receiver();
    struct ap_live *live = open_live(&err);
    if (!live) {
        assert_true(err.text[0] != '\0');
        return -1;
    }
    comes_to(live, "1-2:1.0", 0, AP_LIVE_RUNNING, 400 * MS); // one that failed is tried again
    for (int i = 0; i < 5; i++)
        send(0.1);
    comes_to(live, "1-2:1.0", 5, AP_LIVE_RUNNING, 100 * MS);
    const struct ap_live_device *d = find(live, "1-2:1.0");
    int64_t reports = d ? d->reports : -1;
    ap_live_close(live);
    return reports;
}

static void test_every_wish_for_memory(void **unused) {
    (void)unused;
    long i = 0, whole = 0;
    for (bool refused = true; refused && i < 200; i++) {
        memory_refuse(i, false);
        int64_t reports = live_a_life();
        refused = memory_allow() > 0;
        whole += reports == 5;
        assert_true(refused || reports == 5);
        assert_int_equal(fake_hid[RECEIVER].opened, fake_hid[RECEIVER].closed);
        assert_int_equal(fake_hid_users(), 0);
    }
    print_message("%ld wishes, each refused once; %ld lives read everything all the same\n", i - 1,
                  whole - 1);
    assert_true(i > 8 && i < 200);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_poses),     cmocka_unit_test(test_descriptor_asked_for),
        cmocka_unit_test(test_unplugged), cmocka_unit_test(test_sent),
        cmocka_unit_test(test_two_users), cmocka_unit_test(test_every_wish_for_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
