#include "tests/game/stage.h"

#include "src/game/shots.h"

static struct ap_shots *parse(const char *text) {
    struct ap_shots *shots = NULL;
    struct ap_error err = {""};
    if (ap_shots_parse(&err, "s.txt", text, strlen(text), &shots))
        fail_msg("%s", err.text);
    return shots;
}

static void start(struct ap_game *g, int kappa, enum ap_game_kind kind,
                  const struct ap_shots *shots) {
    struct ap_game_params params = {.kind = kind, .shape = ap_table_from_edge(kappa, 0.9, 1)};
    struct ap_error err = {""};
    params.physics = shots->physics;
    if (ap_game_start(&err, &params, g))
        fail_msg("%s", err.text);
}

static void test_bad_lines(void **state) {
    (void)state;
    static const struct {
        const char *text, *says;
    } bad[] = {
        {"\n# ok\nshoot at=1\n", "s.txt:3: no command 'shoot'"},
        {"shot at=1\n", "s.txt:1: a shot needs speed"},
        {"shot speed=1\n", "aimed by"},
        {"shot at=1 angle=0 speed=1\n", "aimed by"},
        {"shot at=16 speed=1\n", "a ball's number"},
        {"shot at=1.5 speed=1\n", "a ball's number"},
        {"shot at=1e300 speed=1\n", "a ball's number"},
        {"shot angle=nan speed=1\n", "finite number"},
        {"shot angle=0x1 speed=1\n", "finite number"},
        {"shot angle speed=1\n", "KEY=VALUE"},
        {"shot angle=0 speed=1 spin=3\n", "'spin' is not known"},
        {"place x=1\n", "x=METRES"},
        {"ball x=1 z=0\n", "n=BALL"},
        {"place\nset gravity_m_s2=3\n", "s.txt:2: set"},
        {"set mass=3\n", "'mass' is not known"},
        {"end\n", "end needs time"},
        {"rack x=1\n", "'x' is not known"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct ap_shots *shots = NULL;
        struct ap_error err = {""};
        assert_int_equal(ap_shots_parse(&err, "s.txt", bad[i].text, strlen(bad[i].text), &shots),
                         AP_INPUT);
        assert_null(shots);
        if (!strstr(err.text, bad[i].says))
            fail_msg("'%s' does not say '%s'", err.text, bad[i].says);
    }
}

static const char script[] = "set slide_friction=0.21 ball_friction=0 # felt\r\n"
                             "shot at=1 speed=5 above=0.2 right=-0.1\n\n"
                             "place\nshot angle=0.4 speed=2 elevation=0.5 right=0.3\n"
                             "undo\n"
                             "place\nshot at=8 turn=0.01 speed=2 time=20\n";

static void play(struct ap_game *g, const struct ap_shots *shots, double step_s, double until_s) {
    struct ap_shot_player player = {.shots = shots, .pause_s = 0.5};
    struct ap_error err = {""};
    for (int k = 1; k * step_s <= until_s + 1e-9; k++)
        if (ap_shot_player_run(&err, &player, g, fmin(k * step_s, until_s), NULL))
            fail_msg("%s", err.text);
    assert_true(ap_shot_player_done(&player, g));
}

// The same bits at every frame rate, in every space.
static void test_frame_rates(void **state) {
    (void)state;
    for (int kappa = -1; kappa <= 1; kappa++) {
        struct ap_shots *shots = parse(script);
        assert_int_equal(shots->count, 6);
        static struct ap_game a, b;
        start(&a, kappa, AP_GAME_FREE, shots);
        assert_true(a.physics.params.slide_friction == 0.21);
        assert_true(a.physics.params.ball_friction == 0);
        b = a;
        play(&a, shots, 1.0 / 90, 60);
        play(&b, shots, 7.5, 60);
        assert_int_equal(a.shots, 2);
        for (int i = 0; i < 16; i++) {
            struct ap_iso p = ap_physics_world_from_ball(&a.physics, i);
            struct ap_iso q = ap_physics_world_from_ball(&b.physics, i);
            assert_memory_equal(&p, &q, sizeof p);
        }
        ap_shots_destroy(shots);
    }
}

// A person takes a shot back, racks anew and goes home while balls move; the same at every rate.
static void test_in_the_middle(void **state) {
    (void)state;
    static const char text[] = "shot at=1 speed=5\nundo time=1.25\nshot at=1 speed=4 time=2\n"
                               "rack time=2.75\nshot angle=0.1 speed=3 time=3.5\nend time=4.125\n"
                               "shot angle=0 speed=1\n";
    for (int kappa = -1; kappa <= 1; kappa++) {
        struct ap_shots *shots = parse(text);
        static struct ap_game a, b;
        assert_true(ap_shots_end_s(shots) == 4.125);
        start(&a, kappa, AP_GAME_EIGHT, shots);
        b = a;
        play(&a, shots, 1.0 / 90, 60);
        play(&b, shots, 7.5, 60);
        assert_true(a.physics.now_s == 4.125 && b.physics.now_s == 4.125);
        assert_true(a.shooting && b.shooting);
        assert_int_equal(a.shots, 1);
        assert_int_equal(a.undo_count, 1); // racking forgets
        for (int i = 0; i < 16; i++) {
            struct ap_iso p = ap_physics_world_from_ball(&a.physics, i);
            struct ap_iso q = ap_physics_world_from_ball(&b.physics, i);
            assert_memory_equal(&p, &q, sizeof p);
        }
        ap_shots_destroy(shots);
    }
}

// A recorded stroke is the stroke.
static void test_recorded(void **state) {
    (void)state;
    for (int kappa = -1; kappa <= 1; kappa++) {
        struct ap_shots *none = parse("");
        static struct ap_game g, again;
        struct ap_error err = {""};
        char text[AP_SHOT_TEXT_MAX];
        start(&g, kappa, AP_GAME_FREE, none);
        place(&g.physics, 0, 0.05, 0.2);
        again = g;
        struct ap_strike s = {.direction = ap_physics_toward(&g.physics, 0, 6),
                              .speed_m_s = 1.2345678901234567,
                              .right = -0.1,
                              .above = 0.3,
                              .elevation_rad = 0.1};
        ap_shot_text(&g.physics, &s, 2.5, text);
        strike(&g.physics, 0, &s);
        struct ap_shots *shots = parse(text);
        struct ap_shot_player player = {.shots = shots};
        assert_int_equal(ap_shot_player_run(&err, &player, &again, 2.5, NULL), AP_OK);
        assert_true(again.shots == 1);
        struct ap_ball_motion p = ap_physics_motion(&g.physics, 0, 0),
                              q = ap_physics_motion(&again.physics, 0, 2.5);
        check_near(q.velocity_m_s.x, p.velocity_m_s.x, 1e-14);
        check_near(q.velocity_m_s.z, p.velocity_m_s.z, 1e-14);
        check_near(q.rolling_rad_s.x, p.rolling_rad_s.x, 1e-12);
        check_near(q.spin_rad_s, p.spin_rad_s, 1e-12);
        ap_shots_destroy(shots);
        ap_shots_destroy(none);
    }
}

static void test_unplayable(void **state) {
    (void)state;
    struct ap_shots *shots = parse("clear\nball n=0 x=0 z=0\nball n=3 x=0.01 z=0\n");
    static struct ap_game g;
    struct ap_error err = {""};
    start(&g, 0, AP_GAME_FREE, shots);
    struct ap_shot_player player = {.shots = shots};
    assert_int_equal(ap_shot_player_run(&err, &player, &g, 1, NULL), AP_INPUT);
    if (!strstr(err.text, "s.txt:3: there ball 3 would overlap ball 0"))
        fail_msg("%s", err.text);
    start(&g, 0, AP_GAME_EIGHT, shots);
    player.next = 0;
    assert_int_equal(ap_shot_player_run(&err, &player, &g, 1, NULL), AP_INPUT);
    assert_non_null(strstr(err.text, "only in free play"));
    ap_shots_destroy(shots);
}

// Whatever bytes: an error or a script, and nothing read beyond the end.
static void test_any_bytes(void **state) {
    (void)state;
    uint64_t seed = 1;
    for (int i = 0; i < 3000; i++) {
        char text[sizeof script];
        memcpy(text, script, sizeof script);
        for (int k = 0; k < 4; k++)
            text[(size_t)(random01(&seed) * (sizeof script - 1))] = (char)(random01(&seed) * 256);
        size_t len = (size_t)(random01(&seed) * sizeof script);
        char *exact = malloc(len + 1);
        memcpy(exact, text, len);
        struct ap_shots *shots = NULL;
        struct ap_error err = {""};
        enum ap_status st = ap_shots_parse(&err, "s", exact, len, &shots);
        assert_true(st == AP_OK || (st == AP_INPUT && err.text[0]));
        ap_shots_destroy(shots);
        free(exact);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bad_lines),     cmocka_unit_test(test_frame_rates),
        cmocka_unit_test(test_in_the_middle), cmocka_unit_test(test_recorded),
        cmocka_unit_test(test_unplayable),    cmocka_unit_test(test_any_bytes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
