#include "src/game/game.h"

#include <stdio.h>
#include <string.h>

#include "src/game/rack.h"

enum ap_status ap_game_start(struct ap_error *err, const struct ap_game_params *params,
                             struct ap_game *game) {
    static const struct ap_game none;
    struct ap_physics physics;
    enum ap_status st = ap_physics_init(err, &params->shape, &params->physics, &physics);
    if (!st)
        st = ap_rack_set(err, &physics, params->kind);
    if (st)
        return st;
    *game = none;
    game->physics = physics;
    game->rules = ap_rules_start(params->kind, params->shape.sides);
    game->verdict = (struct ap_verdict){.what = "", .spot = -1};
    return AP_OK;
}

enum ap_status ap_game_rack(struct ap_error *err, struct ap_game *g) {
    struct ap_physics physics = g->physics;
    physics.told_count = physics.told_next = 0;
    for (int i = 0; i < physics.ball_count; i++)
        ap_physics_remove(&physics, i);
    enum ap_status st = ap_rack_set(err, &physics, g->rules.kind);
    if (st)
        return st;
    physics.changed_s = physics.now_s;
    g->physics = physics;
    g->rules = ap_rules_start(g->rules.kind, g->rules.sides);
    g->verdict = (struct ap_verdict){.what = "", .spot = -1};
    g->shooting = false;
    g->shots = g->undo_count = 0;
    return AP_OK;
}

static bool cue_on_table(const struct ap_game *g) {
    return g->physics.ball[0].state != AP_BALL_POCKETED;
}

enum ap_status ap_game_place(struct ap_error *err, struct ap_game *g, struct ap_plane2 at) {
    if (g->shooting)
        return ap_fail(err, AP_INPUT, "the cue ball cannot be placed while balls move");
    if (!g->rules.in_hand)
        return ap_fail(err, AP_INPUT, "the cue ball is not in hand: play it where it lies");
    bool line = g->rules.phase == AP_PHASE_BREAK && g->rules.kind != AP_GAME_FREE;
    if (line && !(at.z >= ap_rack_head_line(&g->physics)))
        return ap_fail(err, AP_INPUT,
                       "at the break the cue ball stands behind the head line, z at least %.4g m",
                       ap_rack_head_line(&g->physics));
    return ap_physics_place(err, &g->physics, 0, at);
}

enum ap_status ap_game_place_anywhere(struct ap_error *err, struct ap_game *g) {
    struct ap_plane2 at;
    if (!ap_rack_free_place(&g->physics, 0, ap_rack_head_spot(&g->physics), &at))
        return ap_fail(err, AP_INPUT, "there is no room for the cue ball");
    return ap_game_place(err, g, at);
}

static void keep(struct ap_game *g) {
    if (g->undo_count == AP_UNDO_MAX)
        memmove(g->undo, g->undo + 1, --g->undo_count * sizeof *g->undo);
    struct ap_game_snapshot *s = &g->undo[g->undo_count++];
    s->rules = g->rules;
    s->shots = g->shots;
    for (int i = 0; i < g->physics.ball_count; i++) {
        const struct ap_ball *b = &g->physics.ball[i];
        s->ball[i].foot = b->world_from_foot;
        s->ball[i].turn = b->foot_from_ball;
        s->ball[i].pocket = b->pocket;
        s->ball[i].on_table = b->state != AP_BALL_POCKETED;
    }
}

enum ap_status ap_game_strike(struct ap_error *err, struct ap_game *g,
                              const struct ap_strike *strike) {
    if (g->rules.winner >= 0)
        return ap_fail(err, AP_INPUT, "the game is over: player %d has won", g->rules.winner + 1);
    if (g->shooting || !ap_physics_at_rest(&g->physics))
        return ap_fail(err, AP_INPUT, "the balls still move: wait for them");
    if (!cue_on_table(g))
        return ap_fail(err, AP_INPUT, "the cue ball is in hand: place it first");
    struct ap_shot_facts facts;
    ap_shot_begin(&facts, &g->physics);
    struct ap_physics before = g->physics;
    enum ap_status st = ap_physics_strike(err, &g->physics, 0, strike);
    if (st)
        return st;
    struct ap_physics struck = g->physics;
    g->physics = before;
    keep(g);
    g->physics = struck;
    g->facts = facts;
    g->shooting = true;
    g->shots++;
    return AP_OK;
}

