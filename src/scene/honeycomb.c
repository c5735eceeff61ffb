#include "src/scene/honeycomb.h"

#include <stdlib.h>
#include <string.h>

enum { LEVELS = 6 };
static const unsigned wall_grey = 0x9aa4b2, strut_rgb = 0xd8c9a6, joint_rgb = 0xf2e6c8;

// Hues that the eye tells apart, once round the circle.
static unsigned hue_rgb(int i, int count, double light) {
    double h = 6.0 * i / count, c[3];
    for (int k = 0; k < 3; k++) {
        double d = fabs(fmod(h + 8 - 2 * k, 6) - 2); // distance from the k-th primary
        d = fmin(d, 6 - d);
        c[k] = light * (0.28 + 0.72 * fmax(0, fmin(1, 2 - d)));
    }
    return (unsigned)lround(255 * c[0]) << 16 | (unsigned)lround(255 * c[1]) << 8 |
           (unsigned)lround(255 * c[2]);
}

static int edge_between(const struct ap_tiling *t, int a, int b) {
    for (int e = 0; e < t->edge_count; e++)
        if ((t->edge_vertex[e][0] == a && t->edge_vertex[e][1] == b) ||
            (t->edge_vertex[e][0] == b && t->edge_vertex[e][1] == a))
            return e;
    return 0;
}

// Edges that are one edge of the space: the smallest number of each class.
static int edge_classes(const struct ap_tiling *t, const struct ap_pairing *p,
                        int of[AP_CELL_EDGES]) {
    for (int e = 0; e < t->edge_count; e++)
        of[e] = e;
    for (bool changed = true; changed;) {
        changed = false;
        for (int f = 0; f < t->face_count; f++)
            for (int k = 0; k < t->symbol.p; k++) {
                int a = t->face_vertex[f][k], b = t->face_vertex[f][(k + 1) % t->symbol.p];
                const struct ap_symmetry *s = &t->symmetry[t->symmetry[p->turn[f]].inverse];
                int e = edge_between(t, a, b), g = edge_between(t, s->vertex[a], s->vertex[b]);
                int least = of[e] < of[g] ? of[e] : of[g];
                changed = changed || of[e] != least || of[g] != least;
                of[e] = of[g] = least;
            }
    }
    int rank[AP_CELL_EDGES], count = 0;
    for (int e = 0; e < t->edge_count; e++)
        if (of[e] == e)
            rank[e] = count++;
    for (int e = 0; e < t->edge_count; e++)
        of[e] = of[e] == e ? rank[e] : of[of[e]];
    return count;
}

// A solid in several levels, coarse before fine; returns the first.
struct level_of {
    double longest_m, turn_rad;
};

static int add_level(struct ap_scene_build *build, struct ap_mesh *mesh, struct level_of level) {
    int at = ap_build_solid(build, mesh);
    if (build->out_of_memory)
        return 0;
    build->scene->solids[at].longest_m = level.longest_m;
    build->scene->solids[at].turn_rad = level.turn_rad;
    return at;
}

static void add_piece(struct ap_scene_build *build, struct ap_iso place, int solid,
                      enum ap_form form, double radius_m, unsigned rgb) {
    struct ap_part part = ap_solid_part(place, solid, rgb);
    part.carrier = AP_CARRIER_CELL;
    part.solid_levels = LEVELS;
    part.one_sided = true;
    part.finish = AP_FINISH_MATTE; // else its light would change with its level
    part.form = form;
    part.radius_m = radius_m;
    ap_build_part(build, part);
}

static void add_walls(struct ap_scene_build *build, struct ap_honeycomb *h, double width) {
    const struct ap_tiling *t = &h->tiling;
    int first = -1, rank[AP_CELL_FACES], count = 0;
    for (int k = 0; k < LEVELS; k++) {
        struct ap_mesh mesh = {0};
        struct level_of level = {0};
        ap_mesh_wall(t, width, 1 << k, &mesh, &level.longest_m);
        int at = add_level(build, &mesh, level);
        first = first < 0 ? at : first;
    }
    for (int f = 0; f < t->face_count; f++)
        rank[f] = h->pairing.to[f] >= f ? count++ : rank[h->pairing.to[f]];
    for (int f = 0; f < t->face_count; f++)
        add_piece(build, ap_wall_place(t, f), first, AP_FORM_PLANE, 0,
                  h->pairing.loose ? wall_grey : hue_rgb(rank[f], count, 0.92));
    h->has_walls = true;
    for (int f = 0; f < t->face_count; f++)
        h->window[f] = ap_wall_window(t, f, width);
}

