#ifndef ANTIPODE_APP_GNUPLOT_H
#define ANTIPODE_APP_GNUPLOT_H

#include <stdio.h>

#include "src/base/status.h"

// Runs gnuplot, where it is installed, on a script that sets a terminal and no output: what it
// draws becomes the file at `path`, whole or not at all. Where it is not, or fails, a warning says
// so and an older picture of that name is removed, for it would not be of these numbers. Reads the
// script from its start. AP_ENVIRONMENT where `path` cannot be written.
enum ap_status ap_gnuplot(struct ap_error *err, FILE *script, const char *path);

#endif
