#ifndef ANTIPODE_GAME_SHOTS_H
#define ANTIPODE_GAME_SHOTS_H

#include <stdio.h>

#include "src/game/game.h"

// Play by script, a command a line, words and KEY=VALUE (docs/billiards.md):
//   shot at=3 | angle=0.2 [turn=…] speed=2.5 [right=0.1] [above=-0.2] [elevation=0.1] [time=4.5]
//   place x=0 z=0.3 | place        the cue ball in hand; without a place: the head spot or near it,
//                                  if it is in hand
//   undo, rack                     the last shot taken back; the game racked anew
//   end time=…                     a recording ends: what follows is not played
//   set NAME=VALUE                 a constant of the physics, before everything else
//   clear, ball n=3 x=… z=…        free play: another table
// Each is done as soon as the balls are at rest and a pause is over, or at `time`, seconds. The
// moments follow from the balls alone, so a script plays the same at every frame rate. With a time
// `undo`, `rack` and `end` do not wait for the balls' rest.

enum ap_shot_line_kind {
    AP_LINE_SHOT,
    AP_LINE_PLACE,
    AP_LINE_UNDO,
    AP_LINE_RACK,
    AP_LINE_FINISH,
    AP_LINE_CLEAR,
    AP_LINE_BALL
};

struct ap_shot_line {
    enum ap_shot_line_kind kind;
    int number;       // in the file, from 1
    int ball;         // at=N; n=N; −1: not given
    double angle_rad; // NAN: not given; heading, counterclockwise from −z at the centre
    double turn_rad;  // added to the direction, counterclockwise
    double speed_m_s, right, above, elevation_rad;
    double x_m, z_m; // NAN: not given
    double time_s;   // NAN: as soon as may be
};

struct ap_shots {
    char *path;
    struct ap_shot_line *line;
    size_t count;
    struct ap_physics_params physics; // what `set` lines say
};

// AP_INPUT: "FILE:LINE: …". The caller destroys.
enum ap_status ap_shots_parse(struct ap_error *err, const char *path, const char *text, size_t len,
                              struct ap_shots **shots);
enum ap_status ap_shots_read(struct ap_error *err, const char *path, struct ap_shots **shots);
void ap_shots_destroy(struct ap_shots *shots);

// A line of a script that plays this stroke of the cue ball again, for a recording; no newline.
enum { AP_SHOT_TEXT_MAX = 320 };
void ap_shot_text(const struct ap_physics *physics, const struct ap_strike *strike, double time_s,
                  char text[AP_SHOT_TEXT_MAX]);

// One command, now, as a script would at this moment of the game. AP_INPUT: what a script's line
// fails with, without file and number; nothing has happened then.
enum ap_status ap_shot_command(struct ap_error *err, struct ap_game *game, const char *text);

// When the script says that it ends, seconds; INFINITY: it does not say.
double ap_shots_end_s(const struct ap_shots *shots);

// Plays a script on a game. Borrows both.
struct ap_shot_player {
    const struct ap_shots *shots;
    size_t next;
    double pause_s; // between the balls' rest and the next line
};

struct ap_shot_watch {
    void *data;
    void (*event)(void *data, const struct ap_physics_event *event);
    void (*line)(void *data, const struct ap_shot_line *line); // after it was done
    void (*judged)(void *data);
};

// Brings game and script to until_s. AP_INPUT: a line that cannot be played, by file and number.
// `watch` may be NULL, and each of its functions.
enum ap_status ap_shot_player_run(struct ap_error *err, struct ap_shot_player *player,
                                  struct ap_game *game, double until_s,
                                  const struct ap_shot_watch *watch);

// Nothing left to play, and the balls are at rest; or the script's end is reached.
bool ap_shot_player_done(const struct ap_shot_player *player, const struct ap_game *game);

#endif
