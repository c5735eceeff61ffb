#ifndef ANTIPODE_IMAGE_TEXT_H
#define ANTIPODE_IMAGE_TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "src/base/status.h"

// Text in pictures: FreeType draws, fontconfig finds the font. Outlines are not hinted, so a text
// is the same bytes on every machine that has the same font file. One thread per font.

// 8-bit R,G,B,A, row 0 at the top; colours are sRGB and not multiplied by alpha, which is straight
// coverage (OpenXR: XR_COMPOSITION_LAYER_UNPREMULTIPLIED_ALPHA_BIT,
// BLEND_TEXTURE_SOURCE_ALPHA_BIT).
struct ap_canvas {
    uint32_t width, height;
    uint8_t *rgba; // 4·width·height
};

// Transparent pixels. AP_INPUT for a size of 0 or over 8192, AP_ENVIRONMENT without memory.
enum ap_status ap_canvas_create(struct ap_error *err, uint32_t width, uint32_t height,
                                struct ap_canvas *canvas);
void ap_canvas_finish(struct ap_canvas *canvas);

// Every pixel of the box, cut at the picture's edges, becomes this colour.
void ap_canvas_fill(struct ap_canvas *canvas, int x, int y, int width, int height,
                    const uint8_t rgba[4]);

struct ap_font;

enum ap_font_weight { AP_FONT_REGULAR, AP_FONT_BOLD };

// A sans serif: DejaVu Sans where it is there, else what fontconfig has in its place. size_px: of
// the em, 4 to 1024. AP_ENVIRONMENT where there is no font at all (the sentence names the package).
enum ap_status ap_font_open(struct ap_error *err, enum ap_font_weight weight, double size_px,
                            struct ap_font **font);
void ap_font_close(struct ap_font *font);

// Another size of the same font; AP_INPUT outside 4 to 1024.
enum ap_status ap_font_resize(struct ap_error *err, struct ap_font *font, double size_px);

// From baseline to baseline, and from the baseline up to the tallest glyph and down to the lowest;
// pixels, all > 0.
struct ap_font_metrics {
    double line_px, ascent_px, descent_px;
};
struct ap_font_metrics ap_font_metrics(const struct ap_font *font);

// How far the pen moves. Text is UTF-8; a byte that is none, and a character that the font lacks,
// are drawn as the font's box.
double ap_text_width_px(struct ap_font *font, const char *text);

// Draws over what is there, blended in linear light; the pen starts at (x_px, baseline_px). What
// lies outside the canvas is left out.
void ap_text_draw(struct ap_font *font, struct ap_canvas *canvas, double x_px, double baseline_px,
                  const uint8_t rgb[3], const char *text);

// Short texts, each in the middle of a square cell and as large as fits the circle in it: for
// decals. Coverage, 0…255, cell after cell. AP_INPUT for cells outside 8 to 1024 pixels, or none.
struct ap_text_atlas {
    uint32_t cell_px, count;
    uint8_t *coverage; // count·cell_px·cell_px
};
enum ap_status ap_text_atlas_create(struct ap_error *err, const char *const *texts, uint32_t count,
                                    uint32_t cell_px, struct ap_text_atlas *atlas);
void ap_text_atlas_finish(struct ap_text_atlas *atlas);

// --- a panel: rows of columns, such as a menu, a score, a table of keys

enum { AP_PANEL_COLUMNS = 4 };

struct ap_panel_row {
    // Left to right; NULL or "": empty. A row with text in the first column only may run over the
    // others. A row without any is a gap of half a line.
    const char *cell[AP_PANEL_COLUMNS];
    uint8_t rgb[3]; // 0, 0, 0: the panel's
    bool heading;   // bold
    bool marked;    // on a bar of the panel's mark colour (what a menu has chosen)
};

struct ap_panel {
    double size_px;         // of the em; made smaller where the rows would not fit, never larger
    double padding_px;      // all round
    uint8_t text_rgb[3];    // 0, 0, 0: nearly white
    uint8_t ground_rgba[4]; // alpha 0: none
    uint8_t mark_rgba[4];
    const struct ap_panel_row *rows;
    size_t row_count;
};

// Clears the canvas and lays the rows out from its top: each column as wide as its widest cell, all
// on one grid. *size_px (may be NULL): what the size had to become. AP_INPUT where not even 4
// pixels fit.
enum ap_status ap_panel_draw(struct ap_error *err, const struct ap_panel *panel,
                             struct ap_canvas *canvas, double *size_px);

#endif
