#include "src/app/play/menu.h"

#include <math.h>
#include <stdio.h>

static const struct {
    const char *label;
    enum ap_menu_wish wish;
} actions[] = {
    {"Go on", AP_MENU_RESUME},
    {"New rack", AP_MENU_RACK},
    {"Take the shot back", AP_MENU_UNDO},
    {"Picture of both eyes", AP_MENU_SCREENSHOT},
    {"End", AP_MENU_QUIT},
};

enum {
    ACTION_COUNT = sizeof actions / sizeof *actions,
    ROW_COUNT = ACTION_COUNT + AP_PLAY_SETTING_COUNT
};

static const char *const controls[][2] = {
    {"right squeeze, mouse right", "aim where you look"},
    {"right trigger, mouse left", "strike; put the ball in hand"},
    {"right stick, wheel", "how fast, while aiming"},
    {"left stick; A", "the tip; the ball in hand, while aiming"},
    {"left stick", "fly, where the body hangs on the anchor"},
    {"right stick", "turn; hold forward to point, then go"},
    {"Y; B", "native or tourist; which eyes are open"},
    {"left stick pressed", "picture of both eyes"},
    {"WASD QE, mouse", "the head; with 1 or 2 held, a hand"},
    {"IJKL; TGUO", "left stick; right stick"},
    {"X Y; C V; M", "left X, Y; right A, B; menu"},
    {"F2; F12", "layout of the window; picture"},
};

// True once for each time that the stick goes out.
static bool flicked(double value, bool *was) {
    bool out = fabs(value) > (*was ? 0.3 : 0.6);
    bool now = out && !*was;
    *was = out;
    return now;
}

static bool pressed(bool down, bool *was) {
    bool now = down && !*was;
    *was = down;
    return now;
}

static enum ap_menu_wish change(struct ap_menu *menu, struct ap_play_settings *settings, int by) {
    enum ap_play_setting setting = (enum ap_play_setting)(menu->row - ACTION_COUNT);
    ap_play_step(settings, setting, by);
    return ap_play_setting_info(setting)->anew ? AP_MENU_ANEW : AP_MENU_CHANGED;
}

enum ap_menu_wish ap_menu_step(struct ap_menu *menu, const struct ap_menu_input *input,
                               struct ap_play_settings *settings) {
    bool toggle = pressed(input->menu, &menu->was_menu);
    bool press = pressed(input->press, &menu->was_press);
    bool along = flicked(input->stick_x, &menu->was_x),
         down = flicked(input->stick_y, &menu->was_y);
    if (toggle) {
        menu->open = !menu->open;
        menu->row = 0;
        return menu->open ? AP_MENU_NOTHING : AP_MENU_RESUME;
    }
    if (!menu->open)
        return AP_MENU_NOTHING;
    if (down) {
        menu->row = (menu->row + (input->stick_y < 0 ? 1 : ROW_COUNT - 1)) % ROW_COUNT;
        return AP_MENU_NOTHING;
    }
    if (menu->row >= ACTION_COUNT && (along || press))
        return change(menu, settings, along && input->stick_x < 0 ? -1 : 1);
    if (menu->row >= ACTION_COUNT || !press)
        return AP_MENU_NOTHING;
    enum ap_menu_wish wish = actions[menu->row].wish;
    if (wish != AP_MENU_SCREENSHOT)
        menu->open = false;
    return wish;
}

void ap_menu_write(const struct ap_menu *menu, const struct ap_play_settings *settings,
                   struct ap_menu_text *text) {
    *text = (struct ap_menu_text){.count = 0};
    text->rows[text->count++] = (struct ap_panel_row){.cell = {"antipode"}, .heading = true};
    for (int i = 0; i < ACTION_COUNT; i++)
        text->rows[text->count++] =
            (struct ap_panel_row){.cell = {actions[i].label}, .marked = menu->row == i};
    text->rows[text->count++] = (struct ap_panel_row){.cell = {NULL}};
    for (int i = 0; i < AP_PLAY_SETTING_COUNT; i++) {
        const struct ap_play_setting_info *info = ap_play_setting_info((enum ap_play_setting)i);
        const char *word = ap_play_word(settings, (enum ap_play_setting)i);
        bool number = !isnan(ap_play_number(settings, (enum ap_play_setting)i));
        snprintf(text->values[i], sizeof text->values[i], "%s%s%s", word,
                 number && info->unit[0] ? " " : "", number ? info->unit : "");
        text->rows[text->count++] = (struct ap_panel_row){.cell = {info->label, text->values[i]},
                                                          .marked = menu->row == ACTION_COUNT + i};
    }
    text->rows[text->count++] = (struct ap_panel_row){.cell = {NULL}};
    for (size_t i = 0; i < sizeof controls / sizeof *controls; i++)
        text->rows[text->count++] =
            (struct ap_panel_row){.cell = {controls[i][0], controls[i][1]}, .rgb = {150, 160, 175}};
}
