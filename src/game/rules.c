#include "src/game/rules.h"

#include <string.h>

enum {
    SOLIDS = 0xfe, // 1 … 7
    EIGHT = 1 << 8,
    STRIPES = 0xfe00, // 9 … 15
    NINE = 1 << 9,
    OBJECTS = 0xfffe,
};

// Facts that the tables ask for.
enum fact {
    SCRATCH = 1 << 0,
    NO_HIT = 1 << 1,
    WRONG_FIRST = 1 << 2,
    NO_CUSHION = 1 << 3, // nothing fell and nothing met a cushion after the hit
    POOR_BREAK = 1 << 4,
    FOUL = 1 << 5, // one of the first four that counts in this game
    ANY_FELL = 1 << 6,
    OWN_FELL = 1 << 7,
    EIGHT_FELL = 1 << 8,
    NINE_FELL = 1 << 9,
    EIGHT_DUE = 1 << 10, // the own group was gone before the shot
    THIRD_FOUL = 1 << 11,
};

enum action {
    STAYS = 1 << 0,
    HAND = 1 << 1,
    SPOT_KEY = 1 << 2, // the eight or the nine comes back
    WINS = 1 << 3,
    LOSES = 1 << 4,
    ASSIGNS = 1 << 5, // the group of what fell first is the player's
};

enum { BREAK = 1 << AP_PHASE_BREAK, OPEN = 1 << AP_PHASE_OPEN, GROUPS = 1 << AP_PHASE_GROUPS };

struct row {
    unsigned phases, facts; // all of these facts
    unsigned actions;
    const char *what;
};

static const struct row free_rows[] = {
    {BREAK | OPEN, SCRATCH, STAYS | HAND, "the cue ball fell: place it"},
    {BREAK | OPEN, 0, STAYS, "free play"},
};

static const struct row eight_rows[] = {
    {BREAK, EIGHT_FELL | FOUL, HAND | SPOT_KEY, "foul at the break; the eight is spotted"},
    {BREAK, EIGHT_FELL, STAYS | SPOT_KEY, "the eight fell at the break and is spotted"},
    {BREAK, FOUL, HAND, "foul at the break"},
    {BREAK, POOR_BREAK, HAND, "too few balls reached a cushion at the break"},
    {BREAK, ANY_FELL, STAYS, "a ball fell at the break"},
    {BREAK, 0, 0, "nothing fell at the break"},
    {OPEN | GROUPS, EIGHT_FELL | FOUL, LOSES, "the eight fell with a foul"},
    {GROUPS, EIGHT_FELL | EIGHT_DUE, WINS, "the eight fell in its turn"},
    {OPEN | GROUPS, EIGHT_FELL, LOSES, "the eight fell too early"},
    {OPEN | GROUPS, FOUL, HAND, "foul"},
    {OPEN, ANY_FELL, STAYS | ASSIGNS, "the groups are chosen"},
    {GROUPS, OWN_FELL, STAYS, "a ball of the own group fell"},
    {OPEN | GROUPS, 0, 0, "nothing of the own group fell"},
};

static const struct row nine_rows[] = {
    {BREAK | OPEN, FOUL | THIRD_FOUL, LOSES, "the third foul in a row"},
    {BREAK | OPEN, NINE_FELL | FOUL, HAND | SPOT_KEY, "foul; the nine is spotted"},
    {BREAK | OPEN, NINE_FELL, WINS, "the nine fell"},
    {BREAK | OPEN, FOUL, HAND, "foul"},
    {BREAK, POOR_BREAK, HAND, "too few balls reached a cushion at the break"},
    {BREAK | OPEN, ANY_FELL, STAYS, "a ball fell"},
    {BREAK | OPEN, 0, 0, "nothing fell"},
};

// A game: its rows, which faults count, and the ball it turns on.
static const struct game {
    const char *name;
    const struct row *rows;
    size_t count;
    unsigned faults;
    int key;
} games[] = {
    [AP_GAME_FREE] = {"free", free_rows, sizeof free_rows / sizeof *free_rows, SCRATCH, -1},
    [AP_GAME_EIGHT] = {"eight-ball", eight_rows, sizeof eight_rows / sizeof *eight_rows,
                       SCRATCH | NO_HIT | WRONG_FIRST | NO_CUSHION, 8},
    [AP_GAME_NINE] = {"nine-ball", nine_rows, sizeof nine_rows / sizeof *nine_rows,
                      SCRATCH | NO_HIT | WRONG_FIRST | NO_CUSHION, 9},
};

enum ap_status ap_game_kind_from_name(struct ap_error *err, const char *name,
                                      enum ap_game_kind *kind) {
    for (size_t i = 0; i < sizeof games / sizeof *games; i++)
        if (strcmp(games[i].name, name) == 0) {
            *kind = (enum ap_game_kind)i;
            return AP_OK;
        }
    return ap_fail(err, AP_USAGE, "no game '%s': use free, eight-ball or nine-ball", name);
}

const char *ap_game_kind_name(enum ap_game_kind kind) {
    return games[kind].name;
}

void ap_shot_begin(struct ap_shot_facts *facts, const struct ap_physics *ph) {
    *facts = (struct ap_shot_facts){.first_hit = -1, .first_pocketed = -1};
    for (int i = 0; i < ph->ball_count; i++)
        if (ph->ball[i].state != AP_BALL_POCKETED)
            facts->on_table |= 1u << i;
}

