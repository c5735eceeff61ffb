#include "src/image/text.h"

#include <fontconfig/fontconfig.h>
#include <ft2build.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include FT_FREETYPE_H

#include "src/image/image.h"

static const double SIZE_LEAST = 4, SIZE_MOST = 1024;
enum { CANVAS_MAX = 8192, CELL_LEAST = 8, CELL_MOST = 1024 };

struct ap_font {
    FT_Library library;
    FT_Face face;
};

enum ap_status ap_canvas_create(struct ap_error *err, uint32_t width, uint32_t height,
                                struct ap_canvas *canvas) {
    if (width == 0 || height == 0 || width > CANVAS_MAX || height > CANVAS_MAX)
        return ap_fail(err, AP_INPUT, "a canvas of %ux%u pixels: expected 1 to %d each way", width,
                       height, CANVAS_MAX);
    uint8_t *rgba = calloc((size_t)width * height, 4);
    if (!rgba)
        return ap_fail(err, AP_ENVIRONMENT, "no memory for a canvas of %ux%u pixels", width,
                       height);
    *canvas = (struct ap_canvas){width, height, rgba};
    return AP_OK;
}

void ap_canvas_finish(struct ap_canvas *canvas) {
    free(canvas->rgba);
    *canvas = (struct ap_canvas){0};
}

void ap_canvas_fill(struct ap_canvas *canvas, int x, int y, int width, int height,
                    const uint8_t rgba[4]) {
    int64_t right = (int64_t)x + width, bottom = (int64_t)y + height;
    if (right > canvas->width)
        right = canvas->width;
    if (bottom > canvas->height)
        bottom = canvas->height;
    for (int64_t j = y < 0 ? 0 : y; j < bottom; j++)
        for (int64_t i = x < 0 ? 0 : x; i < right; i++)
            memcpy(canvas->rgba + 4 * ((size_t)j * canvas->width + (size_t)i), rgba, 4);
}

// The file that fontconfig takes for a sans serif of this weight; freed by the caller.
static char *find_font(enum ap_font_weight weight, int *index) {
    char *file = NULL;
    FcConfig *config = FcInitLoadConfigAndFonts();
    FcPattern *wanted = FcPatternCreate(), *found = NULL;
    if (config && wanted) {
        FcPatternAddString(wanted, FC_FAMILY, (const FcChar8 *)"DejaVu Sans");
        FcPatternAddString(wanted, FC_FAMILY, (const FcChar8 *)"sans-serif");
        FcPatternAddInteger(wanted, FC_WEIGHT,
                            weight == AP_FONT_BOLD ? FC_WEIGHT_BOLD : FC_WEIGHT_REGULAR);
        FcPatternAddBool(wanted, FC_SCALABLE, FcTrue);
        FcConfigSubstitute(config, wanted, FcMatchPattern);
        FcDefaultSubstitute(wanted);
        FcResult result;
        found = FcFontMatch(config, wanted, &result);
    }
    FcChar8 *name = NULL;
    if (found && FcPatternGetString(found, FC_FILE, 0, &name) == FcResultMatch) {
        file = strdup((const char *)name);
        if (FcPatternGetInteger(found, FC_INDEX, 0, index) != FcResultMatch)
            *index = 0;
    }
    if (found)
        FcPatternDestroy(found);
    if (wanted)
        FcPatternDestroy(wanted);
    if (config)
        FcConfigDestroy(config);
    return file;
}

enum ap_status ap_font_resize(struct ap_error *err, struct ap_font *font, double size_px) {
    if (!(size_px >= SIZE_LEAST && size_px <= SIZE_MOST))
        return ap_fail(err, AP_INPUT, "a font of %g pixels: expected %g to %g", size_px, SIZE_LEAST,
                       SIZE_MOST);
    // At 72 dots an inch a point is a pixel.
    if (FT_Set_Char_Size(font->face, 0, (FT_F26Dot6)lround(size_px * 64), 72, 72) != 0)
        return ap_fail(err, AP_ENVIRONMENT, "FreeType cannot draw this font at %g pixels", size_px);
    return AP_OK;
}