static void put_back(struct ap_physics *ph, int ball) {
    struct ap_plane2 at;
    if (ap_rack_free_place(ph, ball, ap_rack_foot_spot(ph), &at))
        ap_physics_place(NULL, ph, ball, at);
}

static void judge(struct ap_game *g) {
    g->shooting = false;
    g->verdict = ap_rules_judge(&g->rules, &g->facts);
    if (g->verdict.spot >= 0)
        put_back(&g->physics, g->verdict.spot);
}

bool ap_game_advance(struct ap_game *g, double until_s,
                     void (*seen)(void *data, const struct ap_physics_event *event), void *data) {
    struct ap_physics_event event;
    bool judged = false;
    while (ap_physics_next(&g->physics, until_s, &event)) {
        if (g->shooting)
            ap_shot_note(&g->facts, &event);
        if (seen)
            seen(data, &event);
    }
    if (g->shooting && ap_physics_at_rest(&g->physics)) {
        // The moment is that of the rest, not of who asked.
        g->physics.now_s = g->physics.changed_s;
        judge(g);
        judged = true;
    }
    return judged;
}

enum ap_status ap_game_undo(struct ap_error *err, struct ap_game *g) {
    if (g->undo_count == 0)
        return ap_fail(err, AP_INPUT, "there is no shot to take back");
    const struct ap_game_snapshot *s = &g->undo[--g->undo_count];
    for (int i = 0; i < g->physics.ball_count; i++) {
        ap_physics_remove(&g->physics, i);
        g->physics.ball[i].pocket = s->ball[i].pocket;
    }
    for (int i = 0; i < g->physics.ball_count; i++)
        if (s->ball[i].on_table)
            ap_physics_set(&g->physics, i, &s->ball[i].foot, (struct ap_plane2){0, 0},
                           (struct ap_vec3){0, 0, 0}, s->ball[i].turn);
    g->rules = s->rules;
    g->shots = s->shots;
    g->shooting = false;
    g->verdict = (struct ap_verdict){.what = "taken back", .spot = -1};
    return AP_OK;
}

static int left_of(const struct ap_game *g, enum ap_game_group group) {
    int n = 0;
    for (int i = 1; i < g->physics.ball_count; i++)
        if (i != 8 && (i > 8) == (group == AP_GROUP_STRIPES) &&
            g->physics.ball[i].state != AP_BALL_POCKETED)
            n++;
    return n;
}

void ap_game_text(const struct ap_game *g, char text[AP_GAME_TEXT_MAX]) {
    const struct ap_rules *r = &g->rules;
    char aim[64] = "";
    struct ap_shot_facts now;
    ap_shot_begin(&now, &g->physics);
    unsigned targets = ap_rules_targets(r, now.on_table);
    if (r->winner >= 0) {
        snprintf(text, AP_GAME_TEXT_MAX, "%s: player %d has won (%s)", ap_game_kind_name(r->kind),
                 r->winner + 1, g->verdict.what);
        return;
    }
    if (r->kind == AP_GAME_NINE)
        for (int i = 1; i < AP_BALLS_MAX; i++)
            if (targets == 1u << i)
                snprintf(aim, sizeof aim, ", the %d first", i);
    if (r->kind == AP_GAME_EIGHT && r->phase == AP_PHASE_GROUPS) {
        enum ap_game_group own = r->group[r->turn];
        if (targets == 1u << 8)
            snprintf(aim, sizeof aim, ", the 8");
        else
            snprintf(aim, sizeof aim, ", %s, %d left",
                     own == AP_GROUP_SOLIDS ? "solids" : "stripes", left_of(g, own));
    }
    snprintf(text, AP_GAME_TEXT_MAX, "%s: player %d%s%s%s%s", ap_game_kind_name(r->kind),
             r->turn + 1, aim, r->in_hand ? ", cue ball in hand" : "",
             g->verdict.what[0] ? "; " : "", g->verdict.what);
}
