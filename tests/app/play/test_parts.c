#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "src/app/play/detail.h"
#include "src/app/play/menu.h"
#include "src/app/play/settings.h"
#include "src/base/file.h"

// The parts of `play` that need no headset: settings, menu, detail.

static char dir[64];

static int make_dir(void **state) {
    (void)state;
    snprintf(dir, sizeof dir, "/tmp/antipode-play-test-XXXXXX");
    return mkdtemp(dir) ? 0 : -1;
}

static int remove_dir(void **state) {
    (void)state;
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s", dir);
    return system(command);
}

static void write_text(const char *path, const char *text) {
    assert_int_equal(ap_file_write(NULL, path, text, strlen(text)), AP_OK);
}

static void settings_come_back(void **state) {
    (void)state;
    char path[128];
    snprintf(path, sizeof path, "%s/deep/er/play.json", dir);
    struct ap_error err;
    struct ap_play_settings s, back;
    assert_int_equal(ap_play_settings_read(&err, path, &s), AP_OK); // none yet
    for (int i = 0; i < AP_PLAY_SETTING_COUNT; i++)
        ap_play_step(&s, (enum ap_play_setting)i, 1);
    if (ap_play_settings_write(&err, path, &s) || ap_play_settings_read(&err, path, &back))
        fail_msg("%s", err.text);
    assert_memory_equal(&s, &back, sizeof s);
    assert_true(ap_play_choose(&s, AP_PLAY_SPACE, "s3"));
    assert_false(ap_play_choose(&s, AP_PLAY_SPACE, "s4"));
    assert_true(ap_play_is(&s, AP_PLAY_SPACE, "s3"));
    assert_true(ap_play_choose(&s, AP_PLAY_SPEED, "0.25"));
    assert_true(ap_play_number(&s, AP_PLAY_SPEED) == 0.25);
    assert_true(isnan(ap_play_number(&s, AP_PLAY_SPACE)));
}

static void bad_settings_say_where(void **state) {
    (void)state;
    static const struct {
        const char *text, *says;
    } cases[] = {
        {"{\"antipode_play\": 2}", "version 2"},
        {"{\"antipode_play\": 1, \"space\": \"h4\"}", "/space"},
        {"{\"antipode_play\": 1, \"space\": 3}", "/space"},
        {"{\"antipode_play\": 1, \"spice\": \"h3\"}", "spice"},
        {"{\"space\": \"h3\"}", "antipode_play"},
        {"{", "play.json"},
    };
    char path[128];
    snprintf(path, sizeof path, "%s/play.json", dir);
    struct ap_play_settings s = ap_play_settings_standard(), before = s;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct ap_error err;
        write_text(path, cases[i].text);
        assert_int_equal(ap_play_settings_read(&err, path, &s), AP_INPUT);
        if (!strstr(err.text, cases[i].says))
            fail_msg("'%s' does not say '%s'", err.text, cases[i].says);
        assert_memory_equal(&s, &before, sizeof s);
    }
    struct ap_error err;
    char blocked[160];
    snprintf(blocked, sizeof blocked, "%s/play.json/x.json", dir); // a file is in the way
    assert_int_equal(ap_play_settings_write(&err, blocked, &s), AP_ENVIRONMENT);
}

static enum ap_menu_wish tap(struct ap_menu *menu, struct ap_play_settings *s, double x, double y,
                             bool press, bool open) {
    const struct ap_menu_input input = {.stick_x = x, .stick_y = y, .press = press, .menu = open};
    const struct ap_menu_input rest = {0};
    enum ap_menu_wish wish = ap_menu_step(menu, &input, s);
    assert_int_equal(ap_menu_step(menu, &input, s), AP_MENU_NOTHING); // held: nothing more
    assert_int_equal(ap_menu_step(menu, &rest, s), AP_MENU_NOTHING);
    return wish;
}

static int marked(const struct ap_menu *menu, const struct ap_play_settings *s,
                  struct ap_menu_text *text) {
    int row = -1;
    ap_menu_write(menu, s, text);
    assert_true(text->count <= AP_MENU_MAX_ROWS);
    for (size_t i = 0; i < text->count; i++)
        if (text->rows[i].marked) {
            assert_int_equal(row, -1);
            row = (int)i;
        }
    assert_true(row >= 0);
    return row;
}

