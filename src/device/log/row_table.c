#include "src/device/log/row_table.h"

#include <stdlib.h>
#include <string.h>

struct entry {
    struct ap_table_row row;
    size_t order;
};

struct ap_row_table {
    struct entry *entries;
    size_t count, room, given;
    int device_count;
    char names[AP_ROW_TABLE_DEVICES_MAX][AP_LOG_DEVICE_NAME_MAX];
};

struct ap_row_table *ap_row_table_create(void) {
    return calloc(1, sizeof(struct ap_row_table));
}

void ap_row_table_destroy(struct ap_row_table *table) {
    if (!table)
        return;
    free(table->entries);
    free(table);
}

int ap_row_table_device(struct ap_row_table *table, const char *name) {
    size_t len = strlen(name);
    for (int i = 0; i < table->device_count; i++)
        if (strcmp(table->names[i], name) == 0)
            return i;
    if (table->device_count == AP_ROW_TABLE_DEVICES_MAX ||
        !ap_log_device_name_ok((struct ap_field){name, len}))
        return -1;
    memcpy(table->names[table->device_count], name, len + 1);
    return table->device_count++;
}

bool ap_row_table_add(struct ap_row_table *table, const struct ap_table_row *row) {
    if (table->count == table->room) {
        size_t room = table->room ? 2 * table->room : 256;
        struct entry *more = reallocarray(table->entries, room, sizeof *more);
        if (!more)
            return false;
        table->entries = more;
        table->room = room;
    }
    table->entries[table->count] = (struct entry){*row, table->count};
    table->count++;
    return true;
}

size_t ap_row_table_count(const struct ap_row_table *table) {
    return table->count;
}

static int by_time(const void *a, const void *b) {
    const struct entry *p = a, *q = b;
    if (p->row.t_ns != q->row.t_ns)
        return p->row.t_ns < q->row.t_ns ? -1 : 1;
    return p->order < q->order ? -1 : p->order > q->order;
}

void ap_row_table_sort(struct ap_row_table *table) {
    if (table->count)
        qsort(table->entries, table->count, sizeof *table->entries, by_time);
}

bool ap_row_table_take(struct ap_row_table *table, struct ap_row *row, int64_t *frame) {
    if (table->given == table->count)
        return false;
    const struct ap_table_row *r = &table->entries[table->given++].row;
    const char *name = table->names[r->device];
    *row = (struct ap_row){.t_ns = r->t_ns,
                           .device = {name, strlen(name)},
                           .pose = r->pose,
                           .trigger = r->trigger,
                           .squeeze = r->squeeze,
                           .select = r->select,
                           .t_column = 1,
                           .device_column = 1};
    *frame = r->frame;
    return true;
}