static void add_struts(struct ap_scene_build *build, const struct ap_honeycomb *h, double width) {
    const struct ap_tiling *t = &h->tiling;
    double radius = 0.5 * width * fmin(t->face_inradius_m, t->edge_m / 2);
    double joint = ap_joint_radius(t, radius);
    int first = -1, first_joint = -1, class_of[AP_CELL_EDGES];
    for (int k = 0; k < LEVELS; k++) {
        struct ap_mesh mesh = {0};
        struct level_of level = {0};
        ap_mesh_strut(t, radius, 1 << k, &mesh, &level.longest_m, &level.turn_rad);
        int at = add_level(build, &mesh, level);
        first = first < 0 ? at : first;
    }
    for (int k = 0; k < LEVELS; k++) {
        struct ap_mesh cap = {0};
        struct level_of level = {0};
        ap_mesh_joint(t, joint, 1 << (k < 4 ? k : 4), &cap, &level.longest_m, &level.turn_rad);
        int at = add_level(build, &cap, level);
        first_joint = first_joint < 0 ? at : first_joint;
    }
    int count = edge_classes(t, &h->pairing, class_of);
    for (int e = 0; e < t->edge_count; e++)
        add_piece(build, ap_strut_place(t, e), first, AP_FORM_TUBE, radius,
                  h->pairing.loose || count < 2 ? strut_rgb : hue_rgb(class_of[e], count, 0.95));
    for (int v = 0; v < t->vertex_count; v++)
        add_piece(build, ap_joint_place(t, v), first_joint, AP_FORM_SPHERE, joint, joint_rgb);
}

static enum ap_status choose_pairing(struct ap_error *err, const struct ap_json_at *at,
                                     const struct ap_honeycomb_plan *plan, struct ap_honeycomb *h) {
    struct ap_error why = {""};
    enum ap_status st = AP_OK;
    int entry = -1;
    if (!plan->quotient)
        ap_pairing_find(&h->tiling, &h->pairing);
    else if (!plan->name)
        st = ap_pairing_from_faces(&why, &h->tiling, plan->pairs, plan->pair_count, &entry,
                                   &h->pairing);
    else if (strcmp(plan->name, "mirrored-dodecahedron") == 0)
        st = ap_pairing_mirrors(&why, &h->tiling, &h->pairing);
    else
        st = ap_pairing_opposite(&why, &h->tiling,
                                 plan->symbol.p == 4   ? 0
                                 : plan->symbol.r == 3 ? M_PI / 5
                                                       : 3 * M_PI / 5,
                                 &h->pairing);
    if (!st)
        return AP_OK;
    struct ap_json_at pairs = ap_json_member(at, "pairs");
    struct ap_json_at pair = entry >= 0 ? ap_json_element(&pairs, (size_t)entry) : pairs;
    return ap_json_fail(err, &pair, "%s", why.text);
}

double ap_honeycomb_radius(const struct ap_honeycomb_plan *plan) {
    double edge = 1, inradius = 1;
    if (plan->kappa == 0 || ap_symbol_lengths(NULL, plan->symbol, &edge, &inradius))
        return 1;
    return plan->look.edge_m > 0 ? plan->look.edge_m / edge : 1 / inradius;
}

static enum ap_status check_edge(struct ap_error *err, const struct ap_json_at *at,
                                 const struct ap_honeycomb_plan *plan,
                                 const struct ap_tiling *tiling) {
    double asked = plan->look.edge_m;
    if (plan->kappa == 0 || !(asked > 0) || fabs(asked - tiling->edge_m) <= 1e-9 * asked)
        return AP_OK;
    struct ap_json_at edge = ap_json_member(at, "edge_m");
    return ap_json_fail(err, &edge,
                        "%.9g m does not fit the radius %.9g m, whose {%d,%d,%d} has an edge of "
                        "%.9g m: leave one of the two out",
                        asked, tiling->space.rho_m, plan->symbol.p, plan->symbol.q, plan->symbol.r,
                        tiling->edge_m);
}

enum ap_status ap_furnish_honeycomb(struct ap_error *err, const struct ap_json_at *at,
                                    const struct ap_honeycomb_plan *plan,
                                    struct ap_scene_build *build) {
    struct ap_honeycomb *h = calloc(1, sizeof *h);
    if (!h)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory for a honeycomb");
    build->scene->honeycomb = h;
    h->quotient = plan->quotient;
    h->horizon_px = plan->look.horizon_px;
    if (!build->scene->budget_bytes)
        build->scene->budget_bytes = (size_t)(plan->look.budget_mib * 1048576);
    double e3_edge = plan->look.edge_m > 0 ? plan->look.edge_m : 2;
    enum ap_status st = ap_tiling_init(err, plan->symbol, build->scene->space, e3_edge, &h->tiling);
    if (!st)
        st = check_edge(err, at, plan, &h->tiling);
    if (!st)
        st = choose_pairing(err, at, plan, h);
    if (st)
        return st;
    double inradius = h->tiling.inradius_m;
    // Where frames depend on the way, only the centre looks the same in all of them.
    struct ap_vec3 lamp = {0.15 * inradius, 0.4 * inradius, 0.2 * inradius};
    h->lamp = ap_exp(build->scene->space, ap_vec3_scale(h->pairing.loose ? 0 : 1, lamp));
    if (plan->look.walls)
        add_walls(build, h, plan->look.width);
    if (plan->look.struts)
        add_struts(build, h, plan->look.width);
    if (plan->look.balls) {
        struct ap_part ball = ap_ball_part(AP_ISO_IDENTITY, 0.22 * inradius, 0xe8ecf4);
        ball.carrier = AP_CARRIER_CELL;
        ball.finish = AP_FINISH_MATTE;
        ap_build_part(build, ball);
    }
    return AP_OK;
}
