#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "src/device/live/usb_known.h"

static const int64_t MS = 1000000;

static void test_settled(void **state) {
    (void)state;
    struct ap_usb_known *known = ap_usb_known_create();
    assert_non_null(known);
    const struct ap_usb_place old = {.folder = "1-1:1.0", .node = "/dev/bus/usb/001/002"};
    const struct ap_usb_place new = {.folder = "1-2:1.0", .node = "/dev/bus/usb/001/003"};
    const struct ap_usb_place again = {.folder = "1-2:1.0", .node = "/dev/bus/usb/001/004"};
    ap_usb_known_look(known, 5000 * MS);
    assert_true(ap_usb_is_settled(known, &old)); // was there before we came
    ap_usb_known_look(known, 5500 * MS);
    assert_true(ap_usb_is_settled(known, &old));
    assert_false(ap_usb_is_settled(known, &new));
    ap_usb_known_look(known, 5899 * MS);
    assert_false(ap_usb_is_settled(known, &new));
    ap_usb_known_look(known, 5900 * MS);
    assert_true(ap_usb_is_settled(known, &new));
    assert_false(ap_usb_is_settled(known, &again)); // plugged in once more: another node
    ap_usb_known_look(known, 6300 * MS);
    assert_true(ap_usb_is_settled(known, &again));
    // What had a node until now is being unplugged, or its driver unbound.
    const struct ap_usb_place node = {
        .folder = "1-2:1.0", .node = "/dev/bus/usb/001/004", .has_node = true};
    ap_usb_known_look(known, 7000 * MS);
    assert_false(ap_usb_is_settled(known, &node));
    ap_usb_known_look(known, 7100 * MS);
    assert_false(ap_usb_is_settled(known, &again));
    ap_usb_known_look(known, 7400 * MS);
    assert_true(ap_usb_is_settled(known, &again));
    // More than are remembered: the oldest are met anew.
    for (int i = 0; i < 100; i++) {
        char folder[16] = {'3', '-', (char)('0' + i / 10), (char)('0' + i % 10), 0};
        const struct ap_usb_place one = {.folder = folder, .node = "/dev/bus/usb/003/001"};
        assert_false(ap_usb_is_settled(known, &one));
    }
    assert_false(ap_usb_is_settled(known, &again));
    ap_usb_known_destroy(known);
}

static void test_descriptor(void **state) {
    (void)state;
    struct ap_usb_known *known = ap_usb_known_create();
    assert_non_null(known);
    uint8_t bytes[64];
    ap_usb_known_look(known, MS);
    const struct ap_usb_place nowhere = {.folder = "1-1:1.0", .node = "/nowhere/001/002"};
    assert_int_equal(ap_usb_descriptor(known, &nowhere, bytes, sizeof bytes), 0);
    const struct ap_usb_place no_usb = {.folder = "1-1:1.0", .node = "/dev/null"};
    assert_int_equal(ap_usb_descriptor(known, &no_usb, bytes, sizeof bytes), 0);
    ap_usb_known_destroy(known);
    ap_usb_known_destroy(NULL);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_settled),
        cmocka_unit_test(test_descriptor),
    };
    return cmocka_run_group_tests_name("device/live/usb_known", tests, NULL, NULL);
}
