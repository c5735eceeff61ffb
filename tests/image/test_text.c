// Text in pictures: that a letter is where its numbers say, that cells are centred and told apart,
// that a panel keeps to its columns and to its edges, and that hostile text does no harm.

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "src/image/text.h"

static const uint8_t white[3] = {255, 255, 255};

struct box {
    int left, right, top, bottom; // of the pixels with any coverage; right and bottom beyond
    double ink;
};

static struct box ink_of(const struct ap_canvas *c, uint32_t x0, uint32_t x1) {
    struct box b = {(int)c->width, 0, (int)c->height, 0, 0};
    for (uint32_t j = 0; j < c->height; j++)
        for (uint32_t i = x0; i < x1; i++) {
            int a = c->rgba[4 * (j * c->width + i) + 3];
            if (a == 0)
                continue;
            b.ink += a / 255.0;
            b.left = (int)i < b.left ? (int)i : b.left;
            b.right = (int)i + 1 > b.right ? (int)i + 1 : b.right;
            b.top = (int)j < b.top ? (int)j : b.top;
            b.bottom = (int)j + 1 > b.bottom ? (int)j + 1 : b.bottom;
        }
    return b;
}

static void near(const char *what, double got, double want, double tolerance) {
    if (!(fabs(got - want) <= tolerance))
        fail_msg("%s: %.6g, expected %.6g within %.3g", what, got, want, tolerance);
}

static struct ap_font *open_font(double size) {
    struct ap_error err = {0};
    struct ap_font *font = NULL;
    if (ap_font_open(&err, AP_FONT_BOLD, size, &font))
        fail_msg("%s", err.text);
    return font;
}

// A letter's ink moves with the pen by a fraction of a pixel too, and keeps its amount.
static void pen_is_where_it_says(void **state) {
    (void)state;
    struct ap_font *font = open_font(40);
    double middle[3], ink[3];
    const double at[3] = {10, 10.5, 17.25};
    for (int k = 0; k < 3; k++) {
        struct ap_canvas c;
        assert_int_equal(ap_canvas_create(NULL, 80, 60, &c), AP_OK);
        ap_text_draw(font, &c, at[k], 45, white, "8");
        double sum = 0, moment = 0;
        for (uint32_t n = 0; n < c.width * c.height; n++) {
            sum += c.rgba[4 * n + 3];
            moment += c.rgba[4 * n + 3] * (n % c.width + 0.5);
        }
        middle[k] = moment / sum;
        ink[k] = sum;
        struct box b = ink_of(&c, 0, c.width);
        near("bottom", b.bottom, 45, 2);
        ap_canvas_finish(&c);
    }
    near("moved by a half", middle[1] - middle[0], 0.5, 0.02);
    near("moved by 7.25", middle[2] - middle[0], 7.25, 0.02);
    near("ink", ink[1] / ink[0], 1, 0.01);
    ap_font_close(font);
}

static void widths_add_up(void **state) {
    (void)state;
    struct ap_font *font = open_font(64);
    double one = ap_text_width_px(font, "1"), two = ap_text_width_px(font, "15");
    near("two figures", two, 2 * one, 0.05);
    near("none", ap_text_width_px(font, ""), 0, 0);
    assert_int_equal(ap_font_resize(NULL, font, 32), AP_OK);
    near("half the size", ap_text_width_px(font, "15"), two / 2, 0.05);
    ap_font_close(font);
}

// Bytes that are no UTF-8, control characters, and places far outside: nothing is read or written
// beyond its end (the sanitizers look), each bad byte is one box.
static void hostile_text(void **state) {
    (void)state;
    static const char *const bad[] = {
        "\xff\xfe",         "\xc3",     "\xe2\x82",     "\xed\xa0\x80",
        "\xf4\x90\x80\x80", "\xc0\xaf", "\x01\x7f\x1b", "\xe2\x28\xa1"};
    struct ap_font *font = open_font(20);
    struct ap_canvas c;
    assert_int_equal(ap_canvas_create(NULL, 16, 16, &c), AP_OK);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        ap_text_draw(font, &c, 3, 12, white, bad[i]);
        assert_true(ap_text_width_px(font, bad[i]) >= 0);
    }
    const double far[] = {-1e9, 1e9, -19, 15.9, NAN, INFINITY};
    for (size_t i = 0; i < 6; i++)
        for (size_t j = 0; j < 6; j++)
            ap_text_draw(font, &c, far[i], far[j], white, "W");
    near("two broken bytes are two boxes", ap_text_width_px(font, "\xff\xfe"),
         2 * ap_text_width_px(font, "\xef\xbf\xbd"), 0.05);
    ap_canvas_finish(&c);
    ap_font_close(font);
    assert_int_not_equal(ap_font_open(NULL, AP_FONT_BOLD, NAN, &font), AP_OK);
    assert_int_not_equal(ap_canvas_create(NULL, 0, 5, &c), AP_OK);
}

