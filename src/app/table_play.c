#include "src/app/table_play.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// The table of the scene in the game's terms.
static enum ap_status params_of(struct ap_error *err, const struct ap_scene *scene,
                                const struct ap_shots *shots, struct ap_game_params *params) {
    double radius_m = 0;
    for (size_t i = 0; i < scene->part_count; i++)
        if (scene->parts[i].pool_ball)
            radius_m = scene->parts[i].radius_m;
    if (!(radius_m > 0))
        return ap_fail(err, AP_USAGE,
                       "the scene has no pool balls to play with (the "
                       "billiards room has)");
    if (shots)
        params->physics = shots->physics;
    if (params->physics.ball_radius_m == 0)
        params->physics.ball_radius_m = radius_m;
    if (params->physics.pocket_radius_m == 0 && scene->mouth_count > 0)
        params->physics.pocket_radius_m = scene->mouths[0].radius_m;
    params->physics.side_pockets |= scene->mouth_count > 4 && scene->space.kappa == 0;
    params->shape = ap_table_from_edge(scene->space.kappa, scene->table_edge_m, scene->space.rho_m);
    return AP_OK;
}

void ap_table_play_show(struct ap_table_play *play) {
    const struct ap_physics *ph = &play->game.physics;
    for (size_t i = 0; i < play->scene->part_count; i++) {
        struct ap_part *part = &play->scene->parts[i];
        int ball = part->pool_ball - 1;
        if (ball < 0)
            continue;
        part->hidden = ball >= ph->ball_count || ph->ball[ball].state == AP_BALL_POCKETED;
        part->radius_m = ph->params.ball_radius_m;
        if (!part->hidden)
            part->carrier_from_part = ap_physics_world_from_ball(ph, ball);
    }
}

bool ap_table_play_is_possible(const struct ap_scene *scene) {
    bool balls = false;
    for (size_t i = 0; i < scene->part_count; i++)
        balls |= scene->parts[i].pool_ball > 0;
    return balls && scene->table_edge_m > 0;
}

// A saved game belongs to one table, and where a kind is asked for to one game.
static enum ap_status check_saved(struct ap_error *err, const struct ap_game *game,
                                  const struct ap_table_shape *shape, const char *path,
                                  const char *kind, bool side_pockets) {
    const struct ap_table_shape *own = &game->physics.shape;
    struct ap_space a = own->space, b = shape->space;
    if (a.kappa != b.kappa || fabs(a.rho_m - b.rho_m) > 1e-9 * b.rho_m ||
        fabs(own->edge_m - shape->edge_m) > 1e-9)
        return ap_fail(
            err, AP_INPUT,
            "%s: a game on a table of %.9g m in %s of radius %.9g m, here it is %.9g m in "
            "%s of radius %.9g m",
            path, own->edge_m, ap_space_name(a), a.rho_m, shape->edge_m, ap_space_name(b), b.rho_m);
    if (game->physics.params.side_pockets != side_pockets)
        return ap_fail(err, AP_INPUT, "%s: a game on a table of %d pockets, here it is %s", path,
                       game->physics.pocket_count, side_pockets ? "six" : "four");
    const char *own_kind = ap_game_kind_name(game->rules.kind);
    if (kind && strcmp(kind, own_kind) != 0)
        return ap_fail(err, AP_INPUT, "%s: a game of %s, not of %s", path, own_kind, kind);
    return AP_OK;
}

static enum ap_status begin(struct ap_error *err, const struct ap_table_play_params *how,
                            struct ap_scene *scene, struct ap_table_play *play) {
    struct ap_game_params params = {.kind = AP_GAME_FREE};
    enum ap_status st = AP_OK;
    if (how->kind)
        st = ap_game_kind_from_name(err, how->kind, &params.kind);
    if (!st && how->shots_path)
        st = ap_shots_read(err, how->shots_path, &play->shots);
    if (!st)
        st = params_of(err, scene, play->shots, &params);
    if (st)
        return st;
    if (!how->saved_path)
        return ap_game_start(err, &params, &play->game);
    st = ap_game_load(err, how->saved_path, &play->game);
    return st ? st
              : check_saved(err, &play->game, &params.shape, how->saved_path, how->kind,
                            params.physics.side_pockets);
}

enum ap_status ap_table_play_open(struct ap_error *err, struct ap_scene *scene,
                                  const struct ap_table_play_params *params,
                                  struct ap_table_play **out) {
    struct ap_table_play *play = calloc(1, sizeof *play);
    enum ap_status st = play ? begin(err, params, scene, play)
                             : ap_fail(err, AP_ENVIRONMENT, "no memory for a game");
    if (st) {
        ap_table_play_close(play);
        return st;
    }
    play->scene = scene;
    play->start_s = play->game.physics.now_s;
    play->player = (struct ap_shot_player){.shots = play->shots, .pause_s = 0.5};
    ap_table_play_show(play);
    *out = play;
    return AP_OK;
}

void ap_table_play_close(struct ap_table_play *play) {
    if (!play)
        return;
    ap_shots_destroy(play->shots);
    free(play);
}

static enum ap_status run_to(struct ap_error *err, struct ap_table_play *play, double now_s) {
    enum ap_status st = AP_OK;
    if (play->shots)
        st = ap_shot_player_run(err, &play->player, &play->game, now_s, NULL);
    else
        while (ap_game_advance(&play->game, now_s, NULL, NULL))
            ;
    if (!st)
        ap_table_play_show(play);
    return st;
}

enum ap_status ap_table_play_step(struct ap_error *err, struct ap_table_play *play, double t_s) {
    return run_to(err, play, play->start_s + t_s);
}

enum ap_status ap_table_play_finish(struct ap_error *err, struct ap_table_play *play) {
    double end_s = play->shots ? ap_shots_end_s(play->shots) : INFINITY;
    return isfinite(end_s) ? run_to(err, play, end_s) : AP_OK;
}
