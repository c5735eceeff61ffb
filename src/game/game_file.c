#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/file.h"
#include "src/base/json.h"
#include "src/game/game.h"
#include "src/game/queue.h"
#include "src/game/segment.h"

// A saved game: one JSON object, "antipode_game" first, which is the version.
enum { VERSION = 1 };

// The constants of the physics by their names in the file.
struct constant {
    const char *name;
    size_t at;
};
#define CONSTANT(name)                                                                             \
    { #name, offsetof(struct ap_physics_params, name) }
static const struct constant constants[] = {
    CONSTANT(ball_radius_m),    CONSTANT(ball_mass_kg),    CONSTANT(gravity_m_s2),
    CONSTANT(slide_friction),   CONSTANT(roll_friction),   CONSTANT(spin_friction),
    CONSTANT(ball_restitution), CONSTANT(ball_friction),   CONSTANT(cushion_restitution),
    CONSTANT(cushion_friction), CONSTANT(cushion_m),       CONSTANT(pocket_radius_m),
    CONSTANT(cue_mass_kg),      CONSTANT(tip_restitution),
};
enum { CONSTANTS = sizeof constants / sizeof *constants };

static json_t *numbers(const double *v, size_t n) {
    json_t *list = json_array();
    for (size_t i = 0; i < n; i++)
        json_array_append_new(list, json_real(v[i]));
    return list;
}

static json_t *constants_json(const struct ap_physics_params *p) {
    json_t *o = json_object();
    for (int i = 0; i < CONSTANTS; i++)
        json_object_set_new(o, constants[i].name,
                            json_real(*(const double *)((const char *)p + constants[i].at)));
    json_object_set_new(o, "no_pockets", json_boolean(p->no_pockets));
    json_object_set_new(o, "side_pockets", json_boolean(p->side_pockets));
    json_object_set_new(o, "no_cushions", json_boolean(p->no_cushions));
    return o;
}

static json_t *ball_json(const struct ap_physics *ph, int i) {
    struct ap_ball b = ph->ball[i];
    ap_segment_commit(ph, &b, fmin(fmax(ph->now_s, b.t0_s), b.t_end_s));
    json_t *o = json_object();
    json_object_set_new(o, "on_table", json_boolean(b.state != AP_BALL_POCKETED));
    json_object_set_new(o, "pocket", json_integer(b.pocket));
    const double v[2] = {b.velocity_m_s.x, b.velocity_m_s.z};
    const double w[3] = {b.turn_rad_s.x, b.turn_rad_s.y, b.turn_rad_s.z};
    const double q[4] = {b.foot_from_ball.x, b.foot_from_ball.y, b.foot_from_ball.z,
                         b.foot_from_ball.w};
    json_object_set_new(o, "world_from_foot", numbers(&b.world_from_foot.m[0][0], 9));
    json_object_set_new(o, "velocity_m_s", numbers(v, 2));
    json_object_set_new(o, "turn_rad_s", numbers(w, 3));
    json_object_set_new(o, "foot_from_ball", numbers(q, 4));
    return o;
}

static json_t *rules_json(const struct ap_rules *r) {
    return json_pack("{s:s,s:i,s:i,s:[i,i],s:[i,i],s:i,s:b}", "game", ap_game_kind_name(r->kind),
                     "phase", r->phase, "turn", r->turn, "groups", r->group[0], r->group[1],
                     "fouls", r->fouls[0], r->fouls[1], "winner", r->winner, "in_hand", r->in_hand);
}

static json_t *facts_json(const struct ap_shot_facts *f) {
    return json_pack("{s:i,s:i,s:i,s:i,s:b,s:i}", "on_table", (int)f->on_table, "pocketed",
                     (int)f->pocketed, "first_hit", f->first_hit, "first_pocketed",
                     f->first_pocketed, "cushion_after", f->cushion_after, "to_cushion",
                     (int)f->to_cushion);
}

static json_t *game_json(const struct ap_game *g) {
    const struct ap_physics *ph = &g->physics;
    json_t *root = json_pack("{s:i}", "antipode_game", VERSION), *balls = json_array();
    json_object_set_new(root, "table",
                        json_pack("{s:s,s:f,s:f}", "geometry", ap_space_name(ph->shape.space),
                                  "edge_m", ph->shape.edge_m, "radius_m", ph->shape.space.rho_m));
    json_object_set_new(root, "physics", constants_json(&ph->params));
    json_object_set_new(root, "rules", rules_json(&g->rules));
    json_object_set_new(root, "shots", json_integer(g->shots));
    json_object_set_new(root, "time_s", json_real(ph->now_s));
    json_object_set_new(root, "shot", g->shooting ? facts_json(&g->facts) : json_null());
    for (int i = 0; i < ph->ball_count; i++)
        json_array_append_new(balls, ball_json(ph, i));
    json_object_set_new(root, "balls", balls);
    return root;
}

enum ap_status ap_game_save(struct ap_error *err, const struct ap_game *game, const char *path) {
    json_t *root = game_json(game);
    char *text = json_dumps(root, JSON_INDENT(1) | JSON_REAL_PRECISION(17));
    json_decref(root);
    if (!text)
        return ap_fail(err, AP_ENVIRONMENT, "no memory to save the game");
    enum ap_status st = ap_file_write(err, path, text, strlen(text));
    free(text);
    return st;
}

static enum ap_status read_integer(struct ap_error *err, const struct ap_json_at *at,
                                   const char *key, int least, int most, int *value) {
    double v;
    enum ap_status st = ap_json_number(err, at, key, &v);
    if (st)
        return st;
    struct ap_json_at member = ap_json_member(at, key);
    if (!(v >= least && v <= most) || v != floor(v))
        return ap_json_fail(err, &member, "expected a whole number from %d to %d", least, most);
    *value = (int)v;
    return AP_OK;
}

static enum ap_status read_pair(struct ap_error *err, const struct ap_json_at *at, const char *key,
                                int most, int value[2]) {
    double v[2];
    enum ap_status st = ap_json_numbers(err, at, key, 2, v);
    if (st)
        return st;
    struct ap_json_at member = ap_json_member(at, key);
    for (int i = 0; i < 2; i++) {
        if (!(v[i] >= 0 && v[i] <= most) || v[i] != floor(v[i]))
            return ap_json_fail(err, &member, "expected whole numbers from 0 to %d", most);
        value[i] = (int)v[i];
    }
    return AP_OK;
}

static enum ap_status read_rules(struct ap_error *err, const struct ap_json_at *root, int sides,
                                 struct ap_rules *r) {
    static const char *const keys[] = {"game",  "phase",  "turn",    "groups",
                                       "fouls", "winner", "in_hand", NULL};
    struct ap_json_at at = ap_json_member(root, "rules");
    const char *name = NULL;
    enum ap_game_kind kind = AP_GAME_FREE;
    int phase = 0, groups[2] = {0, 0};
    enum ap_status st = ap_json_check_keys(err, &at, keys);
    if (!st)
        st = ap_json_string(err, &at, "game", &name);
    if (!st && ap_game_kind_from_name(NULL, name, &kind)) {
        struct ap_json_at member = ap_json_member(&at, "game");
        return ap_json_fail(err, &member, "no game '%s'", name);
    }
    *r = ap_rules_start(kind, sides);
    if (!st)
        st = read_integer(err, &at, "phase", 0, AP_PHASE_GROUPS, &phase);
    if (!st)
        st = read_integer(err, &at, "turn", 0, 1, &r->turn);
    if (!st)
        st = read_pair(err, &at, "groups", AP_GROUP_STRIPES, groups);
    if (!st)
        st = read_pair(err, &at, "fouls", 1000000, r->fouls);
    if (!st)
        st = read_integer(err, &at, "winner", -1, 1, &r->winner);
    if (!st)
        st = ap_json_bool(err, &at, "in_hand", &r->in_hand);
    if (st)
        return st;
    bool chosen = groups[0] && groups[1] && groups[0] != groups[1];
    if ((phase == AP_PHASE_GROUPS) != (kind == AP_GAME_EIGHT && chosen)) {
        struct ap_json_at member = ap_json_member(&at, "groups");
        return ap_json_fail(err, &member, "phase %d and these groups do not go together", phase);
    }
    r->phase = (enum ap_game_phase)phase;
    for (int i = 0; i < 2; i++)
        r->group[i] = (enum ap_game_group)groups[i];
    return AP_OK;
}

static enum ap_status read_physics(struct ap_error *err, const struct ap_json_at *root,
                                   struct ap_physics *ph) {
    struct ap_json_at table = ap_json_member(root, "table"), at = ap_json_member(root, "physics");
    const char *keys[CONSTANTS + 4] = {"no_pockets", "side_pockets", "no_cushions"};
    static const char *const table_keys[] = {"geometry", "edge_m", "radius_m", NULL};
    const char *name = NULL;
    double edge_m = 0, rho_m = 0;
    struct ap_space space = {0, 1};
    struct ap_physics_params p = {0};
    for (int i = 0; i < CONSTANTS; i++)
        keys[3 + i] = constants[i].name;
    enum ap_status st = ap_json_check_keys(err, &table, table_keys);
    if (!st)
        st = ap_json_check_keys(err, &at, keys);
    if (!st)
        st = ap_json_string(err, &table, "geometry", &name);
    if (!st)
        st = ap_json_number(err, &table, "edge_m", &edge_m);
    if (!st)
        st = ap_json_number(err, &table, "radius_m", &rho_m);
    for (int i = 0; i < CONSTANTS && !st; i++) {
        double *value = (double *)((char *)&p + constants[i].at);
        st = ap_json_number(err, &at, constants[i].name, value);
        // 0 is a value here, and not "the default".
        *value = *value == 0 ? -1 : *value;
    }
    if (!st)
        st = ap_json_bool(err, &at, "no_pockets", &p.no_pockets);
    if (!st)
        st = ap_json_bool(err, &at, "side_pockets", &p.side_pockets);
    if (!st)
        st = ap_json_bool(err, &at, "no_cushions", &p.no_cushions);
    if (st)
        return st;
    struct ap_error why = {""};
    if (ap_space_from_name(&why, name, rho_m, &space))
        return ap_json_fail(err, &table, "%s", why.text);
    if (!(edge_m > 0) || edge_m > 100)
        return ap_json_fail(err, &table, "an edge of %g m: expected above 0, at most 100", edge_m);
    struct ap_table_shape shape = ap_table_from_edge(space.kappa, edge_m, rho_m);
    if (!(fabs(shape.space.rho_m - rho_m) <= 1e-9 * rho_m))
        return ap_json_fail(err, &table,
                            "an edge of %g m and a radius of %g m contradict each other", edge_m,
                            rho_m);
    if (ap_physics_init(&why, &shape, &p, ph))
        return ap_json_fail(err, &at, "%s", why.text);
    return AP_OK;
}

static enum ap_status check_ball(struct ap_error *err, const struct ap_json_at *at,
                                 const struct ap_physics *ph, struct ap_plane_frame *f,
                                 const double *v, const double *w, struct ap_quat q) {
    struct ap_iso lifted = ap_plane_lift(f);
    double size = sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    if (!(ap_iso_defect(ph->shape.space, &lifted) < 1e-9) || f->m[2][2] > 10)
        return ap_json_fail(err, at, "world_from_foot is no isometry of the table's plane");
    if (!(fabs(size - 1) < 1e-9))
        return ap_json_fail(err, at, "foot_from_ball is not a unit quaternion");
    if (!(fabs(v[0]) + fabs(v[1]) < 100) || !(fabs(w[0]) + fabs(w[1]) + fabs(w[2]) < 1e5))
        return ap_json_fail(err, at, "no ball moves as fast as this one");
    struct ap_plane3 p = ap_plane_foot(f, ph->shape.space.rho_m);
    for (int k = 0; k < ph->edge_count; k++) {
        const struct ap_plane3 *e = &ph->edge[k];
        if (!(e->x * p.x + e->z * p.z + e->w * p.w > ph->edge_height_m - 1e-9))
            return ap_json_fail(err, at, "the ball is not on the table");
    }
    for (int k = 0; k < ph->ball_count; k++)
        if (ph->ball[k].state != AP_BALL_POCKETED &&
            ap_plane_chord2(ph->shape.space.kappa, p,
                            ap_plane_foot(&ph->ball[k].world_from_foot, ph->shape.space.rho_m)) <
                ph->touch_m2 * (1 - 1e-9))
            return ap_json_fail(err, at, "the ball overlaps ball %d", k);
    return AP_OK;
}

static enum ap_status read_ball(struct ap_error *err, const struct ap_json_at *at,
                                struct ap_physics *ph, int ball) {
    static const char *const keys[] = {
        "on_table",       "pocket", "world_from_foot", "velocity_m_s", "turn_rad_s",
        "foot_from_ball", NULL};
    bool on_table = false;
    int pocket = -1;
    double f[9], v[2], w[3], q[4];
    enum ap_status st = ap_json_check_keys(err, at, keys);
    if (!st)
        st = ap_json_bool(err, at, "on_table", &on_table);
    if (!st)
        st = read_integer(err, at, "pocket", -1, AP_POCKETS_MAX - 1, &pocket);
    if (!st)
        st = ap_json_numbers(err, at, "world_from_foot", 9, f);
    if (!st)
        st = ap_json_numbers(err, at, "velocity_m_s", 2, v);
    if (!st)
        st = ap_json_numbers(err, at, "turn_rad_s", 3, w);
    if (!st)
        st = ap_json_numbers(err, at, "foot_from_ball", 4, q);
    if (st)
        return st;
    struct ap_plane_frame frame;
    memcpy(frame.m, f, sizeof f);
    struct ap_quat turn = {q[0], q[1], q[2], q[3]};
    ap_physics_set(ph, ball, &AP_PLANE_FRAME_IDENTITY, (struct ap_plane2){0, 0},
                   (struct ap_vec3){0, 0, 0}, AP_QUAT_IDENTITY);
    ap_physics_remove(ph, ball);
    ph->ball[ball].pocket = pocket;
    if (!on_table)
        return AP_OK;
    st = check_ball(err, at, ph, &frame, v, w, turn);
    if (!st)
        ap_physics_set(ph, ball, &frame, (struct ap_plane2){v[0], v[1]},
                       (struct ap_vec3){w[0], w[1], w[2]}, turn);
    return st;
}

static enum ap_status read_balls(struct ap_error *err, const struct ap_json_at *root,
                                 struct ap_physics *ph) {
    struct ap_json_at list = ap_json_member(root, "balls");
    size_t n = json_is_array(list.value) ? json_array_size(list.value) : 0;
    if (n < 2 || n > AP_BALLS_MAX)
        return ap_json_fail(err, &list, "expected a list of 2 to %d balls", AP_BALLS_MAX);
    for (size_t i = 0; i < n; i++) {
        struct ap_json_at at = ap_json_element(&list, i);
        enum ap_status st = read_ball(err, &at, ph, (int)i);
        if (st)
            return st;
    }
    return AP_OK;
}

static enum ap_status read_facts(struct ap_error *err, const struct ap_json_at *root,
                                 struct ap_game *g) {
    static const char *const keys[] = {"on_table",      "pocketed",   "first_hit", "first_pocketed",
                                       "cushion_after", "to_cushion", NULL};
    struct ap_json_at at = ap_json_member(root, "shot");
    if (json_is_null(at.value))
        return ap_physics_at_rest(&g->physics)
                   ? AP_OK
                   : ap_json_fail(err, &at, "balls move, but no shot is on its way");
    int on_table = 0, pocketed = 0, to_cushion = 0;
    enum ap_status st = ap_json_check_keys(err, &at, keys);
    if (!st)
        st = read_integer(err, &at, "on_table", 0, 0xffff, &on_table);
    if (!st)
        st = read_integer(err, &at, "pocketed", 0, 0xffff, &pocketed);
    if (!st)
        st = read_integer(err, &at, "to_cushion", 0, 0xffff, &to_cushion);
    if (!st)
        st = read_integer(err, &at, "first_hit", -1, 15, &g->facts.first_hit);
    if (!st)
        st = read_integer(err, &at, "first_pocketed", -1, 15, &g->facts.first_pocketed);
    if (!st)
        st = ap_json_bool(err, &at, "cushion_after", &g->facts.cushion_after);
    g->facts.on_table = (unsigned)on_table;
    g->facts.pocketed = (unsigned)pocketed;
    g->facts.to_cushion = (unsigned)to_cushion;
    g->shooting = true;
    return st;
}

static enum ap_status check_version(struct ap_error *err, const struct ap_json_at *root) {
    double version;
    if (ap_json_number(NULL, root, "antipode_game", &version))
        return ap_json_fail(err, root, "this is no saved game: \"antipode_game\" is missing");
    if (version != VERSION)
        return ap_json_fail(err, root,
                            "saved by version %g of the format, this program reads version %d; the "
                            "file is left as it is",
                            version, VERSION);
    static const char *const keys[] = {"antipode_game", "table", "physics", "rules", "shots",
                                       "time_s",        "shot",  "balls",   NULL};
    return ap_json_check_keys(err, root, keys);
}

static enum ap_status read_game(struct ap_error *err, const struct ap_json_at *root,
                                struct ap_game *g) {
    double now_s = 0;
    enum ap_status st = check_version(err, root);
    if (!st)
        st = read_physics(err, root, &g->physics);
    if (!st)
        st = read_rules(err, root, g->physics.shape.sides, &g->rules);
    if (!st)
        st = read_integer(err, root, "shots", 0, 1000000, &g->shots);
    if (!st)
        st = ap_json_number(err, root, "time_s", &now_s);
    if (!st && !(now_s >= 0 && now_s < 1e9))
        return ap_json_fail(err, root, "time_s: expected 0 to 1e9");
    g->physics.now_s = now_s;
    if (!st)
        st = read_balls(err, root, &g->physics);
    if (!st)
        st = read_facts(err, root, g);
    g->verdict = (struct ap_verdict){.what = "", .spot = -1};
    return st;
}

enum ap_status ap_game_load(struct ap_error *err, const char *path, struct ap_game *game) {
    json_t *doc = NULL;
    enum ap_status st = ap_json_read(err, path, &doc);
    if (st)
        return st;
    struct ap_game *g = calloc(1, sizeof *g);
    struct ap_json_at root = ap_json_root(doc, path);
    st = g ? read_game(err, &root, g) : ap_fail(err, AP_ENVIRONMENT, "no memory for a game");
    if (!st)
        *game = *g;
    free(g);
    json_decref(doc);
    return st;
}
