#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include <float.h>
#include <locale.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/number.h"
#include "src/base/range.h"

static void reads_decimals(void **state) {
    (void)state;
    static const struct {
        const char *text;
        double value;
    } good[] = {{"0", 0},
                {"-0.5", -0.5},
                {"+1.", 1},
                {".25e2", 25},
                {"1e-400", 0},
                {"1.7976931348623157e308", DBL_MAX},
                {"4.9406564584124654e-324", 4.9406564584124654e-324},
                {"0.1000000000000000055511151231257827021181583404541015625", 0.1}};
    for (size_t i = 0; i < sizeof good / sizeof good[0]; i++) {
        double v = 42;
        assert_true(ap_parse_double(good[i].text, strlen(good[i].text), &v));
        assert_memory_equal(&v, &good[i].value, sizeof v);
    }
}

static void refuses_what_is_no_decimal(void **state) {
    (void)state;
    static const char *const bad[] = {"",   ".",  "e5",  "1e",  "1e+",   "0x10", "inf", "nan",
                                      "1 ", " 1", "1,5", "--1", "1e999", "1_0",  "+",   "-.e1"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        double v = 42;
        assert_false(ap_parse_double(bad[i], strlen(bad[i]), &v));
        assert_true(v == 42);
    }
}

static void text_and_back_is_exact_in_any_locale(void **state) {
    (void)state;
    setlocale(LC_ALL, "de_DE.UTF-8"); // a decimal comma, where the machine has it
    uint64_t x = 88172645463325252u;
    for (int i = 0; i < 100000; i++) {
        x ^= x << 13, x ^= x >> 7, x ^= x << 17;
        double v, back;
        memcpy(&v, &x, sizeof v);
        if (!isfinite(v))
            continue;
        char text[AP_DOUBLE_TEXT_MAX];
        size_t n = ap_format_double(text, v);
        assert_true(n < AP_DOUBLE_TEXT_MAX && text[n] == '\0');
        assert_true(ap_parse_double(text, n, &back));
        assert_memory_equal(&v, &back, sizeof v);
    }
    setlocale(LC_ALL, "C");
}

static void reads_integers_to_the_limits(void **state) {
    (void)state;
    int64_t v = 0;
    assert_true(ap_parse_int64("9223372036854775807", 19, &v) && v == INT64_MAX);
    assert_true(ap_parse_int64("-9223372036854775808", 20, &v) && v == INT64_MIN);
    assert_true(ap_parse_int64("+17", 3, &v) && v == 17);
    assert_false(ap_parse_int64("9223372036854775808", 19, &v));
    assert_false(ap_parse_int64("-9223372036854775809", 20, &v));
    assert_false(ap_parse_int64("", 0, &v));
    assert_false(ap_parse_int64("-", 1, &v));
    assert_false(ap_parse_int64("1.0", 3, &v));
    assert_true(v == 17);
}

static void reads_ranges(void **state) {
    (void)state;
    struct ap_range r;
    assert_int_equal(ap_range_parse(NULL, "3:10:2", &r), AP_OK);
    assert_true(r.first == 3 && r.end == 10 && r.step == 2);
    assert_true(ap_range_has(r, 9) && !ap_range_has(r, 10) && !ap_range_has(r, 4));
    assert_int_equal(ap_range_parse(NULL, "::", &r), AP_OK);
    assert_true(r.first == 0 && r.end == INT64_MAX && r.step == 1);
    assert_int_equal(ap_range_parse(NULL, ":5", &r), AP_OK);
    assert_true(r.end == 5);
    static const char *const bad[] = {"", "5", "1:2:0", "-1:", "a:b", "1:2:3:4", "1:2:-1", ":-3"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        assert_int_equal(ap_range_parse(NULL, bad[i], &r), AP_USAGE);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reads_decimals),
        cmocka_unit_test(refuses_what_is_no_decimal),
        cmocka_unit_test(text_and_back_is_exact_in_any_locale),
        cmocka_unit_test(reads_integers_to_the_limits),
        cmocka_unit_test(reads_ranges),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
