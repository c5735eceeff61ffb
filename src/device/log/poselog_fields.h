#ifndef ANTIPODE_DEVICE_LOG_POSELOG_FIELDS_H
#define ANTIPODE_DEVICE_LOG_POSELOG_FIELDS_H

#include "src/device/log/poselog_format.h"

// What the formats share: taking a line apart and reading its fields, each with its message.

// The number of fields, of which the first `max` are stored. Blanks around commas do not count.
size_t ap_split_commas(const char *line, size_t len, struct ap_field *fields, size_t max);
size_t ap_split_blanks(const char *line, size_t len, struct ap_field *fields, size_t max);

bool ap_field_number(const char *line, struct ap_field f, const char *name, double *value,
                     struct ap_bad_line *bad);

// Checks the range of a time that was read, or not, from the field at `at`.
bool ap_field_time(const char *line, const char *at, bool read, int64_t t_ns, const char *unit,
                   struct ap_bad_line *bad);

// Checks and renormalises; `at` is the quaternion's first field.
bool ap_field_quat(const char *line, const char *at, struct ap_quat *q, struct ap_bad_line *bad);

#endif
