#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "src/device/hid/descriptor.h"
#include "tests/device/hid/bytes_of.h"

static struct ap_hid_descriptor d;

static void parse(const char *hex) {
    uint8_t bytes[AP_HID_DESCRIPTOR_MAX];
    size_t len = bytes_of(hex, strlen(hex), bytes, sizeof bytes);
    struct ap_error err;
    if (ap_hid_parse_descriptor(&err, bytes, len, &d))
        fail_msg("%s: %s", hex, err.text);
}

static void refuse(const char *hex, const char *why) {
    uint8_t bytes[AP_HID_DESCRIPTOR_MAX];
    size_t len = bytes_of(hex, strlen(hex), bytes, sizeof bytes);
    struct ap_error err = {""};
    assert_int_equal(ap_hid_parse_descriptor(&err, bytes, len, &d), AP_INPUT);
    if (!strstr(err.text, why))
        fail_msg("%s: '%s' lacks '%s'", hex, err.text, why);
    assert_int_equal(d.field_count, 0);
}

static void check_near(double got, double want, double tolerance) {
    if (!(fabs(got - want) <= tolerance))
        fail_msg("%.17g, expected %.17g (%g)", got, want, tolerance);
}

static void test_android(void **unused) {
    (void)unused;
    parse(ANDROID_DESCRIPTOR);
    assert_true(d.is_numbered);
    assert_true(ap_hid_has_application(&d, AP_HID_USAGE(0x20, 0xe1)));
    assert_int_equal(ap_hid_report_bytes(&d, AP_HID_INPUT, 7), 14);
    assert_int_equal(ap_hid_report_bytes(&d, AP_HID_FEATURE, 5), 1 + 25 + 16);
    assert_int_equal(ap_hid_report_bytes(&d, AP_HID_FEATURE, 9), 2);
    assert_int_equal(ap_hid_report_bytes(&d, AP_HID_INPUT, 9), 0);
    uint32_t at;
    int n = ap_hid_find(&d, AP_HID_INPUT, AP_HID_USAGE(0x20, 0x544), 0, &at);
    assert_true(n >= 0 && at == 0);
    const struct ap_hid_field *f = &d.fields[n];
    assert_true(f->is_variable && !f->is_constant && f->count == 3 && f->size_bits == 16);
    assert_int_equal(f->bit_offset, 8);
    assert_int_equal(f->exponent, -8);
    // All three values have the one usage.
    assert_int_equal(ap_hid_usage_at(&d, f, 2), AP_HID_USAGE(0x20, 0x544));
    uint8_t report[14] = {7, 0xff, 0x7f, 0x01, 0x80, 0, 0, 0, 0, 0, 0x40, 0, 0, 200};
    struct ap_hid_value v;
    assert_true(ap_hid_extract(f, report, 14, 0, &v) && v.raw == 32767);
    check_near(v.physical, 3.14159265, 1e-15);
    assert_true(ap_hid_extract(f, report, 14, 1, &v) && v.raw == -32767);
    check_near(v.physical, -3.14159264, 1e-15);
    // Not another report's, not beyond the field, not beyond the report.
    assert_false(ap_hid_extract(f, report, 14, 3, &v));
    assert_false(ap_hid_extract(f, report, 6, 2, &v));
    assert_true(ap_hid_extract(f, report, 7, 2, &v));
    report[0] = 8;
    assert_false(ap_hid_extract(f, report, 14, 0, &v));
    report[0] = 7;
    n = ap_hid_find(&d, AP_HID_INPUT, AP_HID_USAGE(0x20, 0x545), 0, &at);
    assert_true(ap_hid_extract(&d.fields[n], report, 14, 1, &v));
    check_near(v.physical, 16384 / 32767.0 * 32, 1e-12);
    n = ap_hid_find(&d, AP_HID_INPUT, AP_HID_USAGE(0x20, 0x546), 0, &at);
    assert_true(ap_hid_extract(&d.fields[n], report, 14, 0, &v) && v.raw == 200);
    // The second choice of an array.
    n = ap_hid_find(&d, AP_HID_FEATURE, AP_HID_USAGE(0x20, 0x841), 0, &at);
    assert_true(n >= 0 && at == 1 && !d.fields[n].is_variable);
    assert_true(ap_hid_is_within(&d, d.fields[n].collection, AP_HID_USAGE(0x20, 0x316)));
    assert_true(ap_hid_is_within(&d, d.fields[n].collection, AP_HID_USAGE(0x20, 0xe1)));
    n = ap_hid_find(&d, AP_HID_FEATURE, AP_HID_USAGE(0x20, 0x30e), 0, &at);
    assert_int_equal(ap_hid_raw_from_physical(&d.fields[n], 0.01), 0);
    assert_int_equal(ap_hid_raw_from_physical(&d.fields[n], 0.1), 31);
    assert_int_equal(ap_hid_raw_from_physical(&d.fields[n], 5), 31);
    assert_int_equal(ap_hid_raw_from_physical(&d.fields[n], NAN), 0);
}

