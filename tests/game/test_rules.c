#include "tests/game/stage.h"

#include <unistd.h>

#include "src/base/file.h"
#include "src/game/game.h"
#include "src/game/rack.h"

enum { ALL = 0xffff, NINE_BALLS = 0x3ff };

// What is there before the shot, what it does, what follows.
struct line {
    const char *name;
    enum ap_game_kind kind;
    enum ap_game_phase phase;
    enum ap_game_group own;
    unsigned on_table, pocketed;
    int first_hit, first_pocketed;
    bool cushion;
    unsigned to_cushion;
    // Then:
    int turn, winner, spot;
    bool in_hand, foul;
    enum ap_game_group group_after;
};

#define EIGHT AP_GAME_EIGHT
#define NINE AP_GAME_NINE
#define BRK AP_PHASE_BREAK
#define OPN AP_PHASE_OPEN
#define GRP AP_PHASE_GROUPS
#define SOL AP_GROUP_SOLIDS
#define STR AP_GROUP_STRIPES

static const struct line lines[] = {
    {"dry break", EIGHT, BRK, 0, ALL, 0, 1, -1, true, 0xf0, 1, -1, -1, false, false, 0},
    {"poor break", EIGHT, BRK, 0, ALL, 0, 1, -1, true, 0x30, 1, -1, -1, true, false, 0},
    {"break with a ball", EIGHT, BRK, 0, ALL, 1 << 3, 1, 3, true, 0, 0, -1, -1, false, false, 0},
    {"eight at the break", EIGHT, BRK, 0, ALL, 1 << 8, 1, 8, true, 0, 0, -1, 8, false, false, 0},
    {"scratch and eight at the break", EIGHT, BRK, 0, ALL, 1 << 8 | 1, 1, 8, true, 0, 1, -1, 8,
     true, true, 0},
    {"open: stripe", EIGHT, OPN, 0, ALL, 1 << 12, 3, 12, true, 0, 0, -1, -1, false, false, STR},
    {"open: both, a solid first", EIGHT, OPN, 0, ALL, 1 << 12 | 4, 3, 2, true, 0, 0, -1, -1, false,
     false, SOL},
    {"open: the eight first", EIGHT, OPN, 0, ALL, 0, 8, -1, true, 0, 1, -1, -1, true, true, 0},
    {"own ball", EIGHT, GRP, SOL, ALL, 4, 3, 2, false, 0, 0, -1, -1, false, false, SOL},
    {"the other's ball", EIGHT, GRP, SOL, ALL, 1 << 12, 3, 12, false, 0, 1, -1, -1, false, false,
     SOL},
    {"wrong first", EIGHT, GRP, SOL, ALL, 4, 12, 2, true, 0, 1, -1, -1, true, true, SOL},
    {"nothing hit", EIGHT, GRP, SOL, ALL, 0, -1, -1, false, 0, 1, -1, -1, true, true, SOL},
    {"no cushion", EIGHT, GRP, SOL, ALL, 0, 3, -1, false, 0, 1, -1, -1, true, true, SOL},
    {"eight too early", EIGHT, GRP, SOL, ALL, 1 << 8, 3, 8, true, 0, 0, 1, -1, false, false, SOL},
    {"eight in turn", EIGHT, GRP, SOL, 0xff01, 1 << 8, 8, 8, true, 0, 0, 0, -1, false, false, SOL},
    {"eight and scratch", EIGHT, GRP, SOL, 0xff01, 1 << 8 | 1, 8, 8, true, 0, 0, 1, -1, false, true,
     SOL},
    {"eight due, missed", EIGHT, GRP, SOL, 0xff01, 0, 8, -1, true, 0, 1, -1, -1, false, false, SOL},
    {"eight due, other first", EIGHT, GRP, SOL, 0xff01, 0, 9, -1, true, 0, 1, -1, -1, true, true,
     SOL},
    {"nine by combination", NINE, OPN, 0, NINE_BALLS, 1 << 9, 1, 9, false, 0, 0, 0, -1, false,
     false, 0},
    {"nine with a foul", NINE, OPN, 0, NINE_BALLS, 1 << 9, 2, 9, false, 0, 1, -1, 9, true, true, 0},
    {"lowest is the three", NINE, OPN, 0, 0x3f9, 8, 3, 3, false, 0, 0, -1, -1, false, false, 0},
    {"not the lowest", NINE, OPN, 0, 0x3f9, 0, 4, -1, true, 0, 1, -1, -1, true, true, 0},
    {"free scratch", AP_GAME_FREE, OPN, 0, ALL, 1, 5, -1, true, 0, 0, -1, -1, true, true, 0},
    {"free miss", AP_GAME_FREE, OPN, 0, ALL, 0, -1, -1, false, 0, 0, -1, -1, false, false, 0},
};

