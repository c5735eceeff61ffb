#ifndef ANTIPODE_GAME_RULES_H
#define ANTIPODE_GAME_RULES_H

#include <stdbool.h>

#include "src/base/status.h"
#include "src/game/physics.h"

// The rules as a table: what a shot did is a set of facts, the first row of the game's table whose
// facts are there says what follows. Plain data, pure. docs/billiards.md tells them to people.

enum ap_game_kind { AP_GAME_FREE, AP_GAME_EIGHT, AP_GAME_NINE };

enum ap_game_phase { AP_PHASE_BREAK, AP_PHASE_OPEN, AP_PHASE_GROUPS };

enum ap_game_group { AP_GROUP_NONE, AP_GROUP_SOLIDS, AP_GROUP_STRIPES };

// Whose turn it is and what stands between the two players (0 and 1).
struct ap_rules {
    enum ap_game_kind kind;
    enum ap_game_phase phase;
    int sides; // as many balls must reach a cushion at the break
    int turn;  // 0, 1
    enum ap_game_group group[2];
    int fouls[2]; // in a row
    int winner;   // −1: still playing
    bool in_hand; // the cue ball may be placed
};

// What a shot does, gathered from its events in their order.
struct ap_shot_facts {
    unsigned on_table;   // bit per ball, when the shot began
    unsigned pocketed;   // in this shot
    int first_hit;       // −1: none
    int first_pocketed;  // the first object ball, −1
    bool cushion_after;  // something met a cushion after the first hit
    unsigned to_cushion; // object balls that met one
};

void ap_shot_begin(struct ap_shot_facts *facts, const struct ap_physics *physics);
void ap_shot_note(struct ap_shot_facts *facts, const struct ap_physics_event *event);

// What the judgement was, for people and for the table's sake.
struct ap_verdict {
    const char *what; // "scratch", "the wrong ball first", "legal", …
    bool foul, stays; // the same player goes on
    int spot;         // a ball to be put back, or −1
};

struct ap_rules ap_rules_start(enum ap_game_kind kind, int sides);

// Ends the shot: rules go to the next turn.
struct ap_verdict ap_rules_judge(struct ap_rules *rules, const struct ap_shot_facts *facts);

// Which balls the player may hit first, a bit each.
unsigned ap_rules_targets(const struct ap_rules *rules, unsigned on_table);

// "free", "eight-ball", "nine-ball". AP_USAGE for another name.
enum ap_status ap_game_kind_from_name(struct ap_error *err, const char *name,
                                      enum ap_game_kind *kind);
const char *ap_game_kind_name(enum ap_game_kind kind);

#endif
