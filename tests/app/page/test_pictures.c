// clang-format off
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
// clang-format on
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "src/app/page.h"
#include "src/base/file.h"
#include "tests/app/page/synth.h"

static void write_plain(const struct ap_capture *c, int64_t frame, const char *suffix,
                        uint32_t width, uint32_t height, uint8_t grey) {
    struct ap_image image;
    assert_int_equal(ap_image_create(NULL, width, height, &image), AP_OK);
    memset(image.rgb, grey, (size_t)width * height * 3);
    char *path = ap_capture_picture_path(c, frame, suffix);
    assert_int_equal(ap_png_write(NULL, path, &image), AP_OK);
    free(path);
    ap_image_finish(&image);
}

static struct ap_capture plain_capture(const char *dir, int frames) {
    struct ap_capture c = synth_capture(dir, (struct ap_space){0, 1}, AP_VIEW_NATIVE, 2 * frames);
    for (int e = 0; e < 2; e++) // even eyes: the anaglyph moves nothing
        c.headset.eye[e] = (struct ap_eye_profile){.width_px = 30,
                                                   .height_px = 20,
                                                   .left_rad = -0.7,
                                                   .right_rad = 0.7,
                                                   .up_rad = 0.6,
                                                   .down_rad = -0.6};
    for (size_t k = 0; k < c.frame_count; k++) {
        write_plain(&c, c.frames[k].frame, "left.png", 30, 20, (uint8_t)(60 + k));
        write_plain(&c, c.frames[k].frame, "right.png", 30, 20, 200);
    }
    return c;
}

static struct ap_image read_picture(const struct ap_capture *c, const char *name) {
    struct ap_image image = {0};
    struct ap_error err = {""};
    char *path = synth_path(c->dir, name);
    if (ap_png_read(&err, path, &image))
        fail_msg("%s", err.text);
    free(path);
    return image;
}

struct count {
    int64_t steps, done, total;
};

static void count_step(void *data, int64_t done, int64_t total) {
    struct count *c = data;
    c->steps++;
    c->done = done;
    c->total = total;
}

static void pairs_and_sheet_are_made(void **state) {
    (void)state;
    char *dir = synth_folder();
    struct ap_capture c = plain_capture(dir, 5);
    struct count count = {0, 0, 0};
    const struct ap_progress progress = {count_step, &count};
    struct ap_error err = {""};
    if (ap_pictures_write(&err, &c, &progress))
        fail_msg("%s", err.text);
    assert_true(count.steps == 5 && count.done == 5 && count.total == 5);
    struct ap_image sbs = read_picture(&c, "000004-sbs.png");
    assert_int_equal(sbs.width, 60);
    assert_int_equal(sbs.rgb[0], 62);
    assert_int_equal(sbs.rgb[3 * 59], 200);
    struct ap_image anaglyph = read_picture(&c, "000008-anaglyph.png");
    assert_int_equal(anaglyph.rgb[0], 64);
    assert_int_equal(anaglyph.rgb[1], 200);
    struct ap_image contact = read_picture(&c, "contact.png");
    assert_int_equal(contact.width, 4 * (30 + 4) + 4);
    assert_int_equal(contact.height, 2 * (20 + 4) + 4);
    ap_image_finish(&sbs);
    ap_image_finish(&anaglyph);
    ap_image_finish(&contact);
    ap_capture_finish(&c);
    synth_remove(dir);
}

