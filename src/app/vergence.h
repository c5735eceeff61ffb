#ifndef ANTIPODE_APP_VERGENCE_H
#define ANTIPODE_APP_VERGENCE_H

#include "src/app/capture_dir.h"

// What the two eyes' pictures say about distance: every target in every captured pair, the exact
// vergence beside the one measured from the pixels. docs/vergence.md has the definitions.
struct ap_vergence_row {
    int64_t frame;
    int target;             // index into capture->targets
    int image;              // 0; 1 where s3's long way round is what the eyes see
    double true_m;          // along the geodesic
    double exact_arcmin;    // NAN where undefined
    double measured_arcmin; // NAN where cut or hidden
    double error_px;        // NAN with it
    double inferred_m;      // INFINITY where vergence ≤ 0, NAN where not measured
};

// Reads the pictures. Frames whose pictures are missing (an interrupted run) are passed over with a
// warning; AP_INPUT where a picture is broken or has not the headset's size. *rows malloc'ed, the
// caller frees.
enum ap_status ap_vergence_measure(struct ap_error *err, const struct ap_capture *capture,
                                   struct ap_vergence_row **rows, size_t *count);

// Writes DIR/vergence.csv and DIR/vergence.png (by gnuplot, where it is installed; a warning where
// not).
enum ap_status ap_vergence_write(struct ap_error *err, const struct ap_capture *capture,
                                 const struct ap_vergence_row *rows, size_t count);

// DIR/vergence.csv read back; no rows where there is no such file. `image` comes from true_m.
enum ap_status ap_vergence_read(struct ap_error *err, const struct ap_capture *capture,
                                struct ap_vergence_row **rows, size_t *count);

// A line per target on standard output: how often it was measured, how far off at worst.
void ap_vergence_print_summary(const struct ap_capture *capture, const struct ap_vergence_row *rows,
                               size_t count);

// What the summary and the page say of one target.
struct ap_vergence_summary {
    size_t frames, measured;
    double worst_px;                  // largest |error_px|; 0 where nothing was measured
    double least_m, most_m;           // true distance
    double least_arcmin, most_arcmin; // exact vergence of the measured rows; NAN without
};
struct ap_vergence_summary ap_vergence_summarize(const struct ap_vergence_row *rows, size_t count,
                                                 int target);

#endif
