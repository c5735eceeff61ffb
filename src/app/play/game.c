#include "src/app/play/game.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/log.h"
#include "src/base/number.h"
#include "src/geom/map.h"

// Hands whose cue is this near the ball are about to strike, and do not aim by the eyes.
static const double near_ball_m = 0.25;
static const double reach_m = 0.75, tip_radius_m = 0.0058;

// ---- Where it is kept

char *ap_play_game_path(const char *space, const char *kind) {
    const char *state = getenv("XDG_STATE_HOME"), *home = getenv("HOME");
    bool own = state && state[0] == '/';
    char name[128];
    snprintf(name, sizeof name, "%santipode/game-%s-%s.json", own ? "" : ".local/state/", space,
             kind);
    return own                      ? ap_path_join(state, name)
           : home && home[0] == '/' ? ap_path_join(home, name)
                                    : NULL;
}

static void keep(struct ap_play_game *g) {
    struct ap_error err;
    char *folder = g->path ? strdup(g->path) : NULL;
    if (!folder)
        return;
    *strrchr(folder, '/') = '\0';
    enum ap_status st = ap_make_dirs(&err, folder);
    if (!st)
        st = ap_game_save(&err, &g->table->game, g->path);
    free(folder);
    if (st)
        ap_log(AP_LOG_WARNING, "the game is not kept: %s", err.text);
    g->dirty = st != AP_OK;
}

// A file that this program cannot go on with is not written over.
static void set_aside(struct ap_play_game *g, const char *why) {
    size_t size = strlen(g->path) + 16;
    char *other = malloc(size);
    bool moved = false;
    for (int n = 1; other && !moved && n < 1000; n++) {
        snprintf(other, size, "%s.%d", g->path, n);
        if (!ap_file_exists(other)) {
            moved = rename(g->path, other) == 0;
            break;
        }
    }
    if (moved) {
        ap_log(AP_LOG_WARNING, "%s; it is kept as %s, and a new game begins", why, other);
    } else {
        ap_log(AP_LOG_WARNING, "%s; a new game begins and is not kept, as that file stays", why);
        free(g->path);
        g->path = NULL;
    }
    free(other);
}

static enum ap_status open_table(struct ap_error *err, const struct ap_play_game_params *p,
                                 struct ap_play_game *g) {
    struct ap_table_play_params how = {.kind = p->kind};
    if (g->path && !p->anew && ap_file_exists(g->path)) {
        struct ap_error why;
        how.saved_path = g->path;
        enum ap_status st = ap_table_play_open(&why, p->scene, &how, &g->table);
        if (st == AP_OK)
            ap_log(AP_LOG_INFO, "play: the game goes on that is kept in %s", g->path);
        if (st != AP_INPUT)
            return st ? ap_fail(err, st, "%s", why.text) : st;
        set_aside(g, why.text);
    }
    how.saved_path = NULL;
    return ap_table_play_open(err, p->scene, &how, &g->table);
}

static enum ap_status begin_recording(struct ap_error *err, const struct ap_play_game_params *p,
                                      struct ap_play_game *g) {
    enum ap_status st =
        ap_play_recorder_begin(err, p->record, &g->table->game, p->command, &g->recorder);
    char *start = st ? NULL : ap_path_join(p->record, "start.json");
    if (!st && !start)
        st = ap_fail(err, AP_ENVIRONMENT, "out of memory");
    if (!st)
        st = ap_game_load(err, start, &g->table->game);
    free(start);
    return st;
}

// ---- The cue that is drawn

static void find_cue(struct ap_play_game *g) {
    struct ap_scene *scene = g->table->scene;
    for (size_t i = 0; i < scene->part_count && g->cue_parts < AP_PLAY_CUE_PARTS; i++) {
        struct ap_part *part = &scene->parts[i];
        if (part->kind != AP_PART_STICK || part->carrier != AP_CARRIER_RIGHT)
            continue;
        g->cue_part[g->cue_parts] = i;
        g->grip_from_part[g->cue_parts++] = part->carrier_from_part;
        part->carrier = AP_CARRIER_WORLD;
    }
}

