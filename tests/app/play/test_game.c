#include "tests/check_near.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "src/app/play/board.h"
#include "src/app/play/game.h"
#include "src/base/file.h"
#include "src/geom/map.h"

// The game of a live session without headset and GPU: frames are made up here.

static const double frame_s = 1.0 / 90, R_m = 0.028575, tip_m = 0.0058;
static const char *const spaces[3] = {"s3", "e3", "h3"};
static char dir[64];

static int make_dir(void **state) {
    (void)state;
    snprintf(dir, sizeof dir, "/tmp/antipode-game-test-XXXXXX");
    return mkdtemp(dir) ? 0 : -1;
}

static int remove_dir(void **state) {
    (void)state;
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s", dir);
    return system(command);
}

struct stage {
    struct ap_scene *scene;
    struct ap_play_game *game;
    struct ap_xr_frame frame;
    struct ap_frame_input placed;
};

static void open_stage(struct stage *s, const char *space, const char *kind, const char *path) {
    const struct ap_scene_params params = {.space_name = space};
    struct ap_error err;
    *s = (struct stage){.placed.viewer.world_from_nose = AP_ISO_IDENTITY};
    if (ap_scene_billiards(&err, &params, &s->scene))
        fail_msg("%s", err.text);
    const struct ap_play_game_params game = {.scene = s->scene, .kind = kind, .path = path};
    if (ap_play_game_open(&err, &game, &s->game))
        fail_msg("%s: %s", space, err.text);
    s->frame.time_ns = 1000000000;
    s->frame.head.valid = s->frame.head.tracked = true;
    s->placed.viewer.world_from_nose =
        ap_iso_translate(s->scene->space, (struct ap_vec3){0.05, 0.5, 0.5});
}

static void close_stage(struct stage *s) {
    ap_play_game_close(s->game);
    ap_scene_destroy(s->scene);
}

static void step(struct stage *s, bool still) {
    ap_play_game_step(s->game, &s->frame, &s->placed, still);
    s->frame.time_ns += llround(frame_s * 1e9);
}

static struct ap_game *game_of(const struct stage *s) {
    return &s->game->table->game;
}

static void track(struct stage *s, int hand, bool tracked, struct ap_iso world_from_hand) {
    s->frame.hand[hand].grip.valid = s->frame.hand[hand].grip.tracked = tracked;
    s->placed.hand_tracked[hand] = tracked;
    s->placed.world_from_hand[hand] = world_from_hand;
}

// Both hands on a cue that goes along the ball's −z at v and meets it at (right, above) when t = 0.
static void hold(struct stage *s, double t, double v, double right, double above) {
    struct ap_space space = s->scene->space;
    double r = R_m + tip_m, back = sqrt(1 - right * right - above * above);
    struct ap_vec3 tip = {right * r, above * r, back * r - v * t};
    struct ap_iso at =
        ap_iso_mul(ap_cue_ball(&game_of(s)->physics, 0), ap_iso_translate(space, tip));
    struct ap_iso rear = ap_iso_translate(space, (struct ap_vec3){0, 0, 0.75});
    struct ap_iso bridge = ap_iso_translate(space, (struct ap_vec3){0, 0, 0.2});
    track(s, 1, true, ap_iso_mul(at, rear));
    track(s, 0, true, ap_iso_mul(at, bridge));
}

static double cue_ball_way(const struct stage *s, struct ap_plane3 from) {
    const struct ap_physics *ph = &game_of(s)->physics;
    return ap_plane_distance(
        ph->shape.space,
        ap_plane_chord2(ph->shape.space.kappa, from, ap_physics_motion(ph, 0, ph->now_s).foot_m));
}

static struct ap_plane3 cue_ball(const struct stage *s) {
    return ap_physics_motion(&game_of(s)->physics, 0, game_of(s)->physics.now_s).foot_m;
}