static void a_menu_is_walked(void **state) {
    (void)state;
    struct ap_menu menu = {0};
    struct ap_menu_text text;
    struct ap_play_settings s = ap_play_settings_standard();
    assert_int_equal(tap(&menu, &s, 1, 1, true, false), AP_MENU_NOTHING); // closed
    assert_int_equal(tap(&menu, &s, 0, 0, false, true), AP_MENU_NOTHING);
    assert_true(menu.open);
    assert_string_equal(text.rows[marked(&menu, &s, &text)].cell[0], "Go on");
    // Up from the first row is the last one.
    tap(&menu, &s, 0, 1, false, false);
    assert_string_equal(text.rows[marked(&menu, &s, &text)].cell[0], "path of the next shot");
    assert_int_equal(tap(&menu, &s, 1, 0, false, false), AP_MENU_CHANGED);
    assert_true(ap_play_is(&s, AP_PLAY_LINES, "on"));
    assert_string_equal(text.rows[marked(&menu, &s, &text)].cell[1], "on");
    tap(&menu, &s, 0, 0.9, false, false);
    assert_int_equal(tap(&menu, &s, -1, 0, false, false), AP_MENU_ANEW);
    assert_true(ap_play_is(&s, AP_PLAY_GAME, "none")); // round about
    assert_int_equal(tap(&menu, &s, 0, 0, true, false), AP_MENU_ANEW);
    assert_true(ap_play_is(&s, AP_PLAY_GAME, "free"));
    // Down again past the end: the first row; a press goes on with the game.
    tap(&menu, &s, 0, -1, false, false);
    tap(&menu, &s, 0, -1, false, false);
    assert_int_equal(tap(&menu, &s, 0, 0, true, false), AP_MENU_RESUME);
    assert_false(menu.open);
    // Every row is reached, each marked once.
    tap(&menu, &s, 0, 0, false, true);
    int first = marked(&menu, &s, &text), rows = 0;
    do {
        tap(&menu, &s, 0, -1, false, false);
        rows++;
    } while (marked(&menu, &s, &text) != first && rows < 100);
    assert_int_equal(rows, AP_PLAY_SETTING_COUNT + 5);
    assert_int_equal(tap(&menu, &s, 0, 0, false, true), AP_MENU_RESUME);
}

// A machine whose frames cost `ms` at full size, in proportion to the pixels, two thirds of it
// where surfaces are plain, half where a pixel has one sample, and 3 ms more.
static double cost_ms(const struct ap_detail *detail, double ms) {
    double scale = ap_detail_scale(detail);
    return 3 + ms * scale * scale / (ap_detail_plain(detail) ? 1.5 : 1) /
                   (ap_detail_samples(detail) == 1 ? 2 : 1);
}

static int settled_level(struct ap_detail *detail, double ms, int frames, int *changes) {
    *changes = 0;
    for (int i = 0; i < frames; i++)
        *changes += ap_detail_step(detail, cost_ms(detail, ms));
    return detail->level;
}

static void detail_settles(void **state) {
    (void)state;
    static const double costs_ms[] = {5, 24, 40, 60, 90, 120, 1000};
    for (size_t i = 0; i < sizeof costs_ms / sizeof costs_ms[0]; i++) {
        struct ap_detail detail;
        int changes;
        ap_detail_init(&detail, true, 28);
        int level = settled_level(&detail, costs_ms[i], 600, &changes);
        double frame_ms = cost_ms(&detail, costs_ms[i]);
        printf("%4.0f ms at full size: level %d, %.1f ms, %d changes\n", costs_ms[i], level,
               frame_ms, changes);
        if (level < AP_DETAIL_LEVELS - 1 && !(frame_ms <= 28))
            fail_msg("%g ms a frame at level %d, budget 28", frame_ms, level);
        if (level > 0 && !(3 + (frame_ms - 3) / 0.7 > 0.6 * 28))
            fail_msg("level %d is coarser than it need be", level);
        settled_level(&detail, costs_ms[i], 3000, &changes);
        assert_in_range(changes, 0, 4); // it does not swing
    }
    struct ap_detail fixed;
    int changes;
    ap_detail_init(&fixed, false, 28);
    assert_int_equal(settled_level(&fixed, 500, 500, &changes), 0);
    assert_false(ap_detail_step(&fixed, NAN));
    // What was slow and is fast again comes back to every pixel.
    struct ap_detail back;
    ap_detail_init(&back, true, 28);
    assert_true(settled_level(&back, 80, 300, &changes) > 0);
    assert_int_equal(settled_level(&back, 2, 30000, &changes), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(settings_come_back),
        cmocka_unit_test(bad_settings_say_where),
        cmocka_unit_test(a_menu_is_walked),
        cmocka_unit_test(detail_settles),
    };
    return cmocka_run_group_tests(tests, make_dir, remove_dir);
}
