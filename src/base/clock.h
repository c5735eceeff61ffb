#ifndef ANTIPODE_BASE_CLOCK_H
#define ANTIPODE_BASE_CLOCK_H

#include <stdint.h>

// Nanoseconds of the machine's monotonic clock (CLOCK_MONOTONIC). Never fails; any thread.
int64_t ap_clock_now_ns(void);

// Sleeps until ap_clock_now_ns() >= t_ns; returns at once where it already is. Signals do not
// shorten it.
void ap_clock_sleep_until_ns(int64_t t_ns);

#endif