// NULL: there is none to see.
static void show_cue(struct ap_play_game *g, const struct ap_iso *world_from_tip) {
    struct ap_scene *scene = g->table->scene;
    struct ap_iso back = ap_iso_translate(scene->space, (struct ap_vec3){0, 0, reach_m});
    for (int i = 0; i < g->cue_parts; i++) {
        struct ap_part *part = &scene->parts[g->cue_part[i]];
        part->hidden = !world_from_tip;
        if (world_from_tip)
            part->carrier_from_part =
                ap_iso_mul(ap_iso_mul(*world_from_tip, back), g->grip_from_part[i]);
    }
}

// ---- Life

enum ap_status ap_play_game_open(struct ap_error *err, const struct ap_play_game_params *p,
                                 struct ap_play_game **out) {
    struct ap_play_game *g = calloc(1, sizeof *g);
    if (!g)
        return ap_fail(err, AP_ENVIRONMENT, "no memory for a game");
    const struct ap_cue_params cue = {.reach_m = reach_m, .tip_radius_m = tip_radius_m};
    ap_cue_init(&cue, &g->cue);
    g->aim = ap_play_aim_standard();
    g->path = p->path ? strdup(p->path) : NULL;
    enum ap_status st =
        p->path && !g->path ? ap_fail(err, AP_ENVIRONMENT, "no memory for a game") : AP_OK;
    if (!st)
        st = open_table(err, p, g);
    if (!st && p->record)
        st = begin_recording(err, p, g);
    if (!st)
        st = ap_play_lines_init(err, p->scene, &g->lines);
    if (!st)
        find_cue(g);
    if (st) {
        ap_play_game_close(g);
        return st;
    }
    *out = g;
    return AP_OK;
}

void ap_play_game_close(struct ap_play_game *g) {
    if (!g)
        return;
    struct ap_error err;
    if (g->table && g->dirty)
        keep(g);
    if (g->table && g->recorder.open &&
        ap_play_recorder_finish(&err, &g->recorder, &g->table->game))
        ap_log(AP_LOG_WARNING, "the recording is not kept: %s", err.text);
    ap_play_recorder_abort(&g->recorder);
    ap_table_play_close(g->table);
    free(g->path);
    free(g);
}

// ---- What is played

static double game_s(const struct ap_play_game *g) {
    return g->table->start_s + (double)g->clock_ns * 1e-9;
}

static void advance(struct ap_play_game *g, double until_s) {
    struct ap_game *game = &g->table->game;
    bool judged = false;
    while (ap_game_advance(game, fmax(until_s, game->physics.now_s), NULL, NULL))
        judged = true;
    g->dirty |= game->shooting;
    if (judged) {
        g->cue.count = 0;
        keep(g);
    }
}

// Everything that is done to the game is done by a line of a script, so that the recording's line
// does just that again.
static bool command(struct ap_play_game *g, const char *line) {
    struct ap_error why;
    if (ap_shot_command(&why, &g->table->game, line)) {
        snprintf(g->says, sizeof g->says, "%.*s", AP_PLAY_GAME_SAYS - 1, why.text);
        g->refused++;
        return false;
    }
    ap_play_recorder_line(&g->recorder, line);
    g->says[0] = '\0';
    keep(g);
    return true;
}

static bool strike(struct ap_play_game *g, const struct ap_strike *s) {
    char line[AP_SHOT_TEXT_MAX];
    const struct ap_physics *ph = &g->table->game.physics;
    ap_shot_text(ph, s, ph->now_s, line);
    bool done = command(g, line);
    double strength = fmin(fmax(0.15 + s->speed_m_s / 6, 0), 1);
    g->pulse[0] = done ? 0.4 * strength : 0;
    g->pulse[1] = done ? strength : 0.1;
    g->strikes += done;
    return done;
}

static void put_time(char *line, size_t size, const char *words, double time_s) {
    char t[AP_DOUBLE_TEXT_MAX];
    int n = (int)ap_format_double(t, time_s);
    snprintf(line, size, "%s time=%.*s", words, n, t);
}

