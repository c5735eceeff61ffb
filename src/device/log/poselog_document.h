#ifndef ANTIPODE_DEVICE_LOG_POSELOG_DOCUMENT_H
#define ANTIPODE_DEVICE_LOG_POSELOG_DOCUMENT_H

#include "src/base/json.h"
#include "src/device/log/row_table.h"

// Pose logs that are not lines: BSOR, and the JSON of IWER's recorder and of A-Frame's motion
// capture. Each is read as a whole. docs/pose-logs.md has the grammars.

enum { AP_LOG_DOCUMENT_MAX = 64 << 20 }; // bytes, unpacked

// By the first bytes, after blanks and a byte order mark.
bool ap_log_is_document(const char *bytes, size_t len);

// Reads the document's rows into a table, by time. `bytes` are NUL-terminated beyond len. AP_INPUT:
// where and what was expected. With skip_bad what is bad in one frame costs that frame, and is
// counted in *skipped; what says where the frames are must be right.
enum ap_status ap_log_document_read(struct ap_error *err, const char *file, const char *bytes,
                                    size_t len, bool skip_bad, struct ap_row_table **table,
                                    int64_t *skipped);

// What the readers of the formats share.
struct ap_document {
    const char *file;
    bool skip_bad;
    int64_t skipped;
    struct ap_row_table *table;
};

// A frame is bad: AP_OK, counted, with skip_bad; else AP_INPUT with the sentence in `why`.
enum ap_status ap_document_reject(struct ap_error *err, struct ap_document *document,
                                  const struct ap_error *why);

// One row of the device `name`. AP_ENVIRONMENT without memory, AP_INPUT (without a place) where the
// name is none or one too many.
enum ap_status ap_document_add(struct ap_error *err, struct ap_document *document, const char *name,
                               struct ap_table_row row);

enum ap_status ap_bsor_read(struct ap_error *err, struct ap_document *document, const char *bytes,
                            size_t len);
enum ap_status ap_iwer_read_poses(struct ap_error *err, struct ap_document *document,
                                  const struct ap_json_at *root);
enum ap_status ap_aframe_read(struct ap_error *err, struct ap_document *document,
                              const struct ap_json_at *root);

#endif
