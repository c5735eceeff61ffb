#include "src/base/range.h"

#include <string.h>

#include "src/base/number.h"

enum ap_status ap_range_parse(struct ap_error *err, const char *text, struct ap_range *range) {
    struct ap_range r = AP_RANGE_ALL;
    int64_t *const parts[3] = {&r.first, &r.end, &r.step};
    const char *p = text;
    int i = 0;
    bool good = strchr(text, ':') != NULL;
    for (; good && i < 3; i++) {
        size_t len = strcspn(p, ":");
        if (len > 0)
            good = ap_parse_int64(p, len, parts[i]);
        p += len;
        if (*p == '\0')
            break;
        p++;
    }
    if (!good || i == 3 || r.first < 0 || r.end < 0 || r.step < 1)
        return ap_fail(err, AP_USAGE,
                       "'%s' is no range of frames: expected A:B:STEP (half open; each part may be "
                       "left out; STEP at least 1)",
                       text);
    *range = r;
    return AP_OK;
}
