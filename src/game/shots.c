#include "src/game/shots.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/file.h"
#include "src/base/number.h"

enum { SCRIPT_MAX_BYTES = 4 << 20, LINES_MAX = 100000 };

struct word {
    const char *text;
    size_t len;
};

static bool next_word(const char **at, const char *end, struct word *w) {
    while (*at < end && (**at == ' ' || **at == '\t' || **at == '\r'))
        ++*at;
    const char *begin = *at;
    while (*at < end && **at != ' ' && **at != '\t' && **at != '\r')
        ++*at;
    *w = (struct word){begin, (size_t)(*at - begin)};
    return w->len > 0;
}

static bool word_is(struct word w, const char *text) {
    return w.len == strlen(text) && memcmp(w.text, text, w.len) == 0;
}

static int shown(struct word w) {
    return w.len > 40 ? 40 : (int)w.len;
}

struct key {
    const char *name;
    size_t at;
    bool whole; // an int, 0…15
};
#define KEY(name, field)                                                                           \
    { name, offsetof(struct ap_shot_line, field), false }
#define WHOLE(name, field)                                                                         \
    { name, offsetof(struct ap_shot_line, field), true }

static const struct key shot_keys[] = {WHOLE("at", ball),
                                       KEY("angle", angle_rad),
                                       KEY("turn", turn_rad),
                                       KEY("speed", speed_m_s),
                                       KEY("right", right),
                                       KEY("above", above),
                                       KEY("elevation", elevation_rad),
                                       KEY("time", time_s),
                                       {NULL, 0, false}};
static const struct key place_keys[] = {
    KEY("x", x_m), KEY("z", z_m), KEY("time", time_s), {NULL, 0, false}};
static const struct key time_keys[] = {KEY("time", time_s), {NULL, 0, false}};
static const struct key ball_keys[] = {
    WHOLE("n", ball), KEY("x", x_m), KEY("z", z_m), {NULL, 0, false}};
static const struct key clear_keys[] = {{NULL, 0, false}};

static const struct command {
    const char *name;
    enum ap_shot_line_kind kind;
    const struct key *keys;
} commands[] = {{"shot", AP_LINE_SHOT, shot_keys},  {"place", AP_LINE_PLACE, place_keys},
                {"undo", AP_LINE_UNDO, time_keys},  {"rack", AP_LINE_RACK, time_keys},
                {"end", AP_LINE_FINISH, time_keys}, {"clear", AP_LINE_CLEAR, clear_keys},
                {"ball", AP_LINE_BALL, ball_keys}};