static void place(struct ap_play_game *g) {
    struct ap_space space = g->table->scene->space;
    struct ap_plane3 p = g->aim.target_m;
    struct ap_vec3 v = ap_log_unchecked(space, (struct ap_vec4){p.x, 0, p.z, p.w}, 0);
    char x[AP_DOUBLE_TEXT_MAX], z[AP_DOUBLE_TEXT_MAX], words[128], line[192];
    int nx = (int)ap_format_double(x, v.x), nz = (int)ap_format_double(z, v.z);
    snprintf(words, sizeof words, "place x=%.*s z=%.*s", nx, x, nz, z);
    put_time(line, sizeof line, words, g->table->game.physics.now_s);
    command(g, line);
}

void ap_play_game_rack(struct ap_play_game *g) {
    char line[64];
    put_time(line, sizeof line, "rack", g->table->game.physics.now_s);
    command(g, line);
    ap_table_play_show(g->table);
}

void ap_play_game_undo(struct ap_play_game *g) {
    char line[64];
    put_time(line, sizeof line, "undo", g->table->game.physics.now_s);
    command(g, line);
    ap_table_play_show(g->table);
}

static bool cue_on_table(const struct ap_game *game) {
    return game->physics.ball[0].state != AP_BALL_POCKETED;
}

static bool may_strike(const struct ap_game *game) {
    return !game->shooting && game->rules.winner < 0 && cue_on_table(game);
}

// ---- By the eyes

static bool tip_is_near(const struct ap_play_game *g, const struct ap_cue_hands *hands) {
    const struct ap_game *game = &g->table->game;
    struct ap_space space = g->table->scene->space;
    struct ap_iso tip;
    if (!cue_on_table(game) || !ap_cue_pose(&g->cue, space, hands, &tip))
        return false;
    struct ap_iso back = ap_iso_inverse(space, ap_cue_ball(&game->physics, 0));
    struct ap_vec4 base = {0, 0, 0, space.rho_m};
    struct ap_vec4 at = ap_iso_apply(&tip, base);
    at = ap_iso_apply(&back, at);
    return ap_vec3_length(ap_log_unchecked(space, at, 0)) < near_ball_m;
}

// Pressed while the cue ball is off the table, either button puts it there.
static void take_aim(struct ap_play_game *g, const struct ap_xr_frame *frame,
                     const struct ap_frame_input *placed, const struct ap_cue_hands *hands,
                     double dt_s) {
    const struct ap_xr_hand *left = &frame->hand[0], *right = &frame->hand[1];
    bool held = right->squeeze > 0.5f && (g->aim.active || !tip_is_near(g, hands));
    const struct ap_play_aim_input in = {.dt_s = dt_s,
                                         .held = held,
                                         .trigger = right->trigger > 0.5f || right->select,
                                         .place = right->primary,
                                         .power = (double)right->stick_y,
                                         .tip_x = (double)left->stick_x,
                                         .tip_y = (double)left->stick_y,
                                         .world_from_head = &placed->viewer.world_from_nose};
    enum ap_aim_wish wish = ap_play_aim_step(&g->aim, g->table->scene->space, &in);
    if (wish == AP_AIM_NOTHING)
        return;
    advance(g, game_s(g));
    struct ap_strike s;
    bool on_table = cue_on_table(&g->table->game);
    if (wish == AP_AIM_PLACE || !on_table) {
        place(g);
    } else if (ap_play_aim_strike(&g->aim, &g->table->game.physics, 0, &s) && strike(g, &s)) {
        g->aim.right = g->aim.above = 0;
    }
}

// ---- By hand

static struct ap_cue_hands hands_of(const struct ap_xr_frame *frame,
                                    const struct ap_frame_input *placed) {
    return (struct ap_cue_hands){
        .left_tracked = frame->hand[0].grip.tracked && placed->hand_tracked[0],
        .right_tracked = frame->hand[1].grip.tracked && placed->hand_tracked[1],
        .world_from_left = placed->world_from_hand[0],
        .world_from_right = placed->world_from_hand[1]};
}

