#include <inttypes.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "src/base/number.h"
#include "src/device/log/decimal.h"

static uint64_t state = 7;

static uint64_t random_bits(void) {
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return state;
}

// The fast way and strtod agree in what they take and in every bit.
static void check_same(const char *text) {
    double fast = 4711, slow = 4711;
    bool a = ap_decimal_double(text, strlen(text), &fast);
    bool b = ap_parse_double(text, strlen(text), &slow);
    if (a != b || memcmp(&fast, &slow, sizeof fast) != 0)
        fail_msg("'%s': %d %a, strtod: %d %a", text, a, fast, b, slow);
}

static void test_doubles_of_odd_texts(void **unused) {
    (void)unused;
    const char *const texts[] = {
        "", "+", "-", ".", "-.", "e5", "1e", "1e+", "1.e3", ".5", "5.", "0", "-0", "-0.0", "00012",
        "1 ", " 1", "1x", "nan", "inf", "0x1p3", "1e22", "1e23", "1e-22", "1e-23", "1e28", "1e308",
        "1e309", "1e-5000", "-1e-324", "4.9e-324", "2.5e-324", "1e99999999999999999999",
        "0e99999999999999999999", "9007199254740992", "9007199254740993", "9007199254740991e22",
        "9007199254740993e-1", "18446744073709551615", "18446744073709551616",
        "99999999999999999999e-27",
        // Between two doubles, exactly and next to it: where rounding twice would go wrong.
        "1.00000000000000011102230246251565", "1.00000000000000011102230246251566",
        "1.0000000000000001110", "1.0000000000000001111", "9007199254740993.0000000000000001",
        "0.50000000000000005551115123125782702118158340454101562", "4503599627370497.5",
        "4503599627370496.5", "450359962737049.65"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
        check_same(texts[i]);
}

static void test_doubles_at_random(void **unused) {
    (void)unused;
    char text[64];
    for (int i = 0; i < 300000; i++) {
        int digits = 1 + (int)(random_bits() % 20), scale = (int)(random_bits() % 60) - 40;
        snprintf(text, sizeof text, "%s%" PRIu64 "e%d", i & 1 ? "-" : "", random_bits(), scale);
        check_same(text);
        double v = ldexp((double)(int64_t)random_bits(), (int)(random_bits() % 40) - 80);
        snprintf(text, sizeof text, "%.*g", digits, v);
        check_same(text);
        snprintf(text, sizeof text, "%.*f", digits, v);
        check_same(text);
    }
}

struct seconds_case {
    const char *text;
    bool ok;
    int64_t t_ns;
};

static void test_seconds(void **unused) {
    (void)unused;
    const struct seconds_case cases[] = {{"1311868163.8697", true, 1311868163869700000},
                                         {"1.311868163869700000e+09", true, 1311868163869700000},
                                         {"1311868163869.7e-3", true, 1311868163869700000},
                                         {"0", true, 0},
                                         {"-0.0", true, 0},
                                         {"0.010912", true, 10912000},
                                         {"1", true, 1000000000},
                                         {"1.", true, 1000000000},
                                         {".5", true, 500000000},
                                         {"0.0000000005", true, 1},
                                         {"0.00000000049999999999999", true, 0},
                                         {"-0.0000000005", true, -1},
                                         {"1.0000000005", true, 1000000001},
                                         {"1.00000000149999", true, 1000000001},
                                         {"-1.0000000015", true, -1000000002},
                                         {"5e-10", true, 1},
                                         {"4e-10", true, 0},
                                         {"5e-11", true, 0},
                                         {"5e-100000000000", true, 0},
                                         {"0e100000000000", true, 0},
                                         {"9223372036.854775807", true, INT64_MAX},
                                         {"9223372036.854775808", false, 0},
                                         {"9223372036.8547758075", false, 0},
                                         {"1e10", false, 0},
                                         {"1e100000000000", false, 0},
                                         {"1000000000000000000000000", false, 0},
                                         {"", false, 0},
                                         {"1e", false, 0},
                                         {"nan", false, 0},
                                         {"1,5", false, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        int64_t t_ns = 0;
        bool ok = ap_decimal_seconds_ns(cases[i].text, strlen(cases[i].text), &t_ns);
        if (ok != cases[i].ok || t_ns != cases[i].t_ns)
            fail_msg("'%s': %d %" PRId64 ", expected %d %" PRId64 ", exactly", cases[i].text, ok,
                     t_ns, cases[i].ok, cases[i].t_ns);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_doubles_of_odd_texts),
        cmocka_unit_test(test_doubles_at_random),
        cmocka_unit_test(test_seconds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