// The ball goes off as the physics says: at (1 + e)·v/(1 + m/M), less what sliding takes.
static void hands_strike(void **state) {
    (void)state;
    for (int k = 0; k < 3; k++) {
        struct stage s;
        const double v = 1.1;
        open_stage(&s, spaces[k], "free", NULL);
        struct ap_plane3 from = cue_ball(&s);
        int frame = -30;
        for (; frame < 6; frame++) {
            if (s.game->strikes == 0)
                hold(&s, (frame + 0.37) * frame_s, v, 0, 0);
            step(&s, false);
        }
        assert_int_equal(s.game->strikes, 1);
        double t = (frame - 1 + 0.37) * frame_s, v0 = 1.75 * v / (1 + 0.17 / 0.54);
        double want_m = v0 * t - 0.2 * 9.81 * t * t / 2;
        printf("%s: struck at %g m/s, %.9g m in %.3g s, by the closed form %.9g\n", spaces[k], v,
               cue_ball_way(&s, from), t, want_m);
        check_near(cue_ball_way(&s, from), want_m, 2e-6);
        assert_true(game_of(&s)->shooting);
        close_stage(&s);
    }
}

static bool parts_are_finite(const struct stage *s) {
    for (size_t i = 0; i < s->scene->part_count; i++)
        for (int k = 0; k < 16; k++)
            if (!isfinite(s->scene->parts[i].carrier_from_part.m[k / 4][k % 4]))
                return false;
    return true;
}

// What breaks in the middle of a stroke: the right hand's loss or NaN strikes nothing, the left's
// leaves the cue where it lay.
static void faults_while_striking(void **state) {
    (void)state;
    enum { LEFT_LOST, LEFT_NAN, RIGHT_LOST, RIGHT_NAN, KINDS };
    for (int k = 0; k < 3; k++)
        for (int kind = 0; kind < KINDS; kind++) {
            struct stage s;
            struct ap_iso nan = AP_ISO_IDENTITY;
            nan.m[1][3] = NAN;
            open_stage(&s, spaces[k], "free", NULL);
            for (int frame = -30; frame < 6 && s.game->strikes == 0; frame++) {
                hold(&s, (frame + 0.37) * frame_s, 1.1, 0, 0);
                int hand = kind >= RIGHT_LOST;
                if (frame >= -2 && (kind == LEFT_LOST || kind == RIGHT_LOST))
                    track(&s, hand, false, s.placed.world_from_hand[hand]);
                else if (frame >= -2)
                    track(&s, hand, true, nan);
                step(&s, false);
                assert_true(parts_are_finite(&s));
            }
            assert_int_equal(s.game->strikes, kind == LEFT_LOST || kind == LEFT_NAN);
            close_stage(&s);
        }
}

// A head that looks from behind the cue ball down to the middle of the rack.
static void look(struct stage *s, double x_m, double z_m) {
    struct ap_space space = s->scene->space;
    struct ap_vec3 eye = {0.02, 0.45, 0.5};
    struct ap_iso from = ap_iso_translate(space, eye);
    struct ap_vec4 at = ap_exp(space, (struct ap_vec3){x_m, 0, z_m});
    struct ap_iso back = ap_iso_inverse(space, from);
    struct ap_vec3 to = ap_vec3_normalize(ap_log_unchecked(space, ap_iso_apply(&back, at), 0));
    struct ap_vec3 ahead = {0, 0, -1}, axis = ap_vec3_cross(ahead, to);
    double angle = acos(fmax(-1, fmin(1, ap_vec3_dot(ahead, to))));
    s->placed.viewer.world_from_nose =
        ap_iso_mul(from, ap_iso_rotate(ap_quat_from_axis_angle(ap_vec3_normalize(axis), angle)));
}

static int shown_dots(const struct stage *s) {
    int n = 0;
    for (int i = 0; i < AP_PLAY_LINE_DOTS; i++)
        n += !s->scene->parts[s->game->lines.first + (size_t)i].hidden;
    return n;
}

static void press(struct stage *s, float trigger, bool place) {
    s->frame.hand[1].trigger = trigger;
    s->frame.hand[1].primary = place;
    step(s, false);
    s->frame.hand[1].trigger = 0;
    s->frame.hand[1].primary = false;
    step(s, false);
}

