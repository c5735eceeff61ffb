#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "src/geom/cells.h"
#include "src/track/tracker.h"
#include "tests/track/exact.h"

// Walkers in {5,3,4} of h3, rho 1 m, as CSV (docs/honeycombs.md, plotted by docs/walker.gnuplot).
// "given": steps of 0.1 rho ahead, told by room poses, against 448-bit arithmetic: how far off the
// walker is, seen from where she ought to be. "steered": a word of cells out and its inverse back,
// each leg in equal steps toward the middle of the next cell, from where she is.
//   bench_walker [CELLS [STEPS_A_LEG]]     default 1000 cells, 5 steps a leg

enum kind { WORLD, CELL, CELL_DD, CELL_DEEP, KINDS };
static const char *const names[KINDS] = {"world", "cell", "cell-dd", "cell-256"};

static struct ap_tiling tiling;
static struct ap_pairing pairing;
static struct ap_deep_iso deep_step[AP_CELL_FACES];
static const struct ap_vec4 base = {0, 0, 0, 1};

struct walker {
    enum kind kind;
    struct ap_tracker *tracker; // of the last two
    struct ap_iso world_from_head;
    struct ap_pose room_from_head;
};

static void die(const char *what) {
    fprintf(stderr, "%s\n", what);
    exit(1);
}

static struct walker walker_at(enum kind kind, struct ap_pose pose) {
    struct walker w = {.kind = kind, .room_from_head = pose};
    struct ap_tracker_params params = {
        .kind = AP_TRACKER_ANCHOR, .space = tiling.space, .deep = kind == CELL_DEEP};
    bool row;
    if (ap_tracker_create(NULL, &params, &w.tracker) ||
        ap_tracker_feed(NULL, w.tracker, "head", pose, &row, &w.world_from_head))
        die("no tracker");
    return w;
}

static void step_on(struct walker *w, struct ap_pose motion) {
    struct ap_iso way = ap_iso_from_pose(tiling.space, motion);
    w->world_from_head = ap_iso_mul(w->world_from_head, way);
    if (w->kind == CELL)
        w->world_from_head = ap_iso_orthonormalize(tiling.space, w->world_from_head);
}

// To a pose of the room.
static void follow(struct walker *w, struct ap_pose pose) {
    bool row;
    if (w->kind >= CELL_DD) {
        if (ap_tracker_feed(NULL, w->tracker, "head", pose, &row, &w->world_from_head))
            die("lost");
    } else {
        // Poses of src/geom are unit; the tracker takes any.
        struct ap_pose from = w->room_from_head, to = pose;
        from.q = ap_quat_normalize(from.q);
        to.q = ap_quat_normalize(to.q);
        step_on(w, ap_pose_mul(ap_pose_inverse(from), to));
    }
    w->room_from_head = pose;
}

// Along a vector of her own frame.
static void walk(struct walker *w, struct ap_vec3 v_m) {
    struct ap_pose motion = {v_m, {0, 0, 0, 1}};
    if (w->kind < CELL_DD)
        step_on(w, motion);
    else if (ap_tracker_carry(NULL, w->tracker, w->room_from_head, motion) ||
             !ap_tracker_place(w->tracker, w->room_from_head, &w->world_from_head))
        die("lost");
}

static void cross(struct walker *w, int face) {
    int back = pairing.to[face];
    const struct ap_iso *step = &pairing.cell_from_neighbour[back];
    if (w->kind < CELL_DD) {
        w->world_from_head = ap_iso_mul(*step, w->world_from_head);
        w->world_from_head = ap_iso_orthonormalize(tiling.space, w->world_from_head);
    } else if (ap_tracker_rebase(NULL, w->tracker, step, &pairing.low[back], &deep_step[back]) ||
               !ap_tracker_place(w->tracker, w->room_from_head, &w->world_from_head)) {
        die("lost");
    }
}

