#ifndef ANTIPODE_DEVICE_LOG_DECIMAL_H
#define ANTIPODE_DEVICE_LOG_DECIMAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// Numbers of pose logs. A log of millions of lines spends its time here, so the common cases have
// a fast path; the answers are those of src/base/number.h, bit for bit (tests/device compares).

// As ap_parse_double: decimal, finite, the nearest double.
bool ap_decimal_double(const char *text, size_t len, double *value);

// Decimal seconds to nanoseconds, from the text itself and not through a double (whose step is 238
// ns at today's Unix time): halves away from zero. False where not a number or beyond int64.
bool ap_decimal_seconds_ns(const char *text, size_t len, int64_t *t_ns);

#endif