// Squeeze, look, strike: the ball's line leads over what was looked at. Every dot of the path that
// was shown lies where a ball's centre then goes.
static void eyes_aim(void **state) {
    (void)state;
    for (int k = 0; k < 3; k++) {
        struct stage s;
        open_stage(&s, spaces[k], "free", NULL);
        struct ap_physics *ph = &game_of(&s)->physics;
        struct ap_space space = ph->shape.space;
        look(&s, -0.05, -0.12);
        step(&s, false);
        press(&s, 1, false); // without the squeeze: nothing
        assert_int_equal(s.game->strikes, 0);
        s.frame.hand[1].squeeze = 1;
        s.frame.hand[1].stick_y = 1;
        step(&s, false);
        double slow = s.game->aim.speed_m_s;
        step(&s, false);
        check_near(s.game->aim.speed_m_s, slow * exp(1.5 * frame_s), 1e-6);
        s.frame.hand[1].stick_y = 0;
        struct ap_plane3 t = s.game->aim.target_m;
        struct ap_vec4 want = ap_exp(space, (struct ap_vec3){-0.05, 0, -0.12});
        check_near(t.x, want.x, 1e-12);
        check_near(t.z, want.z, 1e-12);
        assert_int_equal(shown_dots(&s), 0);
        s.game->shows_lines = true;
        step(&s, false);
        assert_true(shown_dots(&s) > 10);
        struct ap_plane3 from = cue_ball(&s), toward = ap_physics_toward_point(ph, 0, t);
        press(&s, 1, false);
        assert_int_equal(s.game->strikes, 1);
        assert_int_equal(shown_dots(&s), 0);
        struct ap_plane3 v = ap_physics_motion(ph, 0, ph->now_s).velocity_m_s;
        struct ap_plane3 now = cue_ball(&s);
        // On the plane through the base, the start and the target's direction.
        double off = (from.z * toward.w - from.w * toward.z) * now.x +
                     (from.w * toward.x - from.x * toward.w) * now.z +
                     (from.x * toward.z - from.z * toward.x) * now.w;
        check_near(off, 0, 1e-12);
        assert_true(ap_plane_dot(space.kappa, v, v) > 0.1);
        press(&s, 1, false); // the balls move
        assert_int_equal(s.game->strikes, 1);
        assert_non_null(strstr(s.game->says, "still move"));
        close_stage(&s);
    }
}

// The ball goes where the dots were: within what it goes in a tenth of a millisecond.
static void path_is_gone(void **state) {
    (void)state;
    struct stage s;
    open_stage(&s, "h3", "free", NULL);
    s.game->shows_lines = true;
    look(&s, -0.3, 0.1); // past the rack
    s.frame.hand[1].squeeze = 1;
    step(&s, false);
    step(&s, false);
    int dots = (int)fmin(60, shown_dots(&s)); // of the first seconds
    struct ap_iso dot[AP_PLAY_LINE_DOTS];
    double nearest[AP_PLAY_LINE_DOTS];
    for (int i = 0; i < dots; i++) {
        dot[i] = s.scene->parts[s.game->lines.first + (size_t)i].carrier_from_part;
        nearest[i] = INFINITY;
    }
    assert_true(dots > 10);
    s.frame.hand[1].trigger = 1;
    step(&s, false);
    s.frame.hand[1].squeeze = s.frame.hand[1].trigger = 0;
    struct ap_physics *ph = &game_of(&s)->physics;
    assert_true(game_of(&s)->shooting);
    for (int n = 0; n < 30000 && game_of(&s)->shooting; n++) {
        ap_game_advance(game_of(&s), ph->now_s + 1e-4, NULL, NULL);
        for (int b = 0; b < ph->ball_count; b++) {
            struct ap_iso m = ap_physics_world_from_ball(ph, b);
            for (int i = 0; i < dots; i++) {
                double d = 0;
                for (int r = 0; r < 3; r++)
                    d += pow(m.m[r][3] - dot[i].m[r][3], 2);
                nearest[i] = fmin(nearest[i], sqrt(d) * ph->shape.space.rho_m);
            }
        }
    }
    double worst = 0;
    for (int i = 0; i < dots; i++)
        worst = fmax(worst, nearest[i]);
    printf("%d dots, at most %.2g m from where a ball went\n", dots, worst);
    check_near(worst, 0, 3e-4);
    close_stage(&s);
}

// At the break the cue ball is in hand: behind the head line it may be put, elsewhere not.
static void ball_in_hand(void **state) {
    (void)state;
    for (int k = 0; k < 3; k++) {
        struct stage s;
        open_stage(&s, spaces[k], "eight-ball", NULL);
        s.frame.hand[1].squeeze = 1;
        double z = 0.65 * game_of(&s)->physics.shape.inradius_m;
        look(&s, 0.06, z);
        step(&s, false);
        press(&s, 0, true);
        struct ap_vec4 want = ap_exp(s.scene->space, (struct ap_vec3){0.06, 0, z});
        check_near(cue_ball(&s).x, want.x, 1e-12);
        check_near(cue_ball(&s).z, want.z, 1e-12);
        assert_string_equal(s.game->says, "");
        look(&s, 0.06, 0);
        press(&s, 0, true);
        assert_non_null(strstr(s.game->says, "head line"));
        check_near(cue_ball(&s).z, want.z, 1e-12);
        close_stage(&s);
    }
}

