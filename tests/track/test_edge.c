#include "src/geom/table.h"
#include "tests/track/continuity.h"

// Invented walks round the table: the wood is where the eyes see it, and nothing jumps but what the
// conventions say. (Real recordings: test_logs.c.)

static const char *const spaces[] = {"s3", "e3", "h3"};

// The point of the physical square at perimeter c, `out` metres outside it.
static struct ap_vec3 round_table(double c, double edge_m, double out_m) {
    double e = floor(c), s = (c - e - 0.5) * edge_m;
    struct ap_vec3 p = {-s, 0, -edge_m / 2};
    p = ap_vec3_add(p, ap_vec3_scale(out_m / ap_vec3_length(p), p));
    for (int i = ((int)e % 4 + 4) % 4; i > 0; i--)
        p = (struct ap_vec3){p.z, 0, -p.x}; // rotY(90°)
    return p;
}

// Where the virtual edge is at perimeter c, by the table's geometry alone.
static struct ap_vec4 virtual_edge(const struct ap_tracker_params *params, double c) {
    struct ap_table_shape shape =
        ap_table_from_edge(params->space.kappa, params->table_edge_m, params->space.rho_m);
    double e = floor(c);
    struct ap_iso frame = ap_table_edge_frame(&shape, (long long)e);
    double s = (c - e - 0.5) * params->table_edge_m;
    struct ap_vec4 on_edge = ap_exp(params->space, (struct ap_vec3){-s, 0, 0});
    return ap_iso_apply(&frame, on_edge);
}

static double wood_error_m(const struct ap_tracker_params *params, struct ap_iso hand, double c) {
    struct ap_vec4 base = ap_exp(params->space, (struct ap_vec3){0, 0, 0});
    struct ap_error err;
    double d_m;
    if (ap_distance(&err, params->space, ap_iso_apply(&hand, base), virtual_edge(params, c), &d_m))
        fail_msg("%s", err.text);
    return d_m;
}

// Twelve laps of the head forth and back, the hand on the wood up to 1.9 edges from her: n virtual
// edges against four physical ones.
static void the_wood_is_where_it_is_seen(void **state) {
    (void)state;
    for (int s = 0; s < 3; s++) {
        struct ap_tracker_params params = params_of(spaces[s], NAN, AP_TRACKER_BILLIARDS);
        struct ap_tracker *t = tracker_of(&params);
        uint64_t seed = 21;
        double worst = 0;
        for (int i = 0; i <= 24000; i++) {
            double c = 0.3 + (i <= 12000 ? i : 24000 - i) * 48e-0 / 12000;
            struct ap_vec3 at = round_table(c, params.table_edge_m, 0.4);
            struct ap_iso m;
            feed(t, "head", pose_at(at.x, 1.6 + 0.1 * noise(&seed), at.z), &m);
            double hand_c = c + 1.9 * noise(&seed);
            at = round_table(hand_c, params.table_edge_m, 0);
            struct ap_pose hand = {{at.x, 0.75, at.z}, {noise(&seed), noise(&seed), 0, 1}};
            feed(t, "left", hand, &m);
            worst = fmax(worst, wood_error_m(&params, m, hand_c));
        }
        printf("%s: the wood is within %.2g m of where it is seen (tolerance 1e-9)\n", spaces[s],
               worst);
        if (!(worst <= 1e-9))
            fail_msg("%s: %g m", spaces[s], worst);
        ap_tracker_destroy(t);
    }
}

struct walk {
    const char *name;
    double (*head_c)(double t), (*head_out)(double t), (*hand_c)(double t); // t in 0…1
    double (*hand_out)(double t);
    int flips_at_least, flips_at_most;
};

static double lap_c(double t) {
    return 0.2 + 20 * t;
}
static double stop_and_turn_c(double t) {
    double u = t < 0.3 ? t : t < 0.5 ? 0.3 : t < 0.8 ? 0.8 - t : 0; // forth, stop, back, stop
    return 0.45 + 22 * u;
}
static double still_c(double t) {
    (void)t;
    return 2.3;
}
static double beside_c(double t) { // and not exactly opposite to the head on the other side
    (void)t;
    return 2.1;
}
static double across_out(double t) { // straight through the centre and out on the other side
    return 0.4 - 1.7 * t;
}
static double near_out(double t) {
    return 0.35 + 0.2 * sin(40 * t);
}
static double wood_out(double t) {
    (void)t;
    return 0;
}
static double reaching_out(double t) { // over the table, up to 0.2 m from its axis
    return -0.12 + 0.12 * sin(60 * t);
}
static double hand_with_head_c(double t) {
    return lap_c(t) + 0.8 * sin(31 * t);
}
static double hand_at_turn_c(double t) {
    return stop_and_turn_c(t) + 0.8 * sin(31 * t);
}
static double hand_round_c(double t) { // three laps about a head that stands
    return 2.3 + 12 * t;
}

static void follow(const struct walk *walk, const char *space) {
    struct ap_tracker_params params = params_of(space, NAN, AP_TRACKER_BILLIARDS);
    struct continuity k = continuity_of(&params);
    for (int i = 0; i <= 20000; i++) {
        double t = i / 20000.0;
        struct ap_vec3 at = round_table(walk->head_c(t), params.table_edge_m, walk->head_out(t));
        continuity_feed(&k, 0, pose_at(at.x, 1.5 + 0.1 * sin(50 * t), at.z));
        at = round_table(walk->hand_c(t), params.table_edge_m, walk->hand_out(t));
        continuity_feed(&k, 1, pose_at(at.x, 0.8 + 0.05 * cos(70 * t), at.z));
    }
    if (k.flips < walk->flips_at_least || k.flips > walk->flips_at_most)
        fail_msg("%s, %s: the hand jumped %lld times, expected %d to %d", walk->name, space,
                 (long long)k.flips, walk->flips_at_least, walk->flips_at_most);
    continuity_finish(&k, walk->name);
}

static void nothing_else_jumps(void **state) {
    (void)state;
    static const struct walk walks[] = {
        {"five laps", lap_c, near_out, hand_with_head_c, wood_out, 0, 0},
        {"stopping and turning back", stop_and_turn_c, near_out, hand_at_turn_c, reaching_out, 0,
         0},
        {"cutting across the centre", still_c, across_out, beside_c, wood_out, 0, 1},
        {"a hand running round a still head", still_c, near_out, hand_round_c, wood_out, 3, 3},
        {"a hand running round over the felt", still_c, near_out, hand_round_c, reaching_out, 3, 3},
    };
    for (size_t w = 0; w < sizeof walks / sizeof walks[0]; w++)
        for (int s = 0; s < 3; s++)
            follow(&walks[w], spaces[s]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_wood_is_where_it_is_seen),
        cmocka_unit_test(nothing_else_jumps),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
