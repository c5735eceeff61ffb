#ifndef ANTIPODE_GAME_GAME_H
#define ANTIPODE_GAME_GAME_H

#include "src/game/rules.h"

// A game of billiards: balls, rules, turns, undo, a file it is kept in. Plain data of some 100 KiB,
// nothing allocated but by save and load; one thread at a time.

enum { AP_UNDO_MAX = 32 };

struct ap_game_params {
    enum ap_game_kind kind;
    struct ap_table_shape shape;
    struct ap_physics_params physics;
};

// The balls at rest and whose turn it is, before a shot.
struct ap_game_snapshot {
    struct ap_rules rules;
    int shots;
    struct {
        struct ap_plane_frame foot;
        struct ap_quat turn;
        int pocket;
        bool on_table;
    } ball[AP_BALLS_MAX];
};

struct ap_game {
    struct ap_physics physics;
    struct ap_rules rules;
    struct ap_shot_facts facts;
    bool shooting; // a shot is on its way
    int shots;
    struct ap_verdict verdict; // of the last shot; .what "" before the first
    struct ap_game_snapshot undo[AP_UNDO_MAX];
    int undo_count;
};

// AP_USAGE, AP_INPUT: see ap_physics_init and ap_rack_set.
enum ap_status ap_game_start(struct ap_error *err, const struct ap_game_params *params,
                             struct ap_game *game);

// The same game racked anew, also in the middle of a shot; its time goes on. Nothing can be taken
// back then. AP_INPUT: see ap_rack_set.
enum ap_status ap_game_rack(struct ap_error *err, struct ap_game *game);

// The cue ball in hand. AP_INPUT: it is not in hand, a shot is on its way, or no place for it
// there; at the break it stands behind the head line.
enum ap_status ap_game_place(struct ap_error *err, struct ap_game *game, struct ap_plane2 at_m);

// On the head spot, or as near to it as may be.
enum ap_status ap_game_place_anywhere(struct ap_error *err, struct ap_game *game);

// AP_INPUT: the game is over, balls still move, the cue ball is to be placed first, a bad stroke.
enum ap_status ap_game_strike(struct ap_error *err, struct ap_game *game,
                              const struct ap_strike *strike);

// Goes to until_s of the physics' time. Where the balls come to rest on the way it stops at that
// very moment, judges the shot and returns true: call it again to go on. `seen` may be NULL.
bool ap_game_advance(struct ap_game *game, double until_s,
                     void (*seen)(void *data, const struct ap_physics_event *event), void *data);

// Back to before the last shot, on its way or done. AP_INPUT where there is none.
enum ap_status ap_game_undo(struct ap_error *err, struct ap_game *game);

// Score, turn and what is to be hit, for people; a line.
enum { AP_GAME_TEXT_MAX = 160 };
void ap_game_text(const struct ap_game *game, char text[AP_GAME_TEXT_MAX]);

// JSON, whole or nothing, also in the middle of a shot. Undo is not kept.
enum ap_status ap_game_save(struct ap_error *err, const struct ap_game *game, const char *path);

// AP_INPUT names the place in the file; a file of another version is told as that, and game and
// file stay as they are.
enum ap_status ap_game_load(struct ap_error *err, const char *path, struct ap_game *game);

#endif