static void strike_ahead(struct stage *s, double speed_m_s) {
    s->game->aim.speed_m_s = speed_m_s;
    s->frame.hand[1].squeeze = 1;
    look(s, 0, -0.1);
    step(s, false);
    press(s, 1, false);
    s->frame.hand[1].squeeze = 0;
    assert_true(game_of(s)->shooting);
}

static void menu_racks_and_undoes(void **state) {
    (void)state;
    struct stage s;
    open_stage(&s, "h3", "eight-ball", NULL);
    struct ap_plane3 spot = cue_ball(&s);
    ap_play_game_undo(s.game);
    assert_non_null(strstr(s.game->says, "no shot to take back"));
    strike_ahead(&s, 5);
    for (int i = 0; i < 20; i++)
        step(&s, false);
    // While the menu is open nothing goes on.
    double now_s = game_of(&s)->physics.now_s;
    struct ap_plane3 there = cue_ball(&s);
    for (int i = 0; i < 50; i++)
        step(&s, true);
    assert_true(game_of(&s)->physics.now_s == now_s);
    assert_true(cue_ball(&s).z == there.z);
    ap_play_game_undo(s.game); // in the middle of the shot
    assert_false(game_of(&s)->shooting);
    check_near(cue_ball(&s).z, spot.z, 1e-15);
    for (int shot = 0; shot < 2; shot++) {
        if (game_of(&s)->physics.ball[0].state == AP_BALL_POCKETED)
            ap_game_place_anywhere(NULL, game_of(&s));
        strike_ahead(&s, 5);
        for (int i = 0; i < 4000 && game_of(&s)->shooting; i++)
            step(&s, false);
        assert_false(game_of(&s)->shooting);
    }
    ap_play_game_rack(s.game);
    assert_int_equal(game_of(&s)->shots, 0);
    assert_int_equal(game_of(&s)->rules.phase, AP_PHASE_BREAK);
    check_near(cue_ball(&s).z, spot.z, 1e-15);
    for (int i = 0; i < 16; i++)
        assert_int_equal(game_of(&s)->physics.ball[i].state, AP_BALL_AT_REST);
    close_stage(&s);
}

// Ended in the middle of a shot, the game goes on from there.
static void game_is_kept(void **state) {
    (void)state;
    for (int k = 0; k < 3; k++) {
        struct stage s;
        char path[128];
        snprintf(path, sizeof path, "%s/deep/%s.json", dir, spaces[k]);
        open_stage(&s, spaces[k], "eight-ball", path);
        close_stage(&s);
        assert_false(ap_file_exists(path)); // nothing was played
        open_stage(&s, spaces[k], "eight-ball", path);
        strike_ahead(&s, 4);
        for (int i = 0; i < 30; i++)
            step(&s, false);
        struct ap_game was = *game_of(&s);
        close_stage(&s);
        open_stage(&s, spaces[k], "eight-ball", path);
        assert_true(game_of(&s)->shooting);
        assert_true(game_of(&s)->physics.now_s == was.physics.now_s);
        ap_game_advance(game_of(&s), was.physics.now_s + 60, NULL, NULL);
        ap_game_advance(&was, was.physics.now_s + 60, NULL, NULL);
        assert_string_equal(game_of(&s)->verdict.what, was.verdict.what);
        assert_int_equal(game_of(&s)->rules.turn, was.rules.turn);
        s.game->dirty = true;
        close_stage(&s);
        // Another kind is another game.
        open_stage(&s, spaces[k], "free", NULL);
        assert_int_equal(game_of(&s)->shots, 0);
        close_stage(&s);
    }
}