static void numbers_in_cells(void **state) {
    (void)state;
    char text[15][3];
    const char *texts[15];
    for (int i = 0; i < 15; i++) {
        snprintf(text[i], sizeof text[i], "%d", i + 1);
        texts[i] = text[i];
    }
    struct ap_text_atlas atlas;
    struct ap_error err = {0};
    if (ap_text_atlas_create(&err, texts, 15, 96, &atlas))
        fail_msg("%s", err.text);
    for (int i = 0; i < 15; i++) {
        const uint8_t *cell = atlas.coverage + (size_t)i * 96 * 96;
        double sum = 0, x = 0, y = 0, outside = 0;
        for (int k = 0; k < 96 * 96; k++) {
            double u = k % 96 + 0.5 - 48, v = k / 96 + 0.5 - 48; // NOLINT: whole rows
            sum += cell[k];
            x += cell[k] * u;
            y += cell[k] * v;
            outside += hypot(u, v) > 49 ? cell[k] : 0;
        }
        assert_true(sum > 255 * 96 * 96 * 0.08); // ink enough to be read
        near("across", x / sum, 0, 6);
        near("down", y / sum, 0, 9); // a 7 is heavy at its top
        near("outside the circle", outside, 0, 0);
        for (int j = 0; j < i; j++) {
            double differs = 0;
            for (int k = 0; k < 96 * 96; k++)
                differs += abs(cell[k] - atlas.coverage[(size_t)j * 96 * 96 + (size_t)k]);
            assert_true(differs > 0.15 * sum);
        }
    }
    ap_text_atlas_finish(&atlas);
    assert_int_equal(ap_text_atlas_create(NULL, texts, 15, 4, &atlas), AP_INPUT);
}

static const struct ap_panel_row rows[] = {
    {.cell = {"Eight-ball in hyperbolic space"}, .heading = true},
    {.cell = {"player", "balls", "turn"}},
    {.cell = {NULL}},
    {.cell = {"solids", "3", "yes"}, .marked = true},
    {.cell = {"stripes", "5", ""}, .rgb = {255, 40, 40}},
};
static const struct ap_panel panel = {.size_px = 30,
                                      .padding_px = 12,
                                      .ground_rgba = {10, 12, 16, 200},
                                      .mark_rgba = {40, 80, 160, 255},
                                      .rows = rows,
                                      .row_count = 5};

static void panel_keeps_its_edges(void **state) {
    (void)state;
    struct ap_canvas c;
    double size[2];
    for (int k = 0; k < 2; k++) {
        uint32_t w = k ? 300 : 700, h = k ? 100 : 240;
        assert_int_equal(ap_canvas_create(NULL, w, h, &c), AP_OK);
        assert_int_equal(ap_panel_draw(NULL, &panel, &c, &size[k]), AP_OK);
        int marked = 0, red = 0;
        for (uint32_t j = 0; j < h; j++)
            for (uint32_t i = 0; i < w; i++) {
                const uint8_t *p = c.rgba + 4 * (j * w + i);
                bool border = i < 6 || j < 6 || i >= w - 6 || j >= h - 6;
                if (border && memcmp(p, panel.ground_rgba, 4) != 0)
                    fail_msg("the border at %u, %u is %d %d %d %d", i, j, p[0], p[1], p[2], p[3]);
                marked += memcmp(p, panel.mark_rgba, 4) == 0;
                red += p[0] > 200 && p[1] < 80;
            }
        assert_true(marked > 1000);
        assert_true(red > 20);
        ap_canvas_finish(&c);
    }
    near("as large as asked for", size[0], 30, 0);
    assert_true(size[1] < 15);
    assert_int_equal(ap_canvas_create(NULL, 40, 16, &c), AP_OK);
    assert_int_equal(ap_panel_draw(NULL, &panel, &c, NULL), AP_INPUT);
    ap_canvas_finish(&c);
}

// The second column starts at the same pixel in every row, whatever stands in the first.
static void panel_columns_are_straight(void **state) {
    (void)state;
    static const struct ap_panel_row two[] = {{.cell = {"I", "H"}}, {.cell = {"MMMM", "H"}}};
    struct ap_panel p = {.size_px = 30, .padding_px = 10, .rows = two, .row_count = 2};
    struct ap_canvas c;
    assert_int_equal(ap_canvas_create(NULL, 300, 100, &c), AP_OK);
    assert_int_equal(ap_panel_draw(NULL, &p, &c, NULL), AP_OK);
    int left[2] = {300, 300};
    for (uint32_t j = 0; j < 100; j++)
        for (uint32_t i = 140; i < 300; i++)
            if (c.rgba[4 * (j * 300 + i) + 3] > 128 && (int)i < left[j > 45])
                left[j > 45] = (int)i;
    assert_true(left[0] < 300);
    assert_int_equal(left[0], left[1]);
    ap_canvas_finish(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pen_is_where_it_says),  cmocka_unit_test(widths_add_up),
        cmocka_unit_test(hostile_text),          cmocka_unit_test(numbers_in_cells),
        cmocka_unit_test(panel_keeps_its_edges), cmocka_unit_test(panel_columns_are_straight),
    };
    struct ap_font *font;
    struct ap_error err = {0};
    if (ap_font_open(&err, AP_FONT_BOLD, 20, &font)) {
        printf("skipped: %s\n", err.text);
        return 77;
    }
    ap_font_close(font);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