void ap_shot_note(struct ap_shot_facts *f, const struct ap_physics_event *e) {
    if (e->kind == AP_EVENT_BALLS && f->first_hit < 0 && (e->a == 0 || e->b == 0))
        f->first_hit = e->a == 0 ? e->b : e->a;
    if (e->kind == AP_EVENT_CUSHION) {
        f->cushion_after = f->cushion_after || f->first_hit >= 0;
        if (e->a > 0)
            f->to_cushion |= 1u << e->a;
    }
    if (e->kind == AP_EVENT_POCKET) {
        f->pocketed |= 1u << e->a;
        if (e->a > 0 && f->first_pocketed < 0)
            f->first_pocketed = e->a;
    }
}

struct ap_rules ap_rules_start(enum ap_game_kind kind, int sides) {
    return (struct ap_rules){
        .kind = kind, .phase = AP_PHASE_BREAK, .sides = sides, .winner = -1, .in_hand = true};
}

static unsigned balls_of(enum ap_game_group group) {
    return group == AP_GROUP_SOLIDS ? SOLIDS : group == AP_GROUP_STRIPES ? STRIPES : 0;
}

unsigned ap_rules_targets(const struct ap_rules *r, unsigned on_table) {
    unsigned objects = on_table & OBJECTS;
    if (r->kind == AP_GAME_NINE)
        return objects & -objects;
    if (r->kind == AP_GAME_FREE || r->phase == AP_PHASE_BREAK)
        return objects;
    if (r->phase == AP_PHASE_OPEN)
        return objects & ~(unsigned)EIGHT;
    unsigned own = objects & balls_of(r->group[r->turn]);
    return own ? own : objects & EIGHT;
}

static int bits_of(unsigned set) {
    int n = 0;
    for (; set; set &= set - 1)
        n++;
    return n;
}

static unsigned facts_of(const struct ap_rules *r, const struct ap_shot_facts *f) {
    unsigned facts = 0, fell = f->pocketed & OBJECTS;
    unsigned own = balls_of(r->group[r->turn]);
    if (f->pocketed & 1)
        facts |= SCRATCH;
    if (f->first_hit < 0)
        facts |= NO_HIT;
    else if (!(ap_rules_targets(r, f->on_table) >> f->first_hit & 1))
        facts |= WRONG_FIRST;
    if (f->first_hit >= 0 && !fell && !f->cushion_after)
        facts |= NO_CUSHION;
    if (!fell && bits_of(f->to_cushion) < r->sides)
        facts |= POOR_BREAK;
    if (facts & games[r->kind].faults)
        facts |= FOUL;
    if (fell)
        facts |= ANY_FELL;
    if (fell & own)
        facts |= OWN_FELL;
    if (fell & EIGHT)
        facts |= EIGHT_FELL;
    if (fell & NINE)
        facts |= NINE_FELL;
    if (own && !(f->on_table & own))
        facts |= EIGHT_DUE;
    if (r->fouls[r->turn] >= 2)
        facts |= THIRD_FOUL;
    return facts;
}

static const char *fault_name(unsigned facts) {
    return facts & SCRATCH       ? "scratch: the cue ball fell"
           : facts & NO_HIT      ? "foul: no ball was hit"
           : facts & WRONG_FIRST ? "foul: the wrong ball was hit first"
                                 : "foul: nothing reached a cushion or a pocket";
}

// What a row does to the players.
static void follow(struct ap_rules *r, const struct ap_shot_facts *f, unsigned actions,
                   unsigned facts) {
    int player = r->turn;
    r->fouls[player] = facts & FOUL ? r->fouls[player] + 1 : 0;
    if (actions & ASSIGNS) {
        bool solids = f->first_pocketed >= 0 && f->first_pocketed < 8;
        r->group[player] = solids ? AP_GROUP_SOLIDS : AP_GROUP_STRIPES;
        r->group[1 - player] = solids ? AP_GROUP_STRIPES : AP_GROUP_SOLIDS;
        r->phase = AP_PHASE_GROUPS;
    }
    if (r->phase == AP_PHASE_BREAK)
        r->phase = AP_PHASE_OPEN;
    r->in_hand = (actions & HAND) != 0;
    if (actions & (WINS | LOSES))
        r->winner = actions & WINS ? player : 1 - player;
    else if (!(actions & STAYS))
        r->turn = 1 - player;
}

struct ap_verdict ap_rules_judge(struct ap_rules *r, const struct ap_shot_facts *f) {
    const struct game *g = &games[r->kind];
    unsigned facts = facts_of(r, f);
    const struct row *row = &g->rows[g->count - 1];
    for (size_t i = 0; i < g->count; i++)
        if ((g->rows[i].phases >> r->phase & 1) && (facts & g->rows[i].facts) == g->rows[i].facts) {
            row = &g->rows[i];
            break;
        }
    bool foul = (facts & FOUL) != 0;
    struct ap_verdict v = {.what = row->what, .foul = foul, .spot = -1};
    if (foul && !(row->actions & (WINS | LOSES | SPOT_KEY)) && r->kind != AP_GAME_FREE)
        v.what = fault_name(facts);
    if (row->actions & SPOT_KEY)
        v.spot = g->key;
    v.stays = (row->actions & STAYS) != 0;
    follow(r, f, row->actions, facts);
    return v;
}
