#ifndef ANTIPODE_APP_PROGRESS_H
#define ANTIPODE_APP_PROGRESS_H

#include <stdint.h>

// A bar on standard error where that is a terminal; else a line at each quarter.
void ap_progress_show(const char *label, int64_t done, int64_t total);

// Ends the bar's line.
void ap_progress_end(void);

#endif
