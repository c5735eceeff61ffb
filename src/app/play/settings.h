#ifndef ANTIPODE_APP_PLAY_SETTINGS_H
#define ANTIPODE_APP_PLAY_SETTINGS_H

#include <stdbool.h>
#include <stddef.h>

#include "src/base/status.h"

// What a player may choose: on the command line, in the menu, and kept from one time to the next as
// JSON in her XDG configuration folder. One table of them serves all three.

enum ap_play_setting {
    AP_PLAY_SPACE,
    AP_PLAY_TABLE_EDGE,
    AP_PLAY_WALK,
    AP_PLAY_VIEW,
    AP_PLAY_EYE,
    AP_PLAY_ERROR,
    AP_PLAY_DETAIL,
    AP_PLAY_SPEED,
    AP_PLAY_TURN,
    AP_PLAY_VIGNETTE,
    AP_PLAY_FENCE,
    AP_PLAY_RATE,
    AP_PLAY_GAME,
    AP_PLAY_LINES,
    AP_PLAY_SETTING_COUNT
};

struct ap_play_settings {
    int values[AP_PLAY_SETTING_COUNT]; // which of the setting's choices
};

// A setting is a choice between a few words. In the JSON the word stands as it is.
struct ap_play_setting_info {
    const char *key;            // "table_edge_m"
    const char *label;          // "table's edge"
    const char *unit;           // behind the word in the menu, or ""
    const char *const *choices; // NULL ends them
    int standard;               // index
    bool anew;                  // takes effect when the room is made anew
};
const struct ap_play_setting_info *ap_play_setting_info(enum ap_play_setting setting);

struct ap_play_settings ap_play_settings_standard(void);

// The word chosen, and as a number where it is one (NAN else).
const char *ap_play_word(const struct ap_play_settings *settings, enum ap_play_setting setting);
double ap_play_number(const struct ap_play_settings *settings, enum ap_play_setting setting);
bool ap_play_is(const struct ap_play_settings *settings, enum ap_play_setting setting,
                const char *word);

// False where the word is none of its choices; nothing changes then.
bool ap_play_choose(struct ap_play_settings *settings, enum ap_play_setting setting,
                    const char *word);

// The next or the one before, round about.
void ap_play_step(struct ap_play_settings *settings, enum ap_play_setting setting, int by);

// The file: $XDG_CONFIG_HOME/antipode/play.json, or ~/.config/…; malloc'ed, NULL where neither
// variable is set.
char *ap_play_settings_path(void);

// Of a file that is not there: the standard ones. AP_INPUT with the place in the file: another
// version, an unknown key or word.
enum ap_status ap_play_settings_read(struct ap_error *err, const char *path,
                                     struct ap_play_settings *settings);

// Makes the folder; whole or not at all.
enum ap_status ap_play_settings_write(struct ap_error *err, const char *path,
                                      const struct ap_play_settings *settings);

#endif
