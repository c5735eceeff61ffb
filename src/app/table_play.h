#ifndef ANTIPODE_APP_TABLE_PLAY_H
#define ANTIPODE_APP_TABLE_PLAY_H

#include "src/game/shots.h"
#include "src/scene/scene.h"

// A game on the table of a scene: the balls of the scene are where the game's are. `replay` plays a
// script on it, `play` lets a person play (src/app/play/game.h).

struct ap_table_play_params {
    const char *kind;       // a game's name; NULL: the saved one's, else "free"
    const char *shots_path; // a script; NULL: none
    const char *saved_path; // a saved game to go on with; NULL: a fresh rack
};

struct ap_table_play {
    struct ap_game game;
    double start_s;         // the game's time when it was opened
    struct ap_shots *shots; // NULL: no script
    struct ap_shot_player player;
    struct ap_scene *scene; // borrowed
};

// Whether there is something to play with: pool balls on a table.
bool ap_table_play_is_possible(const struct ap_scene *scene);

// Sets the scene's balls as the game has them. AP_USAGE: no such game, a scene without pool balls;
// AP_INPUT: a saved game of another table or of another kind; else as ap_game_start, ap_game_load
// and ap_shots_read. The caller closes.
enum ap_status ap_table_play_open(struct ap_error *err, struct ap_scene *scene,
                                  const struct ap_table_play_params *params,
                                  struct ap_table_play **play);
void ap_table_play_close(struct ap_table_play *play);

// Brings the game to t_s, seconds since it was opened, and the scene's balls with it.
enum ap_status ap_table_play_step(struct ap_error *err, struct ap_table_play *play, double t_s);

// Where the script says when it ends, the game goes on to there: a recording's last moment need not
// be a frame's.
enum ap_status ap_table_play_finish(struct ap_error *err, struct ap_table_play *play);

// Puts the scene's balls where the game has them.
void ap_table_play_show(struct ap_table_play *play);

#endif