// Every bit at every place, against a plain loop over the bits.
static void test_bits(void **unused) {
    (void)unused;
    uint8_t report[16];
    for (size_t i = 0; i < sizeof report; i++)
        report[i] = (uint8_t)(0x9d * (i + 3) ^ 0x35);
    for (uint32_t size = 1; size <= 32; size++) {
        for (uint32_t offset = 0; offset < 20; offset++) {
            struct ap_hid_field f = {.is_variable = true,
                                     .bit_offset = offset,
                                     .size_bits = size,
                                     .count = 2,
                                     .logical_min = -1};
            int64_t want = 0;
            for (uint32_t k = 0; k < size; k++) {
                uint32_t bit = offset + size + k;
                want |= (int64_t)(report[bit / 8] >> bit % 8 & 1) << k;
            }
            struct ap_hid_value v;
            if (want >> (size - 1) & 1)
                want -= INT64_C(1) << size;
            assert_true(ap_hid_extract(&f, report, sizeof report, 1, &v));
            assert_int_equal(v.raw, want);
            uint8_t other[16];
            memset(other, (int)(offset * 37), sizeof other);
            uint8_t before[16];
            memcpy(before, other, sizeof other);
            struct ap_hid_value first, first_after;
            ap_hid_extract(&f, other, sizeof other, 0, &first);
            assert_true(ap_hid_insert(&f, other, sizeof other, 1, want));
            assert_true(ap_hid_extract(&f, other, sizeof other, 1, &v) && v.raw == want);
            assert_true(ap_hid_extract(&f, other, sizeof other, 0, &first_after));
            assert_int_equal(first.raw, first_after.raw);
            assert_int_equal(other[15], before[15]);
        }
    }
}

