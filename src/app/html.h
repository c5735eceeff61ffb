#ifndef ANTIPODE_APP_HTML_H
#define ANTIPODE_APP_HTML_H

#include <stdio.h>

#include "src/app/capture_dir.h"

// What the two pages have in common. Write errors are left to the stream (ap_outfile_commit reports
// them). The bytes depend on the arguments only.

// As text of an element or of a quoted attribute: markup escaped, control characters and whatever
// is not UTF-8 replaced. Everything that came from outside goes through here.
void ap_html_text(FILE *f, const char *text);

// From <!doctype> to the opened <main>, with the style sheet; and the script with the closing tags.
void ap_html_begin(FILE *f, const char *title);
void ap_html_end(FILE *f);

// "hyperbolic space"; and what it is like there, a paragraph of HTML of our own.
const char *ap_html_space_title(struct ap_space space);
void ap_html_space_text(FILE *f, struct ap_space space);

// What native and tourist view are, in a sentence.
void ap_html_view_text(FILE *f, struct ap_space space, enum ap_view_mode view, double ipd_m);

// A figure with the captured pairs inside, as data URIs at most width_px wide; as many of them,
// evenly chosen, as fit into budget bytes. All viewers of a page move together, under one
// ap_html_controls. AP_INPUT where a picture is broken.
struct ap_html_viewer {
    uint32_t width_px;
    size_t budget;
};
enum ap_status ap_html_viewer_write(struct ap_error *err, FILE *f, const struct ap_capture *capture,
                                    const struct ap_html_viewer *viewer);
void ap_html_controls(FILE *f);

#endif
