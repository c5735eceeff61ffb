#ifndef ANTIPODE_APP_PLAY_SESSION_H
#define ANTIPODE_APP_PLAY_SESSION_H

#include <stdint.h>

#include "src/app/play/body.h"
#include "src/app/play/comfort.h"
#include "src/app/play/detail.h"
#include "src/app/play/game.h"
#include "src/app/play/menu.h"

// A live session: the room, the headset behind the loader, and what the person asks for, frame by
// frame.

struct ap_play_params {
    struct ap_room_options room;
    struct ap_play_settings settings; // what the room options leave open
    const char *settings_path;        // where the menu keeps them; NULL: nowhere
    const char *game, *lines;         // of the command line, above the settings; NULL: theirs
    const char *record;               // folder that the session is written to; NULL: not
    bool keep_game, new_game;         // in its file; not going on with what is there
    const char *pictures;             // folder for pictures of both eyes; NULL: the present one
    bool older_vulkan, one_eye;       // one_eye: the window shows the left one alone
};

struct ap_play_stats {
    int64_t frames, drawn, pictures;
    int64_t rebuilt; // rooms made anew from the menu
    int64_t strikes; // of the cue
};

struct ap_play;

// Opens room and headset. The params' texts must outlive it.
enum ap_status ap_play_open(struct ap_error *err, const struct ap_play_params *params,
                            struct ap_play **play);
void ap_play_close(struct ap_play *play);

// Until the session ends; end_asked is looked at each frame, and end_ns on the machine's clock.
enum ap_status ap_play_run(struct ap_error *err, struct ap_play *play, bool (*end_asked)(void),
                           int64_t end_ns);

struct ap_play_stats ap_play_stats(const struct ap_play *play);

// What is said of how finely it draws: "1280x720, 4 samples a pixel …".
void ap_play_say_detail(const struct ap_play *play);

#endif
