#ifndef ANTIPODE_APP_VERGENCE_H
#define ANTIPODE_APP_VERGENCE_H

#include "src/app/capture_dir.h"

// Measures every target in every captured pair, writes DIR/vergence.csv and DIR/vergence.png (by
// gnuplot, where it is installed; a warning where not).
struct ap_vergence_row {
    int64_t frame;
    int target;             // index into capture->targets
    int image;              // 0; 1 where s3's long way round is what the eyes see
    double true_m;          // along the geodesic
    double exact_arcmin;    // NAN where undefined
    double measured_arcmin; // NAN where cut or hidden
    double error_px;
    double inferred_m; // INFINITY where vergence ≤ 0
};

// *rows malloc'ed, the caller frees.
enum ap_status ap_vergence_measure(struct ap_error *err, const struct ap_capture *capture,
                                   struct ap_vergence_row **rows, size_t *count);
enum ap_status ap_vergence_write(struct ap_error *err, const struct ap_capture *capture,
                                 const struct ap_vergence_row *rows, size_t count);

#endif