static void take_stroke(struct ap_play_game *g, int64_t t_ns, const struct ap_cue_hands *hands) {
    struct ap_game *game = &g->table->game;
    struct ap_cue_hit hit;
    if (!may_strike(game) || g->aim.active) {
        g->cue.count = 0;
        g->cue.armed = false;
        return;
    }
    struct ap_iso ball = ap_cue_ball(&game->physics, 0);
    enum ap_cue_touch touch = ap_cue_feed(&g->cue, g->table->scene->space, t_ns, hands, &ball,
                                          game->physics.params.ball_radius_m, &hit);
    if (touch == AP_CUE_NOTHING)
        return;
    if (touch == AP_CUE_MISCUE) {
        snprintf(g->says, sizeof g->says, "a miscue: the tip slips off the ball's side");
        g->pulse[1] = 0.3;
        g->refused++;
        return;
    }
    advance(g, game_s(g) - (double)(t_ns - hit.t_ns) * 1e-9);
    struct ap_strike s = ap_cue_strike(&game->physics, 0, &hit);
    strike(g, &s);
}

// What the cue in the hands would do if it went on along its line from where it is.
static bool hands_aim(const struct ap_play_game *g, struct ap_strike *s) {
    const struct ap_game *game = &g->table->game;
    if (!may_strike(game) || g->cue.count == 0)
        return false;
    struct ap_vec3 tip = g->cue.sample[g->cue.count - 1].tip_m;
    struct ap_vec3 axis = g->cue.sample[g->cue.count - 1].axis;
    double before_m = -ap_vec3_dot(tip, axis);
    if (!(before_m > 0) || before_m > 2 * near_ball_m)
        return false;
    double scale = 1 / (game->physics.params.ball_radius_m + tip_radius_m);
    struct ap_vec3 right = ap_vec3_normalize(ap_vec3_cross(axis, (struct ap_vec3){0, 1, 0}));
    struct ap_vec3 above = ap_vec3_cross(right, axis);
    const struct ap_cue_hit hit = {.axis = axis,
                                   .speed_m_s = g->aim.speed_m_s,
                                   .right = scale * ap_vec3_dot(tip, right),
                                   .above = scale * ap_vec3_dot(tip, above)};
    *s = ap_cue_strike(&game->physics, 0, &hit);
    return hypot(hit.right, hit.above) < 0.55;
}

static void show(struct ap_play_game *g, const struct ap_cue_hands *hands) {
    const struct ap_game *game = &g->table->game;
    struct ap_strike s;
    struct ap_iso tip;
    ap_table_play_show(g->table);
    bool aimed =
        g->aim.active && may_strike(game) && ap_play_aim_strike(&g->aim, &game->physics, 0, &s);
    if (aimed)
        tip = ap_play_aim_cue(&g->aim, &game->physics, 0, &s, tip_radius_m);
    bool held = !aimed && ap_cue_pose(&g->cue, g->table->scene->space, hands, &tip);
    show_cue(g, aimed || held ? &tip : NULL);
    bool known = aimed || (held && !g->aim.active && hands_aim(g, &s));
    ap_play_lines_show(&g->lines, &game->physics, g->shows_lines && known ? &s : NULL);
    ap_play_lines_mark(&g->lines, g->aim.active && g->aim.has_target ? &g->aim.target_m : NULL);
}

void ap_play_game_step(struct ap_play_game *g, const struct ap_xr_frame *frame,
                       const struct ap_frame_input *placed, bool still) {
    if (!g->begun && !frame->head.tracked)
        return;
    int64_t dt_ns = g->begun ? frame->time_ns - g->last_ns : 0;
    if (dt_ns < 0)
        dt_ns = 0;
    g->pulse[0] = g->pulse[1] = 0;
    g->begun = true;
    g->last_ns = frame->time_ns;
    struct ap_cue_hands hands = hands_of(frame, placed);
    if (still) {
        // What is pressed for the menu is not pressed for the cue.
        g->cue.count = 0;
        g->aim.active = g->aim.has_target = false;
        g->aim.was_trigger = g->aim.was_place = true;
        show(g, &hands);
        return;
    }
    g->clock_ns += dt_ns;
    ap_play_recorder_frame(&g->recorder, g->clock_ns, frame);
    take_aim(g, frame, placed, &hands, (double)dt_ns * 1e-9);
    take_stroke(g, frame->time_ns, &hands);
    advance(g, game_s(g));
    show(g, &hands);
}

bool ap_play_game_aims(const struct ap_play_game *g) {
    return g->aim.active;
}
