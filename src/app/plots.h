#ifndef ANTIPODE_APP_PLOTS_H
#define ANTIPODE_APP_PLOTS_H

#include <stdio.h>

#include "src/app/vergence.h"
#include "src/track/tracker.h"

// The pages' drawings: inline SVG, no text from outside unescaped, the same bytes for the same
// arguments.

// The walk from above: the real table with the paths of head and hands, beside the virtual table
// with the virtual paths. Curved distances and directions from the table's centre are true (the log
// of the device's place), so straight lines that miss the centre look bent.
void ap_svg_walk(FILE *f, const struct ap_capture *capture);

// Vergence against true distance, and inferred against true distance: one capture's targets in
// their own colours over the curves of its space; or (several captures) each in one colour.
struct ap_measured {
    const struct ap_capture *capture;
    const struct ap_vergence_row *rows;
    size_t count;
};
void ap_svg_vergence(FILE *f, const struct ap_measured *sets, size_t count);

// A head that walks once round a square of side AP_LOOP_SIDE_M (forward, left, back, right) beside
// the table, without turning, while the hand rests; D = V_head⁻¹·V_hand.
#define AP_LOOP_SIDE_M 0.3
enum { AP_LOOP_STEPS = 160 };
struct ap_coherence {
    enum ap_tracker_kind kind;
    struct ap_space space;
    // How far the seen hand has left the felt one since the start, both as the head has them: the
    // change of log(D·base) − (the hand in the head's frame), and the turn of M(t)·M(0)⁻¹ with
    // M = D·(what the arm feels)⁻¹. At the end the arm is as it was.
    double offset_mm[AP_LOOP_STEPS + 1], turn_deg[AP_LOOP_STEPS + 1];
    // The largest entry of |D_last·D_first⁻¹ − X|: X = H⁻¹, H the product of the four translations,
    // in `naive`; the identity in the others.
    double defect;
};
// AP_INPUT: the radius is so small that doubles do not hold the loop's places to 1e-6.
enum ap_status ap_coherence_walk(struct ap_error *err, struct ap_space space,
                                 enum ap_tracker_kind kind, struct ap_coherence *out);

// The three trackers in one space: two charts and a table of numbers; a sentence where doubles end.
enum ap_status ap_svg_coherence(struct ap_error *err, FILE *f, struct ap_space space);

#endif
