#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "src/base/utf8.h"

static void test_tidy(void **state) {
    (void)state;
    static const char *const rows[][2] = {
        {"", ""},
        {"Sony WH-1000XM5", "Sony WH-1000XM5"},
        {"Ger\xc3\xa4t \xe2\x80\x94 \xf0\x9f\x8e\xb1",
         "Ger\xc3\xa4t \xe2\x80\x94 \xf0\x9f\x8e\xb1"},
        {"a\x1b[2Jb", "a?[2Jb"},
        {"line\nE: 0", "line?E: 0"},
        {"del\x7f", "del?"},
        {"csi\xc2\x9b"
         "2J",
         "csi?2J"},
        {"caf\xe9", "caf?"},
        {"\xe9\xa0", "??"},
        {"\xc0\xaf", "??"},
        {"\xed\xa0\x80", "???"},
        {"\xf4\x90\x80\x80", "????"},
        {"\xff", "?"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[64];
        snprintf(text, sizeof text, "%s", rows[i][0]);
        ap_utf8_tidy(text);
        assert_string_equal(text, rows[i][1]);
    }
}

static void test_length(void **state) {
    (void)state;
    assert_int_equal(ap_utf8_length("a"), 1);
    assert_int_equal(ap_utf8_length("\xc3\xa4"), 2);
    assert_int_equal(ap_utf8_length("\xe2\x80\x94"), 3);
    assert_int_equal(ap_utf8_length("\xf0\x9f\x8e\xb1"), 4);
    assert_int_equal(ap_utf8_length("\xe0\x9f\xbf"), 0);
    assert_int_equal(ap_utf8_length("\xf0\x8f\xbf\xbf"), 0);
    assert_int_equal(ap_utf8_length("\xc3"), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_tidy), cmocka_unit_test(test_length)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
