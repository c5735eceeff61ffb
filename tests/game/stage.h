#ifndef ANTIPODE_TESTS_GAME_STAGE_H
#define ANTIPODE_TESTS_GAME_STAGE_H

#include "tests/check_near.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/game/physics.h"

// Every friction off, everything elastic.
static inline struct ap_physics_params frictionless(void) {
    return (struct ap_physics_params){.slide_friction = -1,
                                      .roll_friction = -1,
                                      .spin_friction = -1,
                                      .ball_restitution = 1,
                                      .ball_friction = -1,
                                      .cushion_restitution = 1,
                                      .cushion_friction = -1,
                                      .no_pockets = true};
}

static inline void open_table(int kappa, const struct ap_physics_params *params,
                              struct ap_physics *ph) {
    struct ap_table_shape shape = ap_table_from_edge(kappa, 0.9, 1);
    struct ap_error err = {""};
    if (ap_physics_init(&err, &shape, params, ph))
        fail_msg("%s", err.text);
}

static inline void place(struct ap_physics *ph, int ball, double x, double z) {
    struct ap_error err = {""};
    if (ap_physics_place(&err, ph, ball, (struct ap_plane2){x, z}))
        fail_msg("%s", err.text);
}

static inline void strike(struct ap_physics *ph, int ball, const struct ap_strike *s) {
    struct ap_error err = {""};
    if (ap_physics_strike(&err, ph, ball, s))
        fail_msg("%s", err.text);
}

static inline double distance_of(const struct ap_physics *ph, int a, int b) {
    return ap_plane_distance(ph->shape.space,
                             ap_plane_chord2(ph->shape.space.kappa,
                                             ap_physics_motion(ph, a, ph->now_s).foot_m,
                                             ap_physics_motion(ph, b, ph->now_s).foot_m));
}

// A number of [0, 1), the same on every machine.
static inline double random01(uint64_t *state) {
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) / 9007199254740992.0;
}

// Fifteen balls in a triangle, a little apart, the cue ball before them.
static inline void set_triangle(struct ap_physics *ph, double spread) {
    double gap = 2 * ph->params.ball_radius_m * spread, r = ph->shape.inradius_m;
    int i = 1;
    place(ph, 0, 0, 0.5 * r);
    for (int row = 0; row < 5; row++)
        for (int k = 0; k <= row; k++, i++)
            place(ph, i, (k - row / 2.0) * gap, 0.12 * r - row * gap * sqrt(0.75));
}

#endif
