#ifndef ANTIPODE_APP_PLAY_DETAIL_H
#define ANTIPODE_APP_PLAY_DETAIL_H

#include <stdbool.h>

// How finely to draw so that the frame rate holds: a share of the headset's pixels, plain surfaces,
// edges with steps, chosen by how long the last frames took. Pure; slow to change, and slower to go
// up than down, so that it does not swing.
struct ap_detail {
    bool automatic;
    double budget_ms; // a frame may take so long
    int level;        // 0: every pixel
    double slow_ms;   // smoothed duration
    int frames;       // since the level changed
    int patience;     // frames of calm before the next step up; doubles when a step up failed
};

enum { AP_DETAIL_LEVELS = 7 };

void ap_detail_init(struct ap_detail *detail, bool automatic, double budget_ms);

// A frame took so long. True where the level changed.
bool ap_detail_step(struct ap_detail *detail, double frame_ms);

// Of width and height: 1, 0.84, 0.71, 0.59, 0.71, 0.71, 0.5.
double ap_detail_scale(const struct ap_detail *detail);
// Without materials, numbers and shadows: the last two levels.
bool ap_detail_plain(const struct ap_detail *detail);
// Samples a pixel: 1 in the last three levels; else 0, as many as usual.
unsigned ap_detail_samples(const struct ap_detail *detail);
// The error bound that goes with it, px of what is drawn: none of its own (0), then 0.5 to 2.
double ap_detail_error_px(const struct ap_detail *detail);

#endif