static void test_state(void **unused) {
    (void)unused;
    // Push and pop; a usage of 32 bits with its own page; a maximum of FF after a minimum of 0.
    parse("05 01 09 30 a1 01 15 00 25 ff 75 08 95 01 a4 15 ff 25 7f 75 10 0b 31 00 20 00 81 02 "
          "b4 09 32 81 02 c0");
    assert_int_equal(d.field_count, 2);
    assert_int_equal(d.fields[0].size_bits, 16);
    assert_int_equal(d.fields[0].logical_min, -1);
    assert_int_equal(ap_hid_usage_at(&d, &d.fields[0], 0), AP_HID_USAGE(0x20, 0x31));
    assert_int_equal(d.fields[1].size_bits, 8);
    assert_int_equal(d.fields[1].logical_max, 255);
    assert_int_equal(d.fields[1].bit_offset, 16);
    assert_false(d.is_numbered);
    // Ranges, then a single usage, that repeats; padding counts, but is no field.
    parse("05 09 a1 01 19 01 29 03 09 09 15 00 25 01 75 01 95 06 81 02 95 02 81 03 09 20 95 08 "
          "81 02 c0");
    assert_int_equal(d.field_count, 2);
    static const uint32_t ids[] = {1, 2, 3, 9, 9, 9};
    for (uint32_t i = 0; i < 6; i++)
        assert_int_equal(ap_hid_usage_at(&d, &d.fields[0], i), AP_HID_USAGE(9, ids[i]));
    assert_int_equal(d.fields[1].bit_offset, 8);
    uint32_t at;
    assert_int_equal(ap_hid_find(&d, AP_HID_INPUT, AP_HID_USAGE(9, 3), 0, &at), 0);
    assert_int_equal(at, 2);
    assert_int_equal(ap_hid_find(&d, AP_HID_INPUT, AP_HID_USAGE(9, 4), 0, &at), -1);
    // Long items are passed over; of alternatives the first counts.
    parse("fe 02 f0 aa bb 05 01 a1 01 a9 01 09 30 09 31 a9 00 75 08 95 01 81 02 c0");
    assert_int_equal(ap_hid_usage_at(&d, &d.fields[0], 0), AP_HID_USAGE(1, 0x30));
    assert_int_equal(d.usage_count, 1);
}

static void test_hostile(void **unused) {
    (void)unused;
    refuse("", "expected 1 to 4096 bytes, not 0");
    refuse("05", "byte 0: an item that goes beyond the end");
    refuse("fe ff", "byte 0: an item that goes beyond the end");
    refuse("fe 05 01 00", "byte 0: an item that goes beyond the end");
    refuse("c0", "byte 0: the end of a collection that was not begun");
    refuse("a1 01", "byte 2: a collection that does not end");
    refuse("b4", "a pop without a push");
    refuse("a4 a4 a4 a4 a4 a4 a4 a4 a4", "byte 8: more than 8 pushes");
    refuse("85 00", "a report id");
    refuse("86 00 01", "a report id");
    refuse("19 05 29 04", "a usage range that ends before it begins");
    refuse("56 00 01", "a unit exponent");
    // A billion bits, and 2^32 times 2^32 of them.
    refuse("09 01 77 00 ca 9a 3b 95 01 81 02", "input report 0 is longer than 16384 bytes");
    refuse("85 03 77 ff ff ff ff 97 ff ff ff ff b1 02", "feature report 3 is longer");
    // 2^32 values of no bits are no field.
    parse("09 01 75 00 97 ff ff ff ff 81 02");
    assert_int_equal(d.field_count, 0);
    char text[4 * AP_HID_DESCRIPTOR_MAX] = "";
    for (int i = 0; i < 33; i++)
        strcat(text, "a1 00 ");
    refuse(text, "more than 32 collections in one another");
    text[0] = 0;
    for (int i = 0; i < 129; i++)
        strcat(text, "a1 00 c0 ");
    refuse(text, "more than 128 collections");
    strcpy(text, "75 01 95 01 ");
    for (int i = 0; i < 257; i++)
        strcat(text, "09 01 81 02 ");
    refuse(text, "more than 256 fields");
    text[0] = 0;
    for (int i = 0; i < 1025; i++)
        strcat(text, "09 01 ");
    refuse(text, "more than 1024 usages");
    // A range of all usages, asked beyond its end.
    parse("1b 00 00 00 00 2b ff ff ff ff 75 08 95 02 81 00 09 05 81 02");
    assert_int_equal(ap_hid_usage_at(&d, &d.fields[0], UINT32_MAX), UINT32_MAX);
    uint32_t at;
    assert_int_equal(ap_hid_find(&d, AP_HID_INPUT, 0xffffffff, 0, &at), 0);
    assert_int_equal(at, UINT32_MAX);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_android),
        cmocka_unit_test(test_bits),
        cmocka_unit_test(test_state),
        cmocka_unit_test(test_hostile),
    };
    return cmocka_run_group_tests_name("hid-descriptor", tests, NULL, NULL);
}