static void given(enum kind kind) {
    struct ap_tracker_params params = {.kind = AP_TRACKER_ANCHOR, .space = tiling.space};
    struct exact *exact = exact_create(&params);
    struct ap_pose pose = {{0.1, 0.2, 0.3}, {0, 0, 0, 1}};
    struct walker w = walker_at(kind, pose);
    exact_feed(exact, "head", pose);
    double crossed_m = 0;
    for (int i = 1; i <= 1000; i++) {
        pose.p.z -= 0.1;
        pose.q.x += 1e-4 * sin(i);
        pose.q.y += 1e-4 * cos(0.7 * i);
        follow(&w, pose);
        exact_feed(exact, "head", pose);
        if (kind != WORLD)
            for (int face;
                 (face = ap_cells_left_by(&tiling, ap_iso_apply(&w.world_from_head, base))) >= 0;) {
                cross(&w, face);
                exact_cross_534(exact, tiling.face_out[face]);
            }
        crossed_m += 0.1;
        double miss = exact_miss(exact, &w.world_from_head, NULL);
        if (i % 20 == 0 && isfinite(miss))
            printf("given,%s,%d,%.1f,%.3g,,\n", names[kind], i, crossed_m, miss);
        if (!(miss < 1))
            break; // a whole rho: lost
    }
    exact_destroy(exact);
    ap_tracker_destroy(w.tracker);
}

static double now_s(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

// To the middle of the neighbour; how far from it she ends, over rho.
static double leg(struct walker *w, int face, int steps) {
    struct ap_iso to = pairing.cell_from_neighbour[face];
    for (int left = steps; left > 0; left--) {
        struct ap_iso way = ap_iso_mul(ap_iso_inverse(tiling.space, w->world_from_head), to);
        struct ap_vec3 v = ap_log_unchecked(tiling.space, ap_iso_apply(&way, base), 0);
        walk(w, ap_vec3_scale(1.0 / left, v));
    }
    cross(w, face);
    const struct ap_iso *m = &w->world_from_head;
    return fmax(fabs(m->m[0][3]), fmax(fabs(m->m[1][3]), fabs(m->m[2][3])));
}

static void steered(enum kind kind, int cells, int steps) {
    int *word = malloc((size_t)cells * sizeof *word);
    struct walker w = walker_at(kind, (struct ap_pose){{0, 0, 0}, {0.2, 0.1, 0, 1}});
    struct ap_iso start = w.world_from_head;
    struct ap_vec4 home = base;
    double rho = 0, off = 0, open = 0, begin_s = now_s();
    uint64_t seed = 3;
    for (int i = 0; i < cells; i++) {
        do {
            seed = seed * 6364136223846793005u + 1442695040888963407u;
            word[i] = (int)((seed >> 33) % 12);
        } while (i > 0 && word[i] == pairing.to[word[i - 1]]);
        off = fmax(off, leg(&w, word[i], steps));
        home = ap_iso_apply(&pairing.cell_from_neighbour[pairing.to[word[i]]], home);
        rho += log(home.w);
        home = (struct ap_vec4){home.x / home.w, home.y / home.w, home.z / home.w, 1};
    }
    for (int i = cells; i-- > 0;)
        off = fmax(off, leg(&w, pairing.to[word[i]], steps));
    double step_ns = 1e9 * (now_s() - begin_s) / (2.0 * cells * steps);
    for (int i = 0; i < 16; i++)
        open = fmax(open, fabs(w.world_from_head.m[i / 4][i % 4] - start.m[i / 4][i % 4]));
    printf("steered,%s,%lld,%.0f,%.3g,%.3g,%.3g\n", names[kind], 2LL * cells * steps, rho, open,
           ap_iso_defect(tiling.space, &w.world_from_head), off);
    fprintf(stderr, "%s: %.0f ns a step\n", names[kind], step_ns);
    free(word);
    ap_tracker_destroy(w.tracker);
}

int main(int argc, char **argv) {
    int cells = argc > 1 ? atoi(argv[1]) : 1000, steps = argc > 2 ? atoi(argv[2]) : 5;
    if (cells < 1 || steps < 1)
        die("expected: bench_walker [CELLS [STEPS_A_LEG]]");
    if (ap_tiling_init(NULL, (struct ap_symbol){5, 3, 4}, (struct ap_space){-1, 1}, 0, &tiling))
        die("no tiling");
    ap_pairing_find(&tiling, &pairing);
    if (!ap_deep_steps(&tiling, &pairing, deep_step))
        die("no steps");
    printf("walk,walker,steps,farthest_rho,off,defect,worst_leg\n");
    for (int kind = 0; kind < KINDS; kind++)
        given((enum kind)kind);
    for (int n = 10; n < cells; n *= 10)
        for (int kind = CELL; kind < KINDS; kind++)
            steered((enum kind)kind, n, 5);
    for (int kind = CELL; kind < KINDS; kind++)
        steered((enum kind)kind, cells, steps);
    return 0;
}