// A file that cannot be gone on with is kept under another name, byte for byte.
static void strange_files_are_kept(void **state) {
    (void)state;
    static const char *const texts[] = {"{\"antipode_game\": 99}", "{", "", "[1, 2]"};
    for (int i = 0; i < 4; i++) {
        struct stage s;
        char path[128], other[160], *bytes;
        size_t len;
        struct ap_error err;
        snprintf(path, sizeof path, "%s/strange.json", dir);
        snprintf(other, sizeof other, "%s.%d", path, i + 1);
        assert_int_equal(ap_file_write(&err, path, texts[i], strlen(texts[i])), AP_OK);
        open_stage(&s, "h3", "eight-ball", path);
        assert_int_equal(game_of(&s)->shots, 0);
        strike_ahead(&s, 2);
        close_stage(&s);
        if (ap_file_read(&err, other, 1000, &bytes, &len))
            fail_msg("%s", err.text);
        assert_string_equal(bytes, texts[i]);
        free(bytes);
        // And what was played since is there.
        open_stage(&s, "h3", "eight-ball", path);
        assert_int_equal(game_of(&s)->shots, 1);
        close_stage(&s);
        assert_int_equal(unlink(path), 0);
    }
    // A game of another table's size likewise; where nothing can be written it is told, and played.
    struct stage s;
    char path[160];
    snprintf(path, sizeof path, "%s/strange.json.1/x.json", dir);
    open_stage(&s, "h3", "free", path);
    strike_ahead(&s, 2);
    close_stage(&s);
}

static void rack_that_does_not_fit(void **state) {
    (void)state;
    struct ap_scene *scene;
    struct ap_play_game *game = NULL;
    struct ap_error err = {""};
    const struct ap_scene_params params = {.space_name = "s3"};
    assert_int_equal(ap_scene_billiards(&err, &params, &scene), AP_OK);
    for (size_t i = 0; i < scene->part_count; i++)
        if (scene->parts[i].pool_ball)
            scene->parts[i].radius_m = 0.06;
    const struct ap_play_game_params p = {.scene = scene, .kind = "eight-ball"};
    enum ap_status st = ap_play_game_open(&err, &p, &game);
    if (st != AP_INPUT || !strstr(err.text, "fit"))
        fail_msg("status %d: %s", st, err.text);
    assert_null(game);
    ap_scene_destroy(scene);
}

static void board_says_it(void **state) {
    (void)state;
    struct stage s;
    struct ap_board_text text;
    open_stage(&s, "h3", "eight-ball", NULL);
    ap_board_write(game_of(&s), "", "", &text);
    assert_non_null(strstr(text.line[0], "player 1"));
    assert_non_null(strstr(text.line[2], "15 balls"));
    strike_ahead(&s, 5);
    ap_board_write(game_of(&s), "refused", "", &text);
    assert_non_null(strstr(text.line[1], "roll"));
    assert_string_equal(text.line[3], "refused");
    close_stage(&s);
    // Across from her, and it stays while that is nearly so.
    const struct ap_tracker_params room = {.table_height_m = 0.75, .table_yaw_rad = 0.3};
    int side = 0;
    for (int k = 0; k < 48; k++) {
        double a = 0.3 + k * 0.1309;
        struct ap_pose head = {{1.5 * sin(a), 1.6, 1.5 * cos(a)}, AP_QUAT_IDENTITY};
        side = ap_board_side(&room, head, side);
        struct ap_pose at = ap_board_pose(&room, 0.9, side);
        double away = (at.p.x * head.p.x + at.p.z * head.p.z) /
                      (hypot(at.p.x, at.p.z) * hypot(head.p.x, head.p.z));
        if (!(away < -0.45))
            fail_msg("head at %g: the board of side %d is not across (%g)", a, side, away);
        struct ap_vec3 face = ap_quat_rotate(at.q, (struct ap_vec3){0, 0, 1});
        check_near(face.x * at.p.x + face.z * at.p.z, -hypot(at.p.x, at.p.z), 1e-9);
    }
    assert_int_equal(side, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hands_strike),
        cmocka_unit_test(faults_while_striking),
        cmocka_unit_test(eyes_aim),
        cmocka_unit_test(path_is_gone),
        cmocka_unit_test(ball_in_hand),
        cmocka_unit_test(menu_racks_and_undoes),
        cmocka_unit_test(game_is_kept),
        cmocka_unit_test(strange_files_are_kept),
        cmocka_unit_test(rack_that_does_not_fit),
        cmocka_unit_test(board_says_it),
    };
    return cmocka_run_group_tests(tests, make_dir, remove_dir);
}
