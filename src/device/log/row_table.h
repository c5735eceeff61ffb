#ifndef ANTIPODE_DEVICE_LOG_ROW_TABLE_H
#define ANTIPODE_DEVICE_LOG_ROW_TABLE_H

#include "src/device/log/poselog_format.h"

// Rows of a log that is read as a whole (JSON, BSOR) before the first one is given: its devices
// stand one behind the other in the file, not by time.

struct ap_row_table;

enum { AP_ROW_TABLE_DEVICES_MAX = 64 };

struct ap_table_row {
    int64_t t_ns;
    int64_t frame; // where in the file, for messages
    struct ap_pose pose;
    float trigger, squeeze;
    int device;
    bool select;
};

// NULL where there is no memory.
struct ap_row_table *ap_row_table_create(void);
void ap_row_table_destroy(struct ap_row_table *table);

// The number of the device of that name, which is made where it is new; −1 where there are too many
// or the name cannot be one.
int ap_row_table_device(struct ap_row_table *table, const char *name);

// False: no memory.
bool ap_row_table_add(struct ap_row_table *table, const struct ap_table_row *row);
size_t ap_row_table_count(const struct ap_row_table *table);

// By time; what is equal stays in the order in which it came.
void ap_row_table_sort(struct ap_row_table *table);

// The next row; the device's name stays as long as the table. False at the end.
bool ap_row_table_take(struct ap_row_table *table, struct ap_row *row, int64_t *frame);

#endif
