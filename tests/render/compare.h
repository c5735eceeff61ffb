#ifndef ANTIPODE_TESTS_RENDER_COMPARE_H
#define ANTIPODE_TESTS_RENDER_COMPARE_H

#include "tests/render/probe.h"
#include "tests/render/reference.h"

// The renderer's pictures against the reference, pixel by pixel.

struct compare_values {
    float *at;
    size_t count, room;
};
// The share q of the values is not above this; 0 of none. Sorts.
double compare_quantile(struct compare_values *values, double q);

struct compare_tally {
    int place; // that is looked from
    long frames, pixels;
    // Pixels where something else is drawn than is to be seen; how many pixels off an outline is
    // that explains it (INFINITY: none within COMPARE_REACH_PX).
    struct compare_values edge_px;
    // Likewise where the line of sight does meet what is drawn, but behind something that an
    // outline so far off does not explain: where two surfaces meet, or lie close together.
    struct compare_values seam_px;
    // Where the same is drawn: |depth − truth| over the truth, along the line of sight.
    struct compare_values depth;
    // Native: how far from its true direction the drawn point of a surface is seen.
    struct compare_values direction_px, direction_arcmin;
    struct compare_values near_px; // likewise within COMPARE_NEAR_M of the eye
    struct compare_values bare_px; // likewise of what is round and bears no pattern
    long strange;                  // pixels of what is not in the world
    // Where a tenth of rho or less of native view's line is left to the nose's antipode: pixels,
    // those that differ, and those farther off than the bound.
    long antipode, antipode_differ, antipode_off;
    char worst_edge[96], worst_seam[96], worst_direction[96]; // where and what
    double most_edge_px, most_seam_px, most_direction_px;
    long beyond; // 1: the renderer itself said that it could not hold the bound
};
void compare_tally_add(struct compare_tally *sum, const struct compare_tally *more);
void compare_tally_finish(struct compare_tally *tally);

#define COMPARE_REACH_PX 3.0
#define COMPARE_NEAR_M 0.05

// Draws both eyes and looks for both. False: an eye is inside of something, and nothing was done.
// pictures: NULL, or the beginning of names of PNG files to write: drawn, truth, both.
bool compare_frame(struct probe *probe, struct probe_world *world,
                   const struct ap_frame_input *input, double max_error_px, const char *pictures,
                   struct compare_tally *tally);

#endif
