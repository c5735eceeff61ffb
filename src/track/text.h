#ifndef ANTIPODE_TRACK_TEXT_H
#define ANTIPODE_TRACK_TEXT_H

#include <stddef.h>

#include "src/geom/isometry.h"

enum { AP_ISO_TEXT_MAX = 16 * 33 };

// The 16 numbers row by row, each as ap_format_double writes it (17 significant digits), with
// commas between them; no NUL at the end. Returns the length. The hot spot of `track`: entries of
// ordinary size go through 128-bit integers, to the same bytes in a quarter of the time (874 to
// 3161 ns a row).
size_t ap_iso_text(char text[AP_ISO_TEXT_MAX], const struct ap_iso *m);

// One of them, at most AP_DOUBLE_TEXT_MAX bytes.
size_t ap_number_text(char *text, double value);

#endif
