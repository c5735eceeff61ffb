#include <math.h>
#include <string.h>

#include "src/image/text.h"

static const double COLUMN_GAP = 1.2, EMPTY_LINE = 0.5; // in ems; in lines
static const double SIZE_LEAST = 4;

struct layout {
    double column_px[AP_PANEL_COLUMNS]; // left edges
    double width_px, height_px;
};

static bool filled(const struct ap_panel_row *row, int column) {
    return row->cell[column] && row->cell[column][0];
}

static int last_column(const struct ap_panel_row *row) {
    int last = -1;
    for (int c = 0; c < AP_PANEL_COLUMNS; c++)
        if (filled(row, c))
            last = c;
    return last;
}

// fonts: regular, bold; of this size already.
static struct layout lay_out(const struct ap_panel *panel, struct ap_font *const fonts[2],
                             double size_px) {
    double widest[AP_PANEL_COLUMNS] = {0}, running = 0, lines = 0;
    for (size_t r = 0; r < panel->row_count; r++) {
        const struct ap_panel_row *row = &panel->rows[r];
        int last = last_column(row);
        lines += last < 0 ? EMPTY_LINE : 1;
        for (int c = 0; c <= last; c++) {
            double w = filled(row, c) ? ap_text_width_px(fonts[row->heading], row->cell[c]) : 0;
            if (last == 0)
                running = fmax(running, w);
            else
                widest[c] = fmax(widest[c], w);
        }
    }
    struct layout l = {.height_px = lines * ap_font_metrics(fonts[0]).line_px};
    double x = 0;
    for (int c = 0; c < AP_PANEL_COLUMNS; c++) {
        l.column_px[c] = x;
        if (widest[c] > 0) {
            l.width_px = x + widest[c];
            x += widest[c] + COLUMN_GAP * size_px;
        }
    }
    l.width_px = fmax(l.width_px, running);
    return l;
}

static enum ap_status resize(struct ap_error *err, struct ap_font *const fonts[2], double size_px) {
    enum ap_status st = ap_font_resize(err, fonts[0], size_px);
    return st ? st : ap_font_resize(err, fonts[1], size_px);
}

// The largest size up to the one asked for at which everything fits.
static enum ap_status fit(struct ap_error *err, const struct ap_panel *panel,
                          const struct ap_canvas *canvas, struct ap_font *const fonts[2],
                          double *size_px, struct layout *layout) {
    double across = canvas->width - 2 * panel->padding_px;
    double tall = canvas->height - 2 * panel->padding_px;
    for (double size = panel->size_px; size >= SIZE_LEAST; size *= 0.97) {
        enum ap_status st = resize(err, fonts, size);
        if (st)
            return st;
        *layout = lay_out(panel, fonts, size);
        *size_px = size;
        if (layout->width_px <= across && layout->height_px <= tall)
            return AP_OK;
    }
    return ap_fail(err, AP_INPUT,
                   "%zu rows do not fit a panel of %ux%u pixels: make it larger or say less",
                   panel->row_count, canvas->width, canvas->height);
}

static const uint8_t *text_color(const struct ap_panel *panel, const struct ap_panel_row *row) {
    static const uint8_t nearly_white[3] = {236, 238, 242};
    if (row->rgb[0] | row->rgb[1] | row->rgb[2])
        return row->rgb;
    bool given = panel->text_rgb[0] | panel->text_rgb[1] | panel->text_rgb[2];
    return given ? panel->text_rgb : nearly_white;
}

static void draw_rows(const struct ap_panel *panel, struct ap_font *const fonts[2],
                      const struct layout *layout, struct ap_canvas *canvas) {
    struct ap_font_metrics m = ap_font_metrics(fonts[0]);
    double y = panel->padding_px;
    for (size_t r = 0; r < panel->row_count; r++) {
        const struct ap_panel_row *row = &panel->rows[r];
        int last = last_column(row);
        double tall = m.line_px * (last < 0 ? EMPTY_LINE : 1);
        if (row->marked)
            ap_canvas_fill(canvas, (int)lround(panel->padding_px / 2), (int)lround(y),
                           (int)lround(canvas->width - panel->padding_px),
                           (int)(lround(y + tall) - lround(y)), panel->mark_rgba);
        double baseline = y + (tall - m.ascent_px - m.descent_px) / 2 + m.ascent_px;
        for (int c = 0; c <= last; c++)
            if (filled(row, c))
                ap_text_draw(fonts[row->heading], canvas, panel->padding_px + layout->column_px[c],
                             baseline, text_color(panel, row), row->cell[c]);
        y += tall;
    }
}

enum ap_status ap_panel_draw(struct ap_error *err, const struct ap_panel *panel,
                             struct ap_canvas *canvas, double *size_px) {
    struct ap_font *fonts[2] = {NULL, NULL};
    struct layout layout;
    double size = 0;
    enum ap_status st = ap_font_open(err, AP_FONT_REGULAR, panel->size_px, &fonts[0]);
    if (!st)
        st = ap_font_open(err, AP_FONT_BOLD, panel->size_px, &fonts[1]);
    if (!st)
        st = fit(err, panel, canvas, fonts, &size, &layout);
    if (!st) {
        ap_canvas_fill(canvas, 0, 0, (int)canvas->width, (int)canvas->height, panel->ground_rgba);
        draw_rows(panel, fonts, &layout, canvas);
        if (size_px)
            *size_px = size;
    }
    ap_font_close(fonts[0]);
    ap_font_close(fonts[1]);
    return st;
}
