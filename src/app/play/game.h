#ifndef ANTIPODE_APP_PLAY_GAME_H
#define ANTIPODE_APP_PLAY_GAME_H

#include "src/app/play/aim.h"
#include "src/app/play/lines.h"
#include "src/app/play/recorder.h"
#include "src/app/play/settings.h"
#include "src/app/table_play.h"
#include "src/game/cue.h"
#include "src/render/renderer.h"

// The game of a live session: the cue in the hands or aimed, the balls' time, the path of the next
// shot, and the file that it is kept in. It knows the headset's frames, but neither runtime nor
// GPU. One thread.

struct ap_play_game_params {
    struct ap_scene *scene; // borrowed; its parts are added to it
    const char *kind;       // "free", "eight-ball", "nine-ball"
    const char *path;       // where it is kept; NULL: nowhere
    bool anew;              // do not go on with what is kept there
    const char *record;     // folder to write the session to; NULL: not
    const char *command;    // how to see a recording again
};

enum { AP_PLAY_CUE_PARTS = 16, AP_PLAY_GAME_SAYS = 200 };

struct ap_play_game {
    struct ap_table_play *table;
    char *path;       // where it is kept; NULL: nowhere
    bool dirty;       // something is not kept yet
    bool begun;       // a frame has been seen: last_ns and the clock count
    int64_t last_ns;  // of the frames
    int64_t clock_ns; // of the game, since it was opened: stands while the menu is open
    struct ap_cue cue;
    struct ap_play_aim aim;
    struct ap_play_lines lines;
    bool shows_lines;
    size_t cue_part[AP_PLAY_CUE_PARTS]; // of the scene
    struct ap_iso grip_from_part[AP_PLAY_CUE_PARTS];
    int cue_parts;
    struct ap_play_recorder recorder;
    char says[AP_PLAY_GAME_SAYS]; // why the last wish was not done, or ""
    double pulse[2];              // for the hands' motors in this frame, 0…1; left, right
    int64_t strikes, refused;     // counted
};

// $XDG_STATE_HOME/antipode/game-SPACE-KIND.json, or ~/.local/state/…; malloc'ed, NULL where neither
// variable is set.
char *ap_play_game_path(const char *space, const char *kind);

// Goes on with what is kept, where that is a game of this table and kind; what cannot be read is
// told, kept under another name, and a new game begins. AP_INPUT: the rack does not fit. The caller
// closes.
enum ap_status ap_play_game_open(struct ap_error *err, const struct ap_play_game_params *params,
                                 struct ap_play_game **game);

// Keeps the game and finishes the recording; what fails there is told. Accepts NULL.
void ap_play_game_close(struct ap_play_game *game);

// A frame, after the body has been placed. still: the menu is open, time stands. Changes the
// scene's parts.
void ap_play_game_step(struct ap_play_game *game, const struct ap_xr_frame *frame,
                       const struct ap_frame_input *placed, bool still);

// Whether sticks belong to the cue just now.
bool ap_play_game_aims(const struct ap_play_game *game);

// From the menu.
void ap_play_game_rack(struct ap_play_game *game);
void ap_play_game_undo(struct ap_play_game *game);

#endif