enum ap_status ap_font_open(struct ap_error *err, enum ap_font_weight weight, double size_px,
                            struct ap_font **font) {
    int index = 0;
    char *file = find_font(weight, &index);
    struct ap_font *made = calloc(1, sizeof *made);
    enum ap_status st = AP_OK;
    if (!made)
        st = ap_fail(err, AP_ENVIRONMENT, "no memory for a font");
    else if (!file)
        st = ap_fail(err, AP_ENVIRONMENT,
                     "no font is installed: fontconfig finds none (Debian: fonts-dejavu-core)");
    else if (FT_Init_FreeType(&made->library) != 0 ||
             FT_New_Face(made->library, file, index, &made->face) != 0)
        st = ap_fail(err, AP_ENVIRONMENT, "%s: FreeType cannot read this font", file);
    if (!st)
        st = ap_font_resize(err, made, size_px);
    free(file);
    if (st)
        ap_font_close(made);
    else
        *font = made;
    return st;
}

void ap_font_close(struct ap_font *font) {
    if (!font)
        return;
    if (font->face)
        FT_Done_Face(font->face);
    if (font->library)
        FT_Done_FreeType(font->library);
    free(font);
}

struct ap_font_metrics ap_font_metrics(const struct ap_font *font) {
    const FT_Size_Metrics *m = &font->face->size->metrics;
    return (struct ap_font_metrics){m->height / 64.0, m->ascender / 64.0, -m->descender / 64.0};
}

// The next character of UTF-8 text, U+FFFD for what is none; moves on by at least a byte.
static FT_ULong next_character(const char **text) {
    static const FT_ULong least[4] = {0, 0x80, 0x800, 0x10000};
    const unsigned char *p = (const unsigned char *)*text;
    int more = p[0] < 0x80                   ? 0
               : p[0] >= 0xc2 && p[0] < 0xe0 ? 1
               : p[0] >= 0xe0 && p[0] < 0xf0 ? 2
               : p[0] >= 0xf0 && p[0] < 0xf5 ? 3
                                             : -1;
    FT_ULong c = more < 0 ? 0 : more == 0 ? p[0] : p[0] & (0x3fu >> more);
    for (int i = 1; i <= more; i++) {
        if ((p[i] & 0xc0) != 0x80) {
            more = -1;
            break;
        }
        c = c << 6 | (p[i] & 0x3f);
    }
    bool good = more >= 0 && c >= least[more] && c <= 0x10ffff && !(c >= 0xd800 && c < 0xe000);
    *text += good ? 1 + more : 1;
    return good ? c : 0xfffd;
}

static void blend(uint8_t *pixel, const uint8_t rgb[3], unsigned coverage) {
    double a = coverage / 255.0, under = pixel[3] / 255.0, sum = a + under * (1 - a);
    for (int i = 0; i < 3; i++) {
        double light =
            a * ap_linear_from_srgb(rgb[i]) + under * (1 - a) * ap_linear_from_srgb(pixel[i]);
        pixel[i] = ap_srgb_from_linear(light / sum);
    }
    pixel[3] = (uint8_t)lround(255 * sum);
}

static void draw_glyph(const FT_GlyphSlot glyph, struct ap_canvas *canvas, int x, int y,
                       const uint8_t rgb[3]) {
    const FT_Bitmap *b = &glyph->bitmap;
    for (int j = 0; j < (int)b->rows; j++)
        for (int i = 0; i < (int)b->width; i++) {
            int64_t px = (int64_t)x + glyph->bitmap_left + i;
            int64_t py = (int64_t)y - glyph->bitmap_top + j;
            unsigned coverage = b->buffer[(ptrdiff_t)j * b->pitch + i];
            if (coverage > 0 && px >= 0 && py >= 0 && px < canvas->width && py < canvas->height)
                blend(canvas->rgba + 4 * ((size_t)py * canvas->width + (size_t)px), rgb, coverage);
        }
}

