#include "src/app/logs.h"

#include <string.h>

#include "src/base/log.h"
#include "src/track/setup.h"

enum ap_status ap_logs_open(struct ap_error *err, const struct ap_log_options *options,
                            char *const *logs, int count, struct ap_poselog **log) {
    struct ap_poselog_params params = {.sources = (const char *const *)logs,
                                       .source_count = (size_t)count,
                                       .z_up = strcmp(options->up, "z") == 0,
                                       .head_frame = strcmp(options->head_frame, "optical") == 0
                                                         ? AP_HEAD_FRAME_OPTICAL
                                                         : AP_HEAD_FRAME_HEAD,
                                       .skip_bad = options->skip_bad,
                                       .has_table = options->table_at != NULL};
    enum ap_status st = AP_OK;
    if (options->table_at)
        st = ap_table_at_parse(err, options->table_at, &params.table_x_m, &params.table_z_m,
                               &params.table_yaw_rad);
    return st ? st : ap_poselog_open(err, &params, log);
}

void ap_logs_warn_skipped(const struct ap_poselog *log) {
    int64_t skipped = ap_poselog_skipped(log);
    if (skipped > 0)
        ap_log(AP_LOG_WARNING, "%lld bad line%s skipped", (long long)skipped,
               skipped == 1 ? " was" : "s were");
}
