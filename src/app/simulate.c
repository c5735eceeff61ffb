#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/app/command.h"
#include "src/base/log.h"
#include "src/base/number.h"
#include "src/game/shots.h"
#include "src/track/setup.h"

// antipode simulate: scripted shots in, every event with 17 digits out, so that another simulation
// can be held against this one.

static const char help[] =
    "Plays the shots of a script on the table of the space and writes CSV to standard output: a row\n"
    "for each event and each ball in it, as the ball is after it.\n"
    "  t_s,event,ball,other,speed_m_s,state,x_m,z_m,w_m,vx_m_s,vz_m_s,vw_m_s,rx,rz,rw,spin_rad_s\n"
    "(x, z, w) is the foot, (vx, vz, vw) its velocity, (rx, rz, rw) its turn times up, rad/s: a ball\n"
    "rolls where that is the velocity over R; spin is the turn about up. 'other' is a ball, an edge or\n"
    "a pocket, 'speed' that of approach. Events: start, shot, balls, cushion, pocket, roll, stop and,\n"
    "with --step, sample. A '#' line tells the constants, and how each shot was judged.\n"
    "The script and the model: docs/billiards.md, docs/physics.md.\n"
    "Exit statuses: 0; 2 usage; 3 a script that cannot be read or played; 4 output cannot be written.";

struct options {
    const char *space, *game;
    double radius_m, table_edge_m, step_s, limit_s;
    bool side_pockets, no_pockets;
};

struct run {
    struct ap_game game;
    struct ap_shot_player player;
};

static void put(double v, char after) {
    char text[AP_DOUBLE_TEXT_MAX];
    fwrite(text, 1, ap_format_double(text, v + 0.0), stdout);
    putchar(after);
}

static void put_row(const struct ap_physics *ph, double t_s, const char *event, int ball, int other,
                    double speed) {
    static const char *const states[] = {"rest", "spin", "roll", "slide", "pocket"};
    const struct ap_ball *b = &ph->ball[ball];
    struct ap_ball_motion m = ap_physics_motion(ph, ball, t_s);
    put(t_s, ',');
    printf("%s,%d,", event, ball);
    printf(other >= 0 ? "%d," : ",", other);
    put(speed, ',');
    printf("%s,", states[b->state]);
    const struct ap_plane3 *v[3] = {&m.foot_m, &m.velocity_m_s, &m.rolling_rad_s};
    for (int i = 0; i < 3; i++) {
        put(v[i]->x, ',');
        put(v[i]->z, ',');
        put(v[i]->w, ',');
    }
    put(m.spin_rad_s, '\n');
}

static void put_event(void *data, const struct ap_physics_event *e) {
    static const char *const names[] = {"none", "balls", "cushion", "pocket",
                                        "roll", "stop",  "shot"};
    struct run *run = data;
    put_row(&run->game.physics, e->t_s, names[e->kind], e->a, e->b, e->speed_m_s);
    if (e->kind == AP_EVENT_BALLS)
        put_row(&run->game.physics, e->t_s, names[e->kind], e->b, e->a, e->speed_m_s);
}

static void put_all(const struct run *run, const char *event) {
    const struct ap_physics *ph = &run->game.physics;
    for (int i = 0; i < ph->ball_count; i++)
        if (ph->ball[i].state != AP_BALL_POCKETED)
            put_row(ph, ph->now_s, event, i, -1, 0);
}

static void put_line(void *data, const struct ap_shot_line *line) {
    struct run *run = data;
    if (line->kind == AP_LINE_SHOT)
        put_row(&run->game.physics, run->game.physics.now_s, "shot", 0, -1, line->speed_m_s);
    else if (line->kind == AP_LINE_PLACE)
        put_row(&run->game.physics, run->game.physics.now_s, "start", 0, -1, 0);
    else if (line->kind == AP_LINE_BALL)
        put_row(&run->game.physics, run->game.physics.now_s, "start", line->ball, -1, 0);
    else if (line->kind == AP_LINE_UNDO || line->kind == AP_LINE_RACK)
        put_all(run, "start");
}

static void put_judged(void *data) {
    struct run *run = data;
    char text[AP_GAME_TEXT_MAX];
    ap_game_text(&run->game, text);
    printf("# %s\n", text);
}

static void put_head(const struct run *run) {
    const struct ap_physics *ph = &run->game.physics;
    const struct ap_physics_params *p = &ph->params;
    const struct {
        const char *name;
        double value;
    } list[] = {
        {"rho_m", ph->shape.space.rho_m},          {"edge_m", ph->shape.edge_m},
        {"ball_radius_m", p->ball_radius_m},       {"R_m", ph->rolling_radius_m},
        {"edge_distance_m", ph->edge_distance_m},  {"pocket_radius_m", p->pocket_radius_m},
        {"ball_mass_kg", p->ball_mass_kg},         {"gravity_m_s2", p->gravity_m_s2},
        {"slide_friction", p->slide_friction},     {"roll_friction", p->roll_friction},
        {"spin_friction", p->spin_friction},       {"ball_restitution", p->ball_restitution},
        {"ball_friction", p->ball_friction},       {"cushion_restitution", p->cushion_restitution},
        {"cushion_friction", p->cushion_friction}, {"cushion_m", p->cushion_m},
        {"cue_mass_kg", p->cue_mass_kg},           {"tip_restitution", p->tip_restitution}};
    printf("# space=%s", ap_space_name(ph->shape.space));
    for (size_t i = 0; i < sizeof list / sizeof *list; i++) {
        printf(" %s=", list[i].name);
        char text[AP_DOUBLE_TEXT_MAX];
        fwrite(text, 1, ap_format_double(text, list[i].value), stdout);
    }
    printf("\nt_s,event,ball,other,speed_m_s,state,x_m,z_m,w_m,vx_m_s,vz_m_s,vw_m_s,rx,rz,rw,"
           "spin_rad_s\n");
    put_all(run, "start");
}