// Walks the pen along the text, drawing where there is a canvas; its way in pixels.
static double walk(struct ap_font *font, struct ap_canvas *canvas, double x, double y,
                   const uint8_t rgb[3], const char *text) {
    double pen = 0;
    FT_UInt before = 0;
    while (*text) {
        FT_UInt glyph = FT_Get_Char_Index(font->face, next_character(&text));
        FT_Vector kern = {0, 0};
        if (before && glyph)
            FT_Get_Kerning(font->face, before, glyph, FT_KERNING_UNFITTED, &kern);
        pen += (double)kern.x / 64;
        // The outline is shifted by the pen's fraction of a pixel, so letters are evenly spaced.
        double at = x + pen, whole_x = floor(at), whole_y = ceil(y);
        FT_Vector shift = {(FT_Pos)lround((at - whole_x) * 64), (FT_Pos)lround((whole_y - y) * 64)};
        FT_Set_Transform(font->face, NULL, &shift);
        if (FT_Load_Glyph(font->face, glyph, FT_LOAD_NO_HINTING | FT_LOAD_NO_BITMAP) == 0) {
            pen += (double)font->face->glyph->linearHoriAdvance / 65536;
            bool near = fabs(at) < CANVAS_MAX + SIZE_MOST && fabs(y) < CANVAS_MAX + SIZE_MOST;
            if (canvas && near && FT_Render_Glyph(font->face->glyph, FT_RENDER_MODE_NORMAL) == 0)
                draw_glyph(font->face->glyph, canvas, (int)whole_x, (int)whole_y, rgb);
        }
        before = glyph;
    }
    FT_Set_Transform(font->face, NULL, NULL);
    return pen;
}

double ap_text_width_px(struct ap_font *font, const char *text) {
    return walk(font, NULL, 0, 0, NULL, text);
}

void ap_text_draw(struct ap_font *font, struct ap_canvas *canvas, double x_px, double baseline_px,
                  const uint8_t rgb[3], const char *text) {
    if (isfinite(x_px) && isfinite(baseline_px))
        walk(font, canvas, x_px, baseline_px, rgb, text);
}

// The size at which a text of this width and capital height, both for an em of 1, fits the circle.
static double fit_circle(double width, double height, double diameter) {
    double size = 0.94 * diameter / hypot(width, height);
    return fmin(fmax(size, SIZE_LEAST), fmin(SIZE_MOST, 0.8 * diameter));
}

static const double CAPITAL = 0.73; // of the em: how tall figures and capitals are

static enum ap_status draw_cell(struct ap_error *err, struct ap_font *font, const char *text,
                                struct ap_canvas *canvas) {
    double cell = canvas->width;
    enum ap_status st = ap_font_resize(err, font, 100);
    if (st)
        return st;
    double size = fit_circle(ap_text_width_px(font, text) / 100, CAPITAL, cell);
    st = ap_font_resize(err, font, size);
    if (st)
        return st;
    static const uint8_t white[3] = {255, 255, 255};
    ap_text_draw(font, canvas, (cell - ap_text_width_px(font, text)) / 2,
                 (cell + CAPITAL * size) / 2, white, text);
    return AP_OK;
}

enum ap_status ap_text_atlas_create(struct ap_error *err, const char *const *texts, uint32_t count,
                                    uint32_t cell_px, struct ap_text_atlas *atlas) {
    if (cell_px < CELL_LEAST || cell_px > CELL_MOST || count == 0)
        return ap_fail(err, AP_INPUT, "an atlas of %u cells of %u pixels: expected %d to %d pixels",
                       count, cell_px, CELL_LEAST, CELL_MOST);
    struct ap_font *font = NULL;
    struct ap_canvas canvas = {0};
    size_t area = (size_t)cell_px * cell_px;
    uint8_t *coverage = calloc(count, area);
    enum ap_status st =
        coverage ? AP_OK
                 : ap_fail(err, AP_ENVIRONMENT, "no memory for an atlas of %u texts", count);
    if (!st)
        st = ap_font_open(err, AP_FONT_BOLD, 100, &font);
    for (uint32_t i = 0; !st && i < count; i++) {
        st = ap_canvas_create(err, cell_px, cell_px, &canvas);
        if (!st)
            st = draw_cell(err, font, texts[i], &canvas);
        for (size_t k = 0; !st && k < area; k++)
            coverage[i * area + k] = canvas.rgba[4 * k + 3];
        ap_canvas_finish(&canvas);
    }
    ap_font_close(font);
    if (st)
        free(coverage);
    else
        *atlas = (struct ap_text_atlas){cell_px, count, coverage};
    return st;
}

void ap_text_atlas_finish(struct ap_text_atlas *atlas) {
    free(atlas->coverage);
    *atlas = (struct ap_text_atlas){0};
}
