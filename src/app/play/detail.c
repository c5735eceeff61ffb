#include "src/app/play/detail.h"

#include <math.h>

enum { SETTLE_FRAMES = 12, CALM_FRAMES = 90, MOST_PATIENCE = 10000 };

// Each level costs 0.4 to 0.7 of the one before: by its pixels, by one sample a pixel instead of
// four, which is cheaper at more pixels, or by materials and shadows (docs/performance.md).
static const struct {
    double scale;
    bool plain;
    unsigned samples;
} levels[AP_DETAIL_LEVELS] = {{1, false, 0},    {0.84, false, 0}, {0.71, false, 0},
                              {0.59, false, 0}, {0.71, false, 1}, {0.71, true, 1},
                              {0.5, true, 1}};

void ap_detail_init(struct ap_detail *detail, bool automatic, double budget_ms) {
    *detail =
        (struct ap_detail){.automatic = automatic, .budget_ms = budget_ms, .patience = CALM_FRAMES};
}

double ap_detail_scale(const struct ap_detail *detail) {
    return levels[detail->level].scale;
}

bool ap_detail_plain(const struct ap_detail *detail) {
    return levels[detail->level].plain;
}

unsigned ap_detail_samples(const struct ap_detail *detail) {
    return levels[detail->level].samples;
}

static bool change(struct ap_detail *detail, int by) {
    detail->level += by;
    detail->frames = 0;
    detail->slow_ms = 0;
    return true;
}

bool ap_detail_step(struct ap_detail *detail, double frame_ms) {
    if (!detail->automatic || !isfinite(frame_ms) || frame_ms < 0)
        return false;
    detail->frames++;
    // The first frames after a change pay for it.
    if (detail->frames <= 3)
        return false;
    detail->slow_ms =
        detail->slow_ms > 0 ? detail->slow_ms + 0.1 * (frame_ms - detail->slow_ms) : frame_ms;
    if (detail->frames < SETTLE_FRAMES)
        return false;
    if (detail->slow_ms > detail->budget_ms && detail->level < AP_DETAIL_LEVELS - 1) {
        if (detail->patience < MOST_PATIENCE)
            detail->patience *= 2;
        return change(detail, 1);
    }
    // A step up costs about 1/0.7: only where that would leave a margin.
    bool calm = detail->frames > detail->patience && detail->slow_ms < 0.6 * detail->budget_ms;
    return calm && detail->level > 0 && change(detail, -1);
}

double ap_detail_error_px(const struct ap_detail *detail) {
    static const double error_px[AP_DETAIL_LEVELS] = {0, 0.5, 1, 1, 2, 2, 2};
    return error_px[detail->level];
}