static void test_rows(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
        const struct line *l = &lines[i];
        struct ap_rules r = ap_rules_start(l->kind, 4);
        r.phase = l->phase;
        r.in_hand = false;
        r.group[0] = l->own;
        r.group[1] = l->own == SOL ? STR : l->own == STR ? SOL : AP_GROUP_NONE;
        struct ap_shot_facts f = {.on_table = l->on_table,
                                  .pocketed = l->pocketed,
                                  .first_hit = l->first_hit,
                                  .first_pocketed = l->first_pocketed,
                                  .cushion_after = l->cushion,
                                  .to_cushion = l->to_cushion};
        struct ap_verdict v = ap_rules_judge(&r, &f);
        bool right = r.turn == l->turn && r.winner == l->winner && v.spot == l->spot &&
                     r.in_hand == l->in_hand && v.foul == l->foul && r.group[0] == l->group_after;
        if (!right)
            fail_msg("%s ('%s'): turn %d, winner %d, spot %d, in hand %d, foul %d, group %d",
                     l->name, v.what, r.turn, r.winner, v.spot, r.in_hand, v.foul, r.group[0]);
    }
}

// As many balls to a cushion as the table has sides.
static void test_sides(void **state) {
    (void)state;
    for (int sides = 3; sides <= 5; sides++)
        for (int n = 2; n <= 6; n++) {
            struct ap_rules r = ap_rules_start(AP_GAME_NINE, sides);
            struct ap_shot_facts f = {.on_table = NINE_BALLS,
                                      .first_hit = 1,
                                      .first_pocketed = -1,
                                      .cushion_after = true,
                                      .to_cushion = ((1u << n) - 1) << 1};
            ap_rules_judge(&r, &f);
            assert_int_equal(r.in_hand, n < sides);
        }
}

static void test_third_foul(void **state) {
    (void)state;
    struct ap_rules r = ap_rules_start(AP_GAME_NINE, 4);
    r.phase = AP_PHASE_OPEN;
    struct ap_shot_facts miss = {.on_table = NINE_BALLS, .first_hit = -1, .first_pocketed = -1};
    struct ap_shot_facts legal = {
        .on_table = NINE_BALLS, .first_hit = 1, .first_pocketed = -1, .cushion_after = true};
    for (int i = 0; i < 2; i++) {
        ap_rules_judge(&r, &miss);
        assert_int_equal(r.winner, -1);
        ap_rules_judge(&r, &legal);
    }
    ap_rules_judge(&r, &miss);
    assert_int_equal(r.winner, 1);
}

static void start(struct ap_game *g, int kappa, enum ap_game_kind kind) {
    struct ap_game_params params = {.kind = kind, .shape = ap_table_from_edge(kappa, 0.9, 1)};
    struct ap_error err = {""};
    if (ap_game_start(&err, &params, g))
        fail_msg("%s", err.text);
}

static void must(enum ap_status st, const struct ap_error *err) {
    if (st)
        fail_msg("%s", err->text);
}

// Aims at what may be hit, through the middle, at random speed.
static void shoot(struct ap_game *g, uint64_t *seed) {
    struct ap_error err = {""};
    if (g->physics.ball[0].state == AP_BALL_POCKETED)
        must(ap_game_place_anywhere(&err, g), &err);
    struct ap_shot_facts now;
    ap_shot_begin(&now, &g->physics);
    unsigned targets = ap_rules_targets(&g->rules, now.on_table);
    int target = 1;
    while (!(targets >> target & 1))
        target++;
    struct ap_strike s = {.direction = ap_physics_toward(&g->physics, 0, target),
                          .speed_m_s = 0.8 + 4 * random01(seed),
                          .right = 0.2 * random01(seed) - 0.1};
    must(ap_game_strike(&err, g, &s), &err);
}

static int on_table(const struct ap_game *g) {
    int n = 0;
    for (int i = 0; i < g->physics.ball_count; i++)
        n += g->physics.ball[i].state != AP_BALL_POCKETED;
    return n;
}

