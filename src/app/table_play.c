#include "src/app/table_play.h"

#include <stdlib.h>

// The table of the scene in the game's terms.
static enum ap_status params_of(struct ap_error *err, const struct ap_scene *scene,
                                const struct ap_shots *shots, struct ap_game_params *params) {
    double radius_m = 0;
    for (size_t i = 0; i < scene->part_count; i++)
        if (scene->parts[i].pool_ball)
            radius_m = scene->parts[i].radius_m;
    if (!(radius_m > 0))
        return ap_fail(err, AP_USAGE,
                       "--game: the scene has no pool balls to play with (the "
                       "billiards room has)");
    if (shots)
        params->physics = shots->physics;
    if (params->physics.ball_radius_m == 0)
        params->physics.ball_radius_m = radius_m;
    if (params->physics.pocket_radius_m == 0 && scene->mouth_count > 0)
        params->physics.pocket_radius_m = scene->mouths[0].radius_m;
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

enum ap_status ap_table_play_open(struct ap_error *err, struct ap_scene *scene, const char *kind,
                                  const char *shots_path, struct ap_table_play **out) {
    struct ap_game_params params = {.kind = AP_GAME_FREE};
    struct ap_table_play *play = calloc(1, sizeof *play);
    enum ap_status st = play ? AP_OK : ap_fail(err, AP_ENVIRONMENT, "no memory for a game");
    if (!st)
        st = ap_game_kind_from_name(err, kind, &params.kind);
    if (!st && shots_path)
        st = ap_shots_read(err, shots_path, &play->shots);
    if (!st)
        st = params_of(err, scene, play->shots, &params);
    if (!st)
        st = ap_game_start(err, &params, &play->game);
    if (st) {
        ap_table_play_close(play);
        return st;
    }
    play->scene = scene;
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

enum ap_status ap_table_play_step(struct ap_error *err, struct ap_table_play *play, double t_s) {
    enum ap_status st = AP_OK;
    if (play->shots)
        st = ap_shot_player_run(err, &play->player, &play->game, t_s, NULL);
    else
        while (ap_game_advance(&play->game, t_s, NULL, NULL))
            ;
    if (!st)
        ap_table_play_show(play);
    return st;
}
