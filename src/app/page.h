#ifndef ANTIPODE_APP_PAGE_H
#define ANTIPODE_APP_PAGE_H

#include "src/app/command.h"
#include "src/app/vergence.h"

// Writes, from the left/right PNGs of the captured frames: NNNNNN-sbs.png, NNNNNN-anaglyph.png and
// contact.png. Frames whose pictures are missing (an interrupted run) are passed over. done/total
// count up for a progress bar; progress may be NULL; step is called by one thread at a time. Eyes
// of different sizes are put on black of a common size; in the anaglyph the right eye's picture is
// moved sideways until what is straight ahead at infinity coincides. Works on two threads.
struct ap_progress {
    void (*step)(void *data, int64_t done, int64_t total);
    void *data;
};
enum ap_status ap_pictures_write(struct ap_error *err, const struct ap_capture *capture,
                                 const struct ap_progress *progress);

// DIR/index.html: self-contained (pictures and plots inside as data URIs), a page a person enjoys.
enum ap_status ap_page_write(struct ap_error *err, const struct ap_capture *capture,
                             const struct ap_vergence_row *rows, size_t count);

// One page over several captures (the demo's h3, s3 and e3), with the three trackers side by side.
// Takes the measurements from each DIR/vergence.csv.
enum ap_status ap_tour_page_write(struct ap_error *err, const char *path,
                                  const struct ap_capture *captures, size_t count);

// `antipode page --out FILE DIR…`: the tour page over captures that are there.
extern const struct ap_command ap_command_page;

#endif
