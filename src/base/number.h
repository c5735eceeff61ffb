#ifndef ANTIPODE_BASE_NUMBER_H
#define ANTIPODE_BASE_NUMBER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// Numbers as text, the same in every locale. `text[0..len)` need not be NUL-terminated and must be
// the number and nothing else; no leading or trailing blanks.

// Decimal, finite: [+-]digits[.digits][(e|E)[+-]digits]. Read as the nearest double. No "inf",
// "nan" or hexadecimal, no overflow to infinity; underflow gives the nearest subnormal or zero.
bool ap_parse_double(const char *text, size_t len, double *value);

// Decimal, signed 64 bits, overflow refused.
bool ap_parse_int64(const char *text, size_t len, int64_t *value);

enum { AP_DOUBLE_TEXT_MAX = 32 };

// 17 significant digits, as "%.17g" in the C locale; "inf", "-inf", "nan". Returns the length.
size_t ap_format_double(char text[AP_DOUBLE_TEXT_MAX], double value);

#endif