// A column of light that both eyes see straight ahead, at infinity, stays one in the anaglyph.
static void anaglyphs_of_uneven_eyes_lie_together(void **state) {
    (void)state;
    char *dir = synth_folder();
    struct ap_capture c = plain_capture(dir, 1);
    c.headset.eye[0] = (struct ap_eye_profile){.width_px = 300,
                                               .height_px = 20,
                                               .left_rad = -0.8,
                                               .right_rad = 0.6,
                                               .up_rad = 0.6,
                                               .down_rad = -0.6};
    c.headset.eye[1] = (struct ap_eye_profile){.width_px = 300,
                                               .height_px = 20,
                                               .left_rad = -0.6,
                                               .right_rad = 0.8,
                                               .up_rad = 0.6,
                                               .down_rad = -0.6};
    for (int e = 0; e < 2; e++) {
        double l = tan(c.headset.eye[e].left_rad), r = tan(c.headset.eye[e].right_rad);
        struct ap_image image;
        assert_int_equal(ap_image_create(NULL, 300, 20, &image), AP_OK);
        memset(image.rgb + 3 * (int)(300 * -l / (r - l)), 255, 3);
        char *path = ap_capture_picture_path(&c, 0, e ? "right.png" : "left.png");
        assert_int_equal(ap_png_write(NULL, path, &image), AP_OK);
        free(path);
        ap_image_finish(&image);
    }
    assert_int_equal(ap_pictures_write(NULL, &c, NULL), AP_OK);
    struct ap_image made = read_picture(&c, "000000-anaglyph.png");
    int at[3] = {-1, -1, -1};
    for (int x = 0; x < 300; x++)
        for (int k = 0; k < 3; k++)
            if (made.rgb[3 * x + k] == 255)
                at[k] = x;
    if (at[0] < 0 || abs(at[1] - at[0]) > 1 || at[1] != at[2])
        fail_msg("red at %d, green at %d, blue at %d: expected one place", at[0], at[1], at[2]);
    ap_image_finish(&made);
    ap_capture_finish(&c);
    synth_remove(dir);
}

static void missing_pictures_are_passed_over(void **state) {
    (void)state;
    char *dir = synth_folder();
    struct ap_capture c = plain_capture(dir, 3);
    char *gone = ap_capture_picture_path(&c, 2, "right.png");
    unlink(gone);
    free(gone);
    assert_int_equal(ap_pictures_write(NULL, &c, NULL), AP_OK);
    char *none = synth_path(dir, "000002-sbs.png"), *some = synth_path(dir, "000004-sbs.png");
    assert_false(ap_file_exists(none));
    assert_true(ap_file_exists(some));
    struct ap_image contact = read_picture(&c, "contact.png");
    assert_int_equal(contact.width, 2 * (30 + 4) + 4);
    ap_image_finish(&contact);
    free(none);
    free(some);
    ap_capture_finish(&c);
    synth_remove(dir);
}

static void broken_pictures_are_told(void **state) {
    (void)state;
    char *dir = synth_folder();
    struct ap_capture c = plain_capture(dir, 3);
    synth_write_text(dir, "000002-left.png", "no picture");
    struct ap_error err = {""};
    assert_int_equal(ap_pictures_write(&err, &c, NULL), AP_INPUT);
    if (!strstr(err.text, "000002-left.png"))
        fail_msg("\"%s\" does not name the picture", err.text);
    ap_capture_finish(&c);
    synth_remove(dir);
}

static void uneven_eyes_are_padded(void **state) {
    (void)state;
    char *dir = synth_folder();
    struct ap_capture c = plain_capture(dir, 1);
    write_plain(&c, 0, "right.png", 24, 26, 200);
    assert_int_equal(ap_pictures_write(NULL, &c, NULL), AP_OK);
    struct ap_image sbs = read_picture(&c, "000000-sbs.png");
    assert_int_equal(sbs.width, 60);
    assert_int_equal(sbs.height, 26);
    ap_image_finish(&sbs);
    ap_capture_finish(&c);
    synth_remove(dir);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pairs_and_sheet_are_made),
        cmocka_unit_test(anaglyphs_of_uneven_eyes_lie_together),
        cmocka_unit_test(missing_pictures_are_passed_over),
        cmocka_unit_test(broken_pictures_are_told),
        cmocka_unit_test(uneven_eyes_are_padded),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