// Whole games by a clumsy player, in every space and of both kinds; they end, by the rules.
static void test_whole_games(void **state) {
    (void)state;
    for (int kappa = -1; kappa <= 1; kappa++)
        for (int kind = AP_GAME_EIGHT; kind <= AP_GAME_NINE; kind++) {
            static struct ap_game g;
            uint64_t seed = 11;
            start(&g, kappa, kind);
            char text[AP_GAME_TEXT_MAX];
            while (g.rules.winner < 0) {
                shoot(&g, &seed);
                while (!ap_game_advance(&g, g.physics.now_s + 0.5, NULL, NULL))
                    assert_true(g.physics.now_s < 10000);
                assert_true(g.shots < 400);
            }
            ap_game_text(&g, text);
            print_message("kappa %d: %d shots, %d balls left: %s\n", kappa, g.shots, on_table(&g),
                          text);
            assert_non_null(strstr(text, "has won"));
            struct ap_error err = {""};
            struct ap_strike s = {.direction = {1, 0, 0}, .speed_m_s = 1};
            assert_int_equal(ap_game_strike(&err, &g, &s), AP_INPUT);
        }
}

// Field by field: what is between them is nobody's.
static void expect_same_rules(const struct ap_rules *a, const struct ap_rules *b) {
    assert_int_equal(a->kind, b->kind);
    assert_int_equal(a->phase, b->phase);
    assert_int_equal(a->sides, b->sides);
    assert_int_equal(a->turn, b->turn);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(a->group[i], b->group[i]);
        assert_int_equal(a->fouls[i], b->fouls[i]);
    }
    assert_int_equal(a->winner, b->winner);
    assert_int_equal(a->in_hand, b->in_hand);
}

static void test_undo(void **state) {
    (void)state;
    static struct ap_game g, first;
    uint64_t seed = 5;
    struct ap_error err = {""};
    start(&g, -1, EIGHT);
    assert_int_equal(ap_game_undo(&err, &g), AP_INPUT);
    first = g;
    for (int i = 0; i < 3; i++) {
        shoot(&g, &seed);
        ap_game_advance(&g, g.physics.now_s + 60, NULL, NULL);
    }
    shoot(&g, &seed);
    ap_game_advance(&g, g.physics.now_s + 0.1, NULL, NULL); // in mid-shot
    assert_true(g.shooting);
    for (int i = 0; i < 4; i++)
        must(ap_game_undo(&err, &g), &err);
    assert_int_equal(g.shots, 0);
    for (int i = 0; i < 16; i++)
        assert_memory_equal(&g.physics.ball[i].world_from_foot,
                            &first.physics.ball[i].world_from_foot, sizeof(struct ap_plane_frame));
    expect_same_rules(&g.rules, &first.rules);
    shoot(&g, &seed);
}

static void test_in_hand(void **state) {
    (void)state;
    static struct ap_game g;
    struct ap_error err = {""};
    start(&g, 0, EIGHT);
    assert_int_equal(ap_game_place(&err, &g, (struct ap_plane2){0, 0.1}), AP_INPUT);
    assert_non_null(strstr(err.text, "head line"));
    must(ap_game_place(&err, &g, (struct ap_plane2){0.1, 0.3}), &err);
    uint64_t seed = 2;
    shoot(&g, &seed);
    assert_int_equal(ap_game_place(&err, &g, (struct ap_plane2){0, 0.3}), AP_INPUT);
    ap_game_advance(&g, 60, NULL, NULL);
    ap_physics_remove(&g.physics, 0);
    g.rules.in_hand = false;
    assert_int_equal(ap_game_place(&err, &g, (struct ap_plane2){0, 0.1}), AP_INPUT);
    struct ap_strike s = {.direction = {1, 0, 0}, .speed_m_s = 1};
    assert_int_equal(ap_game_strike(&err, &g, &s), AP_INPUT);
    assert_non_null(strstr(err.text, "in hand"));
    g.rules.in_hand = true;
    must(ap_game_place_anywhere(&err, &g), &err);
}

static void test_rack_too_big(void **state) {
    (void)state;
    static struct ap_game g;
    struct ap_error err = {""};
    struct ap_game_params params = {
        .kind = EIGHT, .shape = ap_table_from_edge(1, 0.9, 1), .physics = {.ball_radius_m = 0.07}};
    assert_int_equal(ap_game_start(&err, &params, &g), AP_INPUT);
    assert_non_null(strstr(err.text, "does not fit"));
}

