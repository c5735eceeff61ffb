#include "src/device/log/poselog_document.h"

#include <string.h>

static const unsigned char BSOR_MAGIC[4] = {0x69, 0x3d, 0x2d, 0x44};

static bool is_bsor(const char *bytes, size_t len) {
    return len >= sizeof BSOR_MAGIC && memcmp(bytes, BSOR_MAGIC, sizeof BSOR_MAGIC) == 0;
}

static size_t byte_order_mark(const char *bytes, size_t len) {
    return len >= 3 && memcmp(bytes, "\xef\xbb\xbf", 3) == 0 ? 3 : 0;
}

bool ap_log_is_document(const char *bytes, size_t len) {
    size_t at = byte_order_mark(bytes, len);
    while (at < len &&
           (bytes[at] == ' ' || bytes[at] == '\t' || bytes[at] == '\r' || bytes[at] == '\n'))
        at++;
    return is_bsor(bytes, len) || (at < len && bytes[at] == '{');
}

enum ap_status ap_document_reject(struct ap_error *err, struct ap_document *document,
                                  const struct ap_error *why) {
    if (!document->skip_bad)
        return ap_fail(err, AP_INPUT, "%s", why->text);
    document->skipped++;
    return AP_OK;
}

enum ap_status ap_document_add(struct ap_error *err, struct ap_document *document, const char *name,
                               struct ap_table_row row) {
    row.device = ap_row_table_device(document->table, name);
    if (row.device < 0)
        return ap_fail(err, AP_INPUT, "'%.64s': expected at most %d devices, with names as in CSV",
                       name, AP_ROW_TABLE_DEVICES_MAX);
    return ap_row_table_add(document->table, &row)
               ? AP_OK
               : ap_fail(err, AP_ENVIRONMENT, "%s: out of memory", document->file);
}

// Both begin with a brace; IWER's has a schema, which says what stands in its frames.
static enum ap_status read_json(struct ap_error *err, struct ap_document *d, const char *bytes,
                                size_t len) {
    size_t mark = byte_order_mark(bytes, len);
    json_t *root;
    enum ap_status st = ap_json_parse(err, d->file, bytes + mark, len - mark, &root);
    if (st)
        return st;
    struct ap_json_at at = ap_json_root(root, d->file);
    st = ap_json_has(&at, "schema") ? ap_iwer_read_poses(err, d, &at) : ap_aframe_read(err, d, &at);
    json_decref(root);
    return st;
}

enum ap_status ap_log_document_read(struct ap_error *err, const char *file, const char *bytes,
                                    size_t len, bool skip_bad, struct ap_row_table **table,
                                    int64_t *skipped) {
    struct ap_document d = {.file = file, .skip_bad = skip_bad, .table = ap_row_table_create()};
    if (!d.table)
        return ap_fail(err, AP_ENVIRONMENT, "%s: out of memory", file);
    enum ap_status st =
        is_bsor(bytes, len) ? ap_bsor_read(err, &d, bytes, len) : read_json(err, &d, bytes, len);
    if (!st && !ap_row_table_count(d.table))
        st = ap_fail(err, AP_INPUT, "%s: no pose in it", file);
    if (st) {
        ap_row_table_destroy(d.table);
        return st;
    }
    ap_row_table_sort(d.table);
    *table = d.table;
    *skipped += d.skipped;
    return AP_OK;
}
