#include <string.h>

#include "src/base/number.h"
#include "src/track/text.h"
#include "tests/track/support.h"

// The fast digits are those of printf, byte for byte.

static void check(double value) {
    char text[AP_ISO_TEXT_MAX], expected[AP_DOUBLE_TEXT_MAX];
    size_t len = ap_number_text(text, value), wanted = ap_format_double(expected, value);
    if (len != wanted || memcmp(text, expected, len) != 0)
        fail_msg("%a: '%.*s', expected '%s'", value, (int)len, text, expected);
}

static void both_signs(double value) {
    check(value);
    check(-value);
}

static void corners(void **state) {
    (void)state;
    const double values[] = {0,
                             1,
                             0.5,
                             0.1,
                             10,
                             100,
                             12345678901234567.0,
                             1e15,
                             1e16,
                             1e17,
                             0x1p53,
                             1e-4,
                             1e-5,
                             1e22,
                             123456789012345678.0,
                             5e-324,
                             NAN,
                             1e308,
                             INFINITY,
                             0x1p-13,
                             0x1p-14,
                             9007199254740993.0,
                             0.99999999999999989,
                             9.9999999999999982,
                             0.00099999999999999998,
                             9999999999999998.0,
                             999999999999999.88,
                             1.5,
                             1024,
                             4503599627370495.5};
    for (size_t i = 0; i < sizeof values / sizeof *values; i++) {
        both_signs(values[i]);
        both_signs(nextafter(values[i], 0));
        both_signs(nextafter(values[i], INFINITY));
    }
    for (int e = -6; e < 19; e++) {
        both_signs(pow(10, e));
        both_signs(nextafter(pow(10, e), 0));
        both_signs(nextafter(pow(10, e), INFINITY));
    }
    // Ties: the 18th digit is a 5 and nothing follows.
    for (int i = 0; i < 64; i++)
        both_signs(0x1p52 + i + 0.5);
    for (int i = 1; i < 4000; i += 2)
        both_signs(i * 0x1p-17);
}

static void random_numbers(void **state) {
    (void)state;
    uint64_t seed = 1;
    for (int i = 0; i < 200000; i++) {
        double m = noise(&seed);
        check(ldexp(m, (int)(40 * noise(&seed))));
        check(ldexp(floor(1000 * m), -(i % 24)));
    }
}

static void matrix(void **state) {
    (void)state;
    char text[AP_ISO_TEXT_MAX];
    size_t len = ap_iso_text(text, &AP_ISO_IDENTITY);
    assert_int_equal(len, 31);
    assert_memory_equal(text, "1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1", 31);
    struct ap_iso longest;
    for (int i = 0; i < 16; i++)
        longest.m[i / 4][i % 4] = -1.2345678901234567e-300;
    assert_true(ap_iso_text(text, &longest) <= AP_ISO_TEXT_MAX);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(corners),
        cmocka_unit_test(random_numbers),
        cmocka_unit_test(matrix),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