static enum ap_status play(struct ap_error *err, struct run *run, const struct options *o) {
    const struct ap_shot_watch watch = {run, put_event, put_line, put_judged};
    double step_s = isnan(o->step_s) ? 1 : o->step_s;
    put_head(run);
    enum ap_status st = AP_OK;
    for (long k = 1; !st && !ap_shot_player_done(&run->player, &run->game); k++) {
        double t_s = (double)k * step_s;
        if (t_s > o->limit_s)
            return ap_fail(err, AP_INPUT, "after %g s the script is not done (see --limit)",
                           o->limit_s);
        st = ap_shot_player_run(err, &run->player, &run->game, t_s, &watch);
        if (!st && !isnan(o->step_s))
            put_all(run, "sample");
    }
    if (!st && (fflush(stdout) != 0 || ferror(stdout)))
        st = ap_fail(err, AP_ENVIRONMENT, "cannot write to standard output: %s", strerror(errno));
    return st;
}

static enum ap_status open_game(struct ap_error *err, const struct options *o,
                                const struct ap_shots *shots, struct run *run) {
    const struct ap_track_setup setup = {.space = o->space,
                                         .radius_m = o->radius_m,
                                         .tracker = AP_TRACKER_BILLIARDS,
                                         .table_edge_m = o->table_edge_m};
    struct ap_tracker_params table;
    struct ap_game_params params = {.physics = shots->physics};
    enum ap_status st = ap_track_setup(err, &setup, &table);
    if (!st)
        st = ap_game_kind_from_name(err, o->game, &params.kind);
    if (st)
        return st;
    params.shape = ap_table_from_edge(table.space.kappa, table.table_edge_m, table.space.rho_m);
    params.physics.side_pockets = o->side_pockets;
    params.physics.no_pockets = o->no_pockets;
    run->player = (struct ap_shot_player){.shots = shots, .pause_s = 0.5};
    return ap_game_start(err, &params, &run->game);
}

static enum ap_status run_simulate(struct ap_error *err, int argc, char **argv) {
    struct options o = {.space = "h3",
                        .game = "free",
                        .radius_m = NAN,
                        .table_edge_m = NAN,
                        .step_s = NAN,
                        .limit_s = 3600};
    const struct ap_option options[] = {
        {"space", AP_OPTION_CHOICE, &o.space, "h3|s3|e3", "the curved space (h3)"},
        {"radius", AP_OPTION_NUMBER, &o.radius_m, "M", "its radius in metres"},
        {"table-edge", AP_OPTION_NUMBER, &o.table_edge_m, "M", "edge of the table (0.9)"},
        {"game", AP_OPTION_CHOICE, &o.game, "free|eight-ball|nine-ball", "which rules (free)"},
        {"side-pockets", AP_OPTION_FLAG, &o.side_pockets, "", "e3: six pockets"},
        {"no-pockets", AP_OPTION_FLAG, &o.no_pockets, "", "cushions all round"},
        {"step", AP_OPTION_NUMBER, &o.step_s, "S", "rows of all balls every S seconds, too"},
        {"limit", AP_OPTION_NUMBER, &o.limit_s, "S", "give up after so long in the game (3600)"},
    };
    const struct ap_usage usage = {.command = "simulate",
                                   .operands = "SHOTS",
                                   .text = help,
                                   .options = options,
                                   .option_count = sizeof options / sizeof *options,
                                   .min_operands = 1,
                                   .max_operands = 1};
    int operands;
    bool done;
    enum ap_status st = ap_parse_options(err, &usage, argc, argv, &operands, &done);
    if (st || done)
        return st;
    if (!isnan(o.step_s) && !(o.step_s >= 1e-5))
        return ap_fail(err, AP_USAGE, "--step: expected at least 1e-5 seconds");
    struct ap_shots *shots = NULL;
    struct run *run = calloc(1, sizeof *run);
    st = run ? ap_shots_read(err, argv[1], &shots) : ap_fail(err, AP_ENVIRONMENT, "no memory");
    if (!st)
        st = open_game(err, &o, shots, run);
    if (!st)
        st = play(err, run, &o);
    ap_shots_destroy(shots);
    free(run);
    return st;
}

const struct ap_command ap_command_simulate = {
    "simulate", "scripted billiards shots as a table of events", run_simulate};
