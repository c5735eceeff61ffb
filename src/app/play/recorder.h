#ifndef ANTIPODE_APP_PLAY_RECORDER_H
#define ANTIPODE_APP_PLAY_RECORDER_H

#include "src/base/file.h"
#include "src/game/game.h"
#include "xr/client.h"

// A session at the table, written down: the game at its beginning, poses and inputs frame by frame,
// and the shots as a script, on the game's clock (it stands while the menu is open). `replay` plays
// it again to the same game. Whole or nothing.

struct ap_play_recorder {
    char *dir;
    struct ap_outfile poses, inputs, shots;
    bool open;
    int64_t last_ns;
    double values[2][10]; // of the inputs, as last written
};

// Makes the folder, writes DIR/start.json. AP_USAGE where the folder holds a recording. Read the
// game back from there, so that what is played is what will be replayed.
enum ap_status ap_play_recorder_begin(struct ap_error *err, const char *dir,
                                      const struct ap_game *game, const char *command,
                                      struct ap_play_recorder *recorder);

// A frame at t_ns of the game's clock; frames that do not come later are left out.
void ap_play_recorder_frame(struct ap_play_recorder *recorder, int64_t t_ns,
                            const struct ap_xr_frame *frame);

// A line of the script.
void ap_play_recorder_line(struct ap_play_recorder *recorder, const char *line);

// The end at the game's present moment, DIR/game.json, and everything gets its name. On failure
// nothing but start.json is left.
enum ap_status ap_play_recorder_finish(struct ap_error *err, struct ap_play_recorder *recorder,
                                       const struct ap_game *game);

// Drops what was not finished. Accepts a zeroed one.
void ap_play_recorder_abort(struct ap_play_recorder *recorder);

#endif
