#ifndef ANTIPODE_APP_PLAY_MENU_H
#define ANTIPODE_APP_PLAY_MENU_H

#include <stdbool.h>

#include "src/app/play/settings.h"
#include "src/image/text.h"

// The menu of `antipode play`: rows that sticks and buttons walk through. Pure: what it shows is
// text rows, what it asks for is the return value.

enum ap_menu_wish {
    AP_MENU_NOTHING,
    AP_MENU_CHANGED, // a setting
    AP_MENU_ANEW,    // a setting that takes the room being made anew
    AP_MENU_RESUME,
    AP_MENU_RACK, // begin the game anew
    AP_MENU_UNDO,
    AP_MENU_SCREENSHOT,
    AP_MENU_QUIT
};

struct ap_menu_input {
    double stick_x, stick_y; // of either hand, the one farther out
    bool press;              // trigger, A or X
    bool menu;               // opens, and closes
};

struct ap_menu {
    bool open;
    int row;
    bool was_menu, was_press, was_x, was_y; // so that each takes effect once
};

// A frame. A change has been made in `settings` already.
enum ap_menu_wish ap_menu_step(struct ap_menu *menu, const struct ap_menu_input *input,
                               struct ap_play_settings *settings);

enum { AP_MENU_MAX_ROWS = 48 };

// The rows as they stand, with what the controls are below. `text` holds what rows point to.
struct ap_menu_text {
    struct ap_panel_row rows[AP_MENU_MAX_ROWS];
    size_t count;
    char values[AP_PLAY_SETTING_COUNT][48];
};
void ap_menu_write(const struct ap_menu *menu, const struct ap_play_settings *settings,
                   struct ap_menu_text *text);

#endif
