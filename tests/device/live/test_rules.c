#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "src/device/live/rules.h"

// udev's rules name every device that a driver names, and what is said where one is missing.

static char *rules_text(void) {
    char *text = NULL;
    size_t len = 0;
    FILE *f = open_memstream(&text, &len);
    ap_live_write_rules(f);
    fclose(f);
    assert_non_null(text);
    return text;
}

static void expect_named(const char *rules, const struct ap_driver *driver,
                         const struct ap_driver_ids *id, unsigned product) {
    char hidraw[64], usb[64];
    snprintf(hidraw, sizeof hidraw, "%04X:%04X.*", (unsigned)id->vendor, product);
    snprintf(usb, sizeof usb, "ATTR{idVendor}==\"%04x\"", (unsigned)id->vendor);
    if (id->first_product == 0 && id->last_product == 0xffff)
        snprintf(hidraw, sizeof hidraw, "%04X:*.*", (unsigned)id->vendor);
    if (!strstr(rules, hidraw))
        fail_msg("%s: the rules do not name %s", driver->name, hidraw);
    if ((!id->bus || id->bus == 3) && !strstr(rules, usb))
        fail_msg("%s: the rules do not name %s", driver->name, usb);
}

// What a driver takes by its ids alone it also names; a driver of a class of devices need not.
static void test_rules_name_what_drivers_name(void **state) {
    (void)state;
    char *rules = rules_text();
    int named = 0;
    for (int i = 0; i < ap_driver_count(); i++) {
        const struct ap_driver *driver = ap_driver_at(i);
        for (const struct ap_driver_ids *id = driver->ids; id && id->vendor; id++, named++) {
            assert_true(id->first_product <= id->last_product);
            expect_named(rules, driver, id, id->first_product);
            expect_named(rules, driver, id, id->last_product);
        }
    }
    assert_true(named > 10);
    free(rules);
}

// The other way round: whatever ids a driver takes without looking at a descriptor.
static void test_drivers_name_what_they_take(void **state) {
    (void)state;
    static const uint16_t vendors[] = {0x1209, 0x4e76, 0x1532, 0x054c, 0x057e, 0x3318, 0x2833};
    static struct ap_device_info info;
    int taken = 0;
    for (size_t v = 0; v < sizeof vendors / sizeof *vendors; v++)
        for (unsigned product = 0; product <= 0xffff; product++)
            for (uint16_t bus = 3; bus <= 5; bus += 2) {
                info.bus = bus;
                info.vendor = vendors[v];
                info.product = (uint16_t)product;
                const struct ap_driver *driver = ap_driver_find(&info);
                taken += driver != NULL;
                if (driver && !ap_driver_names(driver, &info))
                    fail_msg("%s takes %04x:%04x and does not name it", driver->name,
                             (unsigned)vendors[v], product);
            }
    assert_true(taken > 20);
}

static void test_every_line_is_a_rule(void **state) {
    (void)state;
    char *rules = rules_text();
    int lines = 0;
    for (char *line = strtok(rules, "\n"); line; line = strtok(NULL, "\n")) {
        size_t n = strlen(line);
        if (line[0] == '#' || strncmp(line, "ACTION==", 8) == 0 || strncmp(line, "LABEL=", 6) == 0)
            continue;
        lines++;
        assert_true(strncmp(line, "KERNEL==\"hidraw*\", KERNELS==\"", 29) == 0 ||
                    strncmp(line, "SUBSYSTEM==\"usb\", ", 18) == 0);
        assert_string_equal(line + n - strlen(", TAG+=\"uaccess\""), ", TAG+=\"uaccess\"");
        int quotes = 0;
        for (const char *c = line; *c; c++)
            quotes += *c == '"';
        assert_int_equal(quotes % 2, 0);
        assert_true(n < 8192); // udev's longest line
    }
    assert_true(lines > 15);
    free(rules);
}

static void test_what_is_said(void **state) {
    (void)state;
    struct ap_live_place known = {
        .path = "/dev/hidraw3", .bus = 3, .vendor = 0x1209, .product = 0x7690};
    struct ap_live_place unknown = {
        .path = "/dev/hidraw4", .bus = 5, .vendor = 0xcafe, .product = 0x0042};
    char text[256];
    assert_true(ap_live_rules_cover(&known));
    ap_live_denied_text(&known, ap_driver_at(0), text, sizeof text);
    assert_non_null(strstr(text, "/dev/hidraw3"));
    assert_non_null(strstr(text, "70-antipode.rules"));
    assert_non_null(strstr(text, "/etc/udev/rules.d"));
    assert_non_null(strstr(text, "udevadm"));
    assert_false(ap_live_rules_cover(&unknown));
    ap_live_denied_text(&unknown, NULL, text, sizeof text);
    assert_non_null(
        strstr(text, "KERNEL==\"hidraw*\", KERNELS==\"0005:CAFE:0042.*\", TAG+=\"uaccess\""));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rules_name_what_drivers_name),
        cmocka_unit_test(test_drivers_name_what_they_take),
        cmocka_unit_test(test_every_line_is_a_rule),
        cmocka_unit_test(test_what_is_said),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
