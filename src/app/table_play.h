#ifndef ANTIPODE_APP_TABLE_PLAY_H
#define ANTIPODE_APP_TABLE_PLAY_H

#include "src/game/shots.h"
#include "src/scene/scene.h"

// A game on the table of a scene: the balls of the scene are where the game's are. `replay` plays a
// script on it.

struct ap_table_play {
    struct ap_game game;
    struct ap_shots *shots; // NULL: nobody plays
    struct ap_shot_player player;
    struct ap_scene *scene; // borrowed
};

// `kind` is a game's name, shots_path may be NULL. Sets the scene's balls as the game has them.
// AP_USAGE: no such game, a scene without pool balls; else as ap_game_start and ap_shots_read. The
// caller closes.
enum ap_status ap_table_play_open(struct ap_error *err, struct ap_scene *scene, const char *kind,
                                  const char *shots_path, struct ap_table_play **play);
void ap_table_play_close(struct ap_table_play *play);

// Brings the game to t_s, seconds since its start, and the scene's balls with it.
enum ap_status ap_table_play_step(struct ap_error *err, struct ap_table_play *play, double t_s);

// Puts the scene's balls where the game has them.
void ap_table_play_show(struct ap_table_play *play);

#endif