#define CONSTANT(name)                                                                             \
    { #name, offsetof(struct ap_physics_params, name), false }
static const struct key constants[] = {
    CONSTANT(ball_radius_m),    CONSTANT(ball_mass_kg),    CONSTANT(gravity_m_s2),
    CONSTANT(slide_friction),   CONSTANT(roll_friction),   CONSTANT(spin_friction),
    CONSTANT(ball_restitution), CONSTANT(ball_friction),   CONSTANT(cushion_restitution),
    CONSTANT(cushion_friction), CONSTANT(cushion_m),       CONSTANT(pocket_radius_m),
    CONSTANT(cue_mass_kg),      CONSTANT(tip_restitution), {NULL, 0, false}};

// KEY=VALUE into a field of *target that the table allows.
static enum ap_status take_pair(struct ap_error *err, struct word w, const struct key *keys,
                                void *target) {
    const char *eq = memchr(w.text, '=', w.len);
    double value;
    if (!eq)
        return ap_fail(err, AP_INPUT, "expected KEY=VALUE, not '%.*s'", shown(w), w.text);
    struct word name = {w.text, (size_t)(eq - w.text)};
    const struct key *k = keys;
    while (k->name && !word_is(name, k->name))
        k++;
    if (!k->name)
        return ap_fail(err, AP_INPUT, "'%.*s' is not known here", shown(name), name.text);
    if (!ap_parse_double(eq + 1, w.len - name.len - 1, &value))
        return ap_fail(err, AP_INPUT, "%s: expected a finite number, not '%.*s'", k->name,
                       (int)(w.len - name.len - 1), eq + 1);
    if (k->whole) {
        if (value != (int)fmin(fmax(value, -1), 99) || value < 0 || value >= AP_BALLS_MAX)
            return ap_fail(err, AP_INPUT, "%s: expected a ball's number, 0 to %d", k->name,
                           AP_BALLS_MAX - 1);
        *(int *)((char *)target + k->at) = (int)value;
    } else {
        // Of the constants 0 would mean the default; whoever writes 0 means 0.
        *(double *)((char *)target + k->at) = keys == constants && value == 0 ? -1 : value;
    }
    return AP_OK;
}

static enum ap_status check_line(struct ap_error *err, const struct ap_shot_line *l) {
    if (l->kind == AP_LINE_SHOT && (l->ball < 0) == (isnan(l->angle_rad) != 0))
        return ap_fail(err, AP_INPUT, "a shot is aimed by at=BALL or by angle=RADIANS");
    if (l->kind == AP_LINE_SHOT && isnan(l->speed_m_s))
        return ap_fail(err, AP_INPUT, "a shot needs speed=METRES_PER_SECOND");
    if (isnan(l->x_m) != isnan(l->z_m) ||
        (l->kind == AP_LINE_BALL && (l->ball < 0 || isnan(l->x_m))))
        return ap_fail(err, AP_INPUT, "expected x=METRES and z=METRES%s",
                       l->kind == AP_LINE_BALL ? " and n=BALL" : "");
    if (l->kind == AP_LINE_FINISH && isnan(l->time_s))
        return ap_fail(err, AP_INPUT, "end needs time=SECONDS");
    return AP_OK;
}

static enum ap_status parse_set(struct ap_error *err, struct ap_shots *s, const char *at,
                                const char *end) {
    struct word w;
    if (s->count > 0)
        return ap_fail(err, AP_INPUT, "set: the constants stand before everything else");
    while (next_word(&at, end, &w)) {
        enum ap_status st = take_pair(err, w, constants, &s->physics);
        if (st)
            return st;
    }
    return AP_OK;
}

// One line without its newline and comment.
static enum ap_status parse_line(struct ap_error *err, struct ap_shots *s, int number,
                                 const char *at, const char *end) {
    struct word w;
    if (!next_word(&at, end, &w))
        return AP_OK;
    if (word_is(w, "set"))
        return parse_set(err, s, at, end);
    const struct command *c = NULL;
    for (size_t i = 0; i < sizeof commands / sizeof *commands; i++)
        if (word_is(w, commands[i].name))
            c = &commands[i];
    if (!c)
        return ap_fail(err, AP_INPUT,
                       "no command '%.*s': use shot, place, undo, rack, end, set, clear or ball",
                       shown(w), w.text);
    struct ap_shot_line line = {.kind = c->kind,
                                .number = number,
                                .ball = -1,
                                .angle_rad = NAN,
                                .speed_m_s = NAN,
                                .x_m = NAN,
                                .z_m = NAN,
                                .time_s = NAN};
    while (next_word(&at, end, &w)) {
        enum ap_status st = take_pair(err, w, c->keys, &line);
        if (st)
            return st;
    }
    enum ap_status st = check_line(err, &line);
    if (!st)
        s->line[s->count++] = line;
    return st;
}

static size_t count_lines(const char *text, size_t len) {
    size_t n = 1;
    for (size_t i = 0; i < len; i++)
        n += text[i] == '\n';
    return n;
}

enum ap_status ap_shots_parse(struct ap_error *err, const char *path, const char *text, size_t len,
                              struct ap_shots **shots) {
    size_t lines = count_lines(text, len);
    if (lines > LINES_MAX)
        return ap_fail(err, AP_INPUT, "%s: more than %d lines", path, LINES_MAX);
    struct ap_shots *s = calloc(1, sizeof *s);
    if (s) {
        s->line = calloc(lines, sizeof *s->line);
        s->path = strdup(path);
    }
    enum ap_status st = s && s->line && s->path ? AP_OK : ap_fail(err, AP_ENVIRONMENT, "no memory");
    const char *at = text, *end = text + len;
    for (int number = 1; !st && at < end; number++) {
        const char *stop = memchr(at, '\n', (size_t)(end - at));
        stop = stop ? stop : end;
        const char *hash = memchr(at, '#', (size_t)(stop - at));
        struct ap_error why = {""};
        st = parse_line(&why, s, number, at, hash ? hash : stop);
        if (st)
            ap_fail(err, st, "%s:%d: %s", path, number, why.text);
        at = stop + 1;
    }
    if (st)
        ap_shots_destroy(s);
    else
        *shots = s;
    return st;
}

enum ap_status ap_shots_read(struct ap_error *err, const char *path, struct ap_shots **shots) {
    char *text;
    size_t len;
    enum ap_status st = ap_file_read(err, path, SCRIPT_MAX_BYTES, &text, &len);
    if (st)
        return st;
    st = ap_shots_parse(err, path, text, len, shots);
    free(text);
    return st;
}

void ap_shots_destroy(struct ap_shots *s) {
    if (!s)
        return;
    free(s->line);
    free(s->path);
    free(s);
}

static struct ap_plane3 direction_of(const struct ap_physics *ph, const struct ap_shot_line *l) {
    if (l->ball < 0)
        return ap_physics_heading(ph, 0, l->angle_rad + l->turn_rad);
    // Turned against its own heading: the angle it has is its own against the one of angle 0.
    struct ap_plane3 d = ap_physics_toward(ph, 0, l->ball);
    struct ap_plane3 z = ap_physics_heading(ph, 0, 0), x = ap_physics_heading(ph, 0, -M_PI / 2);
    int kappa = ph->shape.space.kappa;
    double angle = atan2(-ap_plane_dot(kappa, d, x), ap_plane_dot(kappa, d, z));
    return l->turn_rad == 0 ? d : ap_physics_heading(ph, 0, angle + l->turn_rad);
}

void ap_shot_text(const struct ap_physics *ph, const struct ap_strike *s, double time_s,
                  char text[AP_SHOT_TEXT_MAX]) {
    struct ap_plane3 z = ap_physics_heading(ph, 0, 0), x = ap_physics_heading(ph, 0, -M_PI / 2);
    int kappa = ph->shape.space.kappa;
    const double value[] = {
        atan2(-ap_plane_dot(kappa, s->direction, x), ap_plane_dot(kappa, s->direction, z)),
        s->speed_m_s,
        s->right,
        s->above,
        s->elevation_rad,
        time_s};
    static const char *const name[] = {"angle", "speed", "right", "above", "elevation", "time"};
    size_t n = (size_t)snprintf(text, AP_SHOT_TEXT_MAX, "shot");
    for (size_t i = 0; i < sizeof value / sizeof *value; i++) {
        char number[AP_DOUBLE_TEXT_MAX];
        size_t len = ap_format_double(number, value[i]);
        if (!isnan(value[i]))
            n += (size_t)snprintf(text + n, AP_SHOT_TEXT_MAX - n, " %s=%.*s", name[i], (int)len,
                                  number);
    }
}

static enum ap_status play_shot(struct ap_error *err, struct ap_game *g,
                                const struct ap_shot_line *l) {
    if (l->ball == 0 || l->ball >= g->physics.ball_count ||
        (l->ball > 0 && g->physics.ball[l->ball].state == AP_BALL_POCKETED))
        return ap_fail(err, AP_INPUT, "ball %d is not there to be aimed at", l->ball);
    if (g->physics.ball[0].state == AP_BALL_POCKETED)
        return ap_fail(err, AP_INPUT, "the cue ball is in hand: place it first");
    struct ap_strike s = {.direction = direction_of(&g->physics, l),
                          .speed_m_s = l->speed_m_s,
                          .right = l->right,
                          .above = l->above,
                          .elevation_rad = l->elevation_rad};
    return ap_game_strike(err, g, &s);
}

static enum ap_status play_ball(struct ap_error *err, struct ap_game *g,
                                const struct ap_shot_line *l) {
    if (g->rules.kind != AP_GAME_FREE)
        return ap_fail(err, AP_INPUT, "only in free play can the balls be set");
    if (l->kind == AP_LINE_BALL)
        return ap_physics_place(err, &g->physics, l->ball, (struct ap_plane2){l->x_m, l->z_m});
    for (int i = 0; i < g->physics.ball_count; i++)
        ap_physics_remove(&g->physics, i);
    return AP_OK;
}

static enum ap_status play_line(struct ap_error *err, struct ap_game *g,
                                const struct ap_shot_line *l) {
    switch (l->kind) {
    case AP_LINE_SHOT:
        return play_shot(err, g, l);
    case AP_LINE_PLACE:
        // Without a place it is "if need be".
        if (isnan(l->x_m) && !g->rules.in_hand)
            return AP_OK;
        return isnan(l->x_m) ? ap_game_place_anywhere(err, g)
                             : ap_game_place(err, g, (struct ap_plane2){l->x_m, l->z_m});
    case AP_LINE_UNDO:
        return ap_game_undo(err, g);
    case AP_LINE_RACK:
        return ap_game_rack(err, g);
    case AP_LINE_FINISH:
        return AP_OK;
    case AP_LINE_CLEAR:
    case AP_LINE_BALL:
        return play_ball(err, g, l);
    }
    return AP_OK;
}

enum ap_status ap_shot_command(struct ap_error *err, struct ap_game *g, const char *text) {
    struct ap_shots *shots;
    enum ap_status st = ap_shots_parse(err, "command", text, strlen(text), &shots);
    if (st)
        return st;
    for (size_t i = 0; i < shots->count && !st; i++)
        st = play_line(err, g, &shots->line[i]);
    ap_shots_destroy(shots);
    return st;
}

double ap_shots_end_s(const struct ap_shots *s) {
    for (size_t i = 0; i < s->count; i++)
        if (s->line[i].kind == AP_LINE_FINISH)
            return s->line[i].time_s;
    return INFINITY;
}

// Lines that a person may ask for at any moment.
static bool interrupts(const struct ap_shot_line *l) {
    return !isnan(l->time_s) &&
           (l->kind == AP_LINE_UNDO || l->kind == AP_LINE_RACK || l->kind == AP_LINE_FINISH);
}

// When a line is due: at its time or as soon as may be, after the balls' rest.
static double due_of(const struct ap_shot_player *p, const struct ap_game *g,
                     const struct ap_shot_line *l) {
    if (interrupts(l))
        return fmax(l->time_s, g->physics.now_s);
    if (!isnan(l->time_s))
        return fmax(l->time_s, g->physics.changed_s);
    bool paused = l->kind == AP_LINE_SHOT || l->kind == AP_LINE_UNDO || l->kind == AP_LINE_RACK;
    return g->physics.changed_s + (paused ? p->pause_s : 0);
}

enum ap_status ap_shot_player_run(struct ap_error *err, struct ap_shot_player *p, struct ap_game *g,
                                  double until_s, const struct ap_shot_watch *watch) {
    static const struct ap_shot_watch nobody;
    watch = watch ? watch : &nobody;
    for (;;) {
        const struct ap_shot_line *l = p->next < p->shots->count ? &p->shots->line[p->next] : NULL;
        if (l && l->kind == AP_LINE_FINISH)
            until_s = fmin(until_s, l->time_s);
        bool cuts = l && interrupts(l) && l->time_s <= until_s;
        double run_s = cuts ? fmax(l->time_s, g->physics.now_s) : until_s;
        if (ap_game_advance(g, g->shooting ? run_s : g->physics.now_s, watch->event, watch->data)) {
            if (watch->judged)
                watch->judged(watch->data);
        }
        if (g->shooting && !cuts)
            return AP_OK;
        double due_s = l ? due_of(p, g, l) : INFINITY;
        if (!l || l->kind == AP_LINE_FINISH || !(due_s <= until_s)) {
            ap_game_advance(g, fmax(until_s, g->physics.now_s), watch->event, watch->data);
            return AP_OK;
        }
        ap_game_advance(g, fmax(due_s, g->physics.now_s), watch->event, watch->data);
        struct ap_error why = {""};
        enum ap_status st = play_line(&why, g, l);
        if (st)
            return ap_fail(err, st, "%s:%d: %s", p->shots->path, l->number, why.text);
        p->next++;
        if (watch->line)
            watch->line(watch->data, l);
    }
}

bool ap_shot_player_done(const struct ap_shot_player *p, const struct ap_game *g) {
    if (p->next < p->shots->count && p->shots->line[p->next].kind == AP_LINE_FINISH)
        return g->physics.now_s >= p->shots->line[p->next].time_s;
    return p->next >= p->shots->count && !g->shooting;
}