static char *file_text(const char *path) {
    char *bytes;
    size_t len;
    assert_int_equal(ap_file_read(NULL, path, 1 << 20, &bytes, &len), AP_OK);
    return bytes;
}

// Saved in the middle of a shot and taken up again: it ends as it would have.
static void test_saved(void **state) {
    (void)state;
    char path[] = "/tmp/antipode-game-XXXXXX";
    close(mkstemp(path));
    for (int kappa = -1; kappa <= 1; kappa++) {
        static struct ap_game g, again;
        uint64_t seed = 5;
        struct ap_error err = {""};
        start(&g, kappa, NINE);
        shoot(&g, &seed);
        ap_game_advance(&g, 0.4, NULL, NULL);
        assert_true(g.shooting);
        must(ap_game_save(&err, &g, path), &err);
        must(ap_game_load(&err, path, &again), &err);
        assert_true(again.shooting && again.shots == 1 && again.physics.now_s == 0.4);
        check_near(ap_physics_energy(&again.physics), ap_physics_energy(&g.physics), 1e-15);
        // Chaos makes 1e-16 grow, so a short while.
        ap_game_advance(&g, 0.6, NULL, NULL);
        ap_game_advance(&again, 0.6, NULL, NULL);
        for (int i = 0; i < 10; i++)
            check_near(ap_plane_chord2(kappa, ap_physics_motion(&g.physics, i, 0.6).foot_m,
                                       ap_physics_motion(&again.physics, i, 0.6).foot_m),
                       0, 1e-16);
        assert_int_equal(again.facts.first_hit, g.facts.first_hit);
        assert_int_equal(again.facts.to_cushion, g.facts.to_cushion);
    }
    unlink(path);
}

static void put(const char *path, const char *text) {
    assert_int_equal(ap_file_write(NULL, path, text, strlen(text)), AP_OK);
}

static void expect_refused(const char *path, const char *text, const char *from, const char *to,
                           const char *says) {
    static struct ap_game g, before;
    start(&g, -1, NINE);
    before = g;
    const char *at = strstr(text, from);
    assert_non_null(at);
    char *bad = malloc(strlen(text) + strlen(to) + 1);
    if (!bad)
        abort();
    sprintf(bad, "%.*s%s%s", (int)(at - text), text, to, at + strlen(from));
    put(path, bad);
    struct ap_error err = {""};
    assert_int_equal(ap_game_load(&err, path, &g), AP_INPUT);
    if (!strstr(err.text, says))
        fail_msg("'%s' does not say '%s'", err.text, says);
    assert_memory_equal(&g, &before, sizeof g);
    char *still = file_text(path);
    assert_string_equal(still, bad);
    free(still);
    free(bad);
}

static void test_bad_files(void **state) {
    (void)state;
    char path[] = "/tmp/antipode-game-XXXXXX";
    close(mkstemp(path));
    static struct ap_game g;
    struct ap_error err = {""};
    start(&g, -1, NINE);
    must(ap_game_save(&err, &g, path), &err);
    char *text = file_text(path);
    expect_refused(path, text, "\"antipode_game\": 1", "\"antipode_game\": 2", "version 2");
    expect_refused(path, text, "\"antipode_game\"", "\"another\"", "no saved game");
    expect_refused(path, text, "nine-ball", "ten-ball", "/rules/game");
    expect_refused(path, text, "\"turn\": 0", "\"turn\": 7", "/rules/turn");
    expect_refused(path, text, "\"phase\": 0", "\"phase\": 2", "/rules/groups");
    expect_refused(path, text, "\"edge_m\": 0.9", "\"edge_m\": 1.9", "/table");
    expect_refused(path, text, "\"shots\": 0", "\"shots\": 0, \"more\": 1", "more");
    expect_refused(path, text, "\"world_from_foot\": [\n    1.0", "\"world_from_foot\": [\n    1.5",
                   "/balls/0");
    expect_refused(path, text, "\"ball_radius_m\": 0.0", "\"ball_radius_m\": 0.9", "/physics");
    free(text);
    unlink(path);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rows),         cmocka_unit_test(test_sides),
        cmocka_unit_test(test_third_foul),   cmocka_unit_test(test_whole_games),
        cmocka_unit_test(test_undo),         cmocka_unit_test(test_in_hand),
        cmocka_unit_test(test_rack_too_big), cmocka_unit_test(test_saved),
        cmocka_unit_test(test_bad_files)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
