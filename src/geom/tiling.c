#include "src/geom/tiling.h"

#include <string.h>

#include "src/geom/arc.h"
#include "src/geom/dd.h"

// The fundamental simplex of {p,q,r}: four mirrors n0…n3, of which the first three go through the
// cell's centre, so that they are vectors of R³, and the last is the plane of face 0. Their angles
// are pi/p, pi/q, pi/r between neighbours, right otherwise.

struct dd3 {
    struct ap_dd x, y, z;
};

struct turn {
    struct ap_dd m[3][3];
};

struct simplex {
    struct dd3 normal[3];
    struct dd3 face, edge, vertex; // unit, from the cell's centre
    int kappa;
    struct ap_dd lean, height; // n3 = (0, lean, 0), and how far off: tan of a radius along u is
                               // height/(−lean·u.y)
};

static struct ap_dd cosine_of(int n) {
    if (n == 3)
        return ap_dd_of(0.5);
    if (n == 4)
        return ap_dd_scale(0.5, ap_dd_sqrt(ap_dd_of(2)));
    return ap_dd_scale(0.25, ap_dd_add(ap_dd_of(1), ap_dd_sqrt(ap_dd_of(5))));
}

static struct ap_dd square(struct ap_dd a) {
    return ap_dd_mul(a, a);
}

static struct ap_dd one_minus(struct ap_dd a) {
    return ap_dd_sub(ap_dd_of(1), a);
}

static struct ap_dd sine_of(int n) {
    return ap_dd_sqrt(one_minus(square(cosine_of(n))));
}

static struct ap_dd dot(const struct dd3 *a, const struct dd3 *b) {
    return ap_dd_add(ap_dd_add(ap_dd_mul(a->x, b->x), ap_dd_mul(a->y, b->y)),
                     ap_dd_mul(a->z, b->z));
}

static struct dd3 scaled(struct ap_dd s, const struct dd3 *v) {
    return (struct dd3){ap_dd_mul(s, v->x), ap_dd_mul(s, v->y), ap_dd_mul(s, v->z)};
}

static struct dd3 minus(const struct dd3 *a, const struct dd3 *b) {
    return (struct dd3){ap_dd_sub(a->x, b->x), ap_dd_sub(a->y, b->y), ap_dd_sub(a->z, b->z)};
}

// The unit vector on mirrors a and b, on the inner side of c.
static struct dd3 corner(const struct dd3 *a, const struct dd3 *b, const struct dd3 *c) {
    struct dd3 v = {ap_dd_sub(ap_dd_mul(a->y, b->z), ap_dd_mul(a->z, b->y)),
                    ap_dd_sub(ap_dd_mul(a->z, b->x), ap_dd_mul(a->x, b->z)),
                    ap_dd_sub(ap_dd_mul(a->x, b->y), ap_dd_mul(a->y, b->x))};
    struct ap_dd length = ap_dd_sqrt(dot(&v, &v));
    if (dot(&v, c).hi < 0)
        length = ap_dd_neg(length);
    return scaled(ap_dd_div(ap_dd_of(1), length), &v);
}

enum ap_status ap_symbol_space(struct ap_error *err, struct ap_symbol s, int *kappa) {
    const int least = s.p < s.q ? (s.p < s.r ? s.p : s.r) : (s.q < s.r ? s.q : s.r);
    if (least < 3 || s.p > 1000 || s.q > 1000 || s.r > 1000)
        return ap_fail(err, AP_INPUT,
                       "{%d,%d,%d} is not a tiling of space: expected three whole numbers from 3 "
                       "on, as in 5,3,4",
                       s.p, s.q, s.r);
    int cell = (s.p - 2) * (s.q - 2), corner_angle = (s.q - 2) * (s.r - 2);
    if (cell >= 4)
        return ap_fail(err, AP_INPUT,
                       "{%d,%d,%d} is a tiling of h3, but its cells {%d,%d} are %s planes without "
                       "end: only bounded cells can be walked through (as 5,3,4 or 4,3,5 of h3)",
                       s.p, s.q, s.r, s.p, s.q, cell == 4 ? "flat" : "hyperbolic");
    if (corner_angle >= 4)
        return ap_fail(
            err, AP_INPUT,
            "{%d,%d,%d} is a tiling of h3, but the corners of its cells lie %s infinity "
            "({%d,%d} round each): only bounded cells can be walked through (as 5,3,4 or "
            "4,3,5 of h3)",
            s.p, s.q, s.r, corner_angle == 4 ? "at" : "beyond", s.q, s.r);
    // Now all three are 3, 4 or 5.
    double excess = ap_dd_sub(ap_dd_mul(sine_of(s.p), sine_of(s.r)), cosine_of(s.q)).hi;
    *kappa = excess > 1e-9 ? 1 : excess < -1e-9 ? -1 : 0;
    return AP_OK;
}

static void simplex_of(struct ap_symbol s, int kappa, struct simplex *x) {
    struct ap_dd zero = ap_dd_of(0), cp = cosine_of(s.p), sp = sine_of(s.p);
    struct ap_dd cq = cosine_of(s.q), cr = cosine_of(s.r), sr = sine_of(s.r);
    struct ap_dd z = ap_dd_neg(ap_dd_div(cq, sp)), y = ap_dd_sqrt(one_minus(square(z)));
    x->kappa = kappa;
    x->normal[0] = (struct dd3){ap_dd_of(1), zero, zero};
    x->normal[1] = (struct dd3){ap_dd_neg(cp), zero, sp};
    x->normal[2] = (struct dd3){zero, ap_dd_neg(y), z};
    x->face = corner(&x->normal[0], &x->normal[1], &x->normal[2]);
    x->edge = corner(&x->normal[0], &x->normal[2], &x->normal[1]);
    x->vertex = corner(&x->normal[1], &x->normal[2], &x->normal[0]);
    x->lean = ap_dd_div(cr, y);
    // lean² − 1 = (cos²q − sin²p·sin²r)/(sin²p − cos²q), as a product so that little cancels.
    struct ap_dd product = ap_dd_mul(sp, sr);
    struct ap_dd above = ap_dd_mul(ap_dd_sub(cq, product), ap_dd_add(cq, product));
    struct ap_dd below = ap_dd_mul(ap_dd_sub(sp, cq), ap_dd_add(sp, cq));
    x->height = ap_dd_sqrt(ap_dd_div(kappa > 0 ? ap_dd_neg(above) : above, below));
    if (kappa == 0) // an edge of 1: the radius of the edge's middle against half an edge
        x->height = ap_dd_of(0.5);
}

// (C, S) of the distance from the centre at which a ray meets face 0; e3 in edges.
static void radius(const struct simplex *x, const struct dd3 *u, struct ap_dd *c, struct ap_dd *s) {
    struct ap_dd t = ap_dd_div(x->height, ap_dd_neg(ap_dd_mul(x->lean, u->y)));
    *c = ap_dd_of(1);
    if (x->kappa) {
        struct ap_dd tt = square(t);
        struct ap_dd norm = x->kappa > 0 ? ap_dd_add(*c, tt) : one_minus(tt);
        *c = ap_dd_div(*c, ap_dd_sqrt(norm));
    }
    *s = ap_dd_mul(t, *c);
}

static double length_of(int kappa, struct ap_dd c, struct ap_dd s) {
    return kappa > 0 ? atan2(s.hi, c.hi) : kappa < 0 ? asinh(s.hi) : s.hi;
}

// Between the points at (C, S) along u and along v.
static double between(const struct simplex *x, const struct dd3 *u, const struct dd3 *v) {
    struct ap_dd cu, su, cv, sv;
    radius(x, u, &cu, &su);
    radius(x, v, &cv, &sv);
    struct dd3 a = scaled(su, u), b = scaled(sv, v);
    if (x->kappa == 0) {
        struct dd3 d = minus(&a, &b);
        return ap_dd_sqrt(dot(&d, &d)).hi;
    }
    struct ap_dd c = ap_dd_mul(cu, cv), ab = dot(&a, &b);
    c = x->kappa > 0 ? ap_dd_add(c, ab) : ap_dd_sub(c, ab);
    struct ap_dd s = one_minus(square(c));
    return length_of(x->kappa, c, ap_dd_sqrt(x->kappa > 0 ? s : ap_dd_neg(s)));
}

enum ap_status ap_symbol_lengths(struct ap_error *err, struct ap_symbol symbol, double *edge,
                                 double *inradius) {
    struct simplex x;
    struct ap_dd c, s;
    int kappa;
    enum ap_status st = ap_symbol_space(err, symbol, &kappa);
    if (st)
        return st;
    simplex_of(symbol, kappa, &x);
    radius(&x, &x.face, &c, &s);
    *edge = 2 * between(&x, &x.vertex, &x.edge);
    *inradius = length_of(kappa, c, s);
    return AP_OK;
}

static struct turn reflection(const struct dd3 *n) {
    const struct ap_dd v[3] = {n->x, n->y, n->z};
    struct turn t;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            t.m[i][j] = ap_dd_sub(ap_dd_of(i == j), ap_dd_scale(2, ap_dd_mul(v[i], v[j])));
    return t;
}

static struct turn product(const struct turn *a, const struct turn *b) {
    struct turn t;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            t.m[i][j] = ap_dd_mul(a->m[i][0], b->m[0][j]);
            for (int k = 1; k < 3; k++)
                t.m[i][j] = ap_dd_add(t.m[i][j], ap_dd_mul(a->m[i][k], b->m[k][j]));
        }
    return t;
}

static struct dd3 turned(const struct turn *t, const struct dd3 *v) {
    struct ap_dd out[3];
    for (int i = 0; i < 3; i++)
        out[i] = ap_dd_add(ap_dd_add(ap_dd_mul(t->m[i][0], v->x), ap_dd_mul(t->m[i][1], v->y)),
                           ap_dd_mul(t->m[i][2], v->z));
    return (struct dd3){out[0], out[1], out[2]};
}

static bool same_turn(const struct turn *a, const struct turn *b) {
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            if (fabs(a->m[i][j].hi - b->m[i][j].hi) > 1e-9)
                return false;
    return true;
}

static struct ap_vec3 rounded(const struct dd3 *v) {
    return (struct ap_vec3){v->x.hi, v->y.hi, v->z.hi};
}

// The group that the first three mirrors make, breadth first: [0] is the identity.
static int make_group(const struct simplex *x, struct turn group[AP_CELL_SYMMETRIES],
                      bool reverses[AP_CELL_SYMMETRIES]) {
    struct turn mirror[3];
    int count = 1;
    for (int i = 0; i < 3; i++)
        mirror[i] = reflection(&x->normal[i]);
    memset(&group[0], 0, sizeof group[0]);
    for (int i = 0; i < 3; i++)
        group[0].m[i][i] = ap_dd_of(1);
    reverses[0] = false;
    for (int at = 0; at < count; at++)
        for (int i = 0; i < 3; i++) {
            struct turn next = product(&group[at], &mirror[i]);
            int known = 0;
            while (known < count && !same_turn(&group[known], &next))
                known++;
            if (known < count || count == AP_CELL_SYMMETRIES)
                continue;
            reverses[count] = !reverses[at];
            group[count++] = next;
        }
    return count;
}

static int find(const struct ap_vec3 *points, int count, struct ap_vec3 p) {
    for (int i = 0; i < count; i++)
        if (ap_vec3_length(ap_vec3_sub(points[i], p)) < 1e-9)
            return i;
    return -1;
}

// The orbit of a direction, and a rotation that takes the first to each.
static int orbit(const struct turn *group, const bool *reverses, int order, const struct dd3 *seed,
                 struct ap_vec3 *points, int room, int *turn_to) {
    int count = 0;
    for (int g = 0; g < order; g++) {
        struct dd3 v = turned(&group[g], seed);
        int at = find(points, count, rounded(&v));
        if (!reverses[g] && at < 0 && count < room) {
            turn_to[count] = g;
            points[count++] = rounded(&v);
        }
    }
    return count;
}

static void iso_of(const struct turn *t, struct ap_iso *high, struct ap_iso *low) {
    *high = AP_ISO_IDENTITY;
    *low = (struct ap_iso){0};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            high->m[i][j] = t->m[i][j].hi;
            low->m[i][j] = t->m[i][j].lo;
        }
}

static struct ap_vec3 on_vec(const struct ap_iso *m, struct ap_vec3 v) {
    struct ap_vec4 p = ap_iso_apply(m, (struct ap_vec4){v.x, v.y, v.z, 0});
    return (struct ap_vec3){p.x, p.y, p.z};
}

static void fill_symmetries(struct ap_tiling *t, const struct turn *group, const bool *reverses,
                            const struct ap_vec3 *vertex_out) {
    for (int g = 0; g < t->symmetry_count; g++) {
        struct ap_symmetry *s = &t->symmetry[g];
        iso_of(&group[g], &s->turn, &s->turn_low);
        s->reverses = reverses[g];
        for (int f = 0; f < t->face_count; f++)
            s->face[f] =
                (unsigned char)find(t->face_out, t->face_count, on_vec(&s->turn, t->face_out[f]));
        for (int v = 0; v < t->vertex_count; v++)
            s->vertex[v] =
                (unsigned char)find(vertex_out, t->vertex_count, on_vec(&s->turn, vertex_out[v]));
    }
    for (int g = 0; g < t->symmetry_count; g++)
        for (int h = 0; h < t->symmetry_count; h++) {
            struct turn gh = product(&group[g], &group[h]);
            if (same_turn(&gh, &group[0]))
                t->symmetry[g].inverse = (unsigned char)h;
        }
}

// The rotation of face 0 by one edge, counterclockwise seen from the centre.
static const struct ap_symmetry *face_turn(const struct ap_tiling *t) {
    for (int g = 1; g < t->symmetry_count; g++) {
        const struct ap_symmetry *s = &t->symmetry[g];
        double a = 2 * M_PI / t->symbol.p;
        // About −y by a: x, z plane; from above (the centre) counterclockwise is about +y.
        if (!s->reverses && s->face[0] == 0 && fabs(s->turn.m[0][2] - sin(a)) < 1e-9 &&
            fabs(s->turn.m[0][0] - cos(a)) < 1e-9)
            return s;
    }
    return &t->symmetry[0];
}

static bool face_has(const struct ap_tiling *t, int face, int vertex) {
    for (int k = 0; k < t->symbol.p; k++)
        if (t->face_vertex[face][k] == vertex)
            return true;
    return false;
}

static void fill_faces(struct ap_tiling *t) {
    const struct ap_symmetry *one = face_turn(t);
    int p = t->symbol.p;
    for (int f = 0; f < t->face_count; f++) {
        const struct ap_symmetry *to = &t->symmetry[t->turn_to_face[f]];
        int v = 0; // vertex 0 belongs to face 0
        for (int k = 0; k < p; k++, v = one->vertex[v])
            t->face_vertex[f][k] = to->vertex[v];
    }
    for (int f = 0; f < t->face_count; f++)
        for (int k = 0; k < p; k++)
            for (int g = 0; g < t->face_count; g++)
                if (g != f && face_has(t, g, t->face_vertex[f][k]) &&
                    face_has(t, g, t->face_vertex[f][(k + 1) % p]))
                    t->face_neighbour[f][k] = g;
}

static void fill_edges(struct ap_tiling *t) {
    int p = t->symbol.p;
    for (int e = 0; e < t->edge_count; e++) {
        double best = -2;
        for (int f = 0; f < t->face_count; f++)
            for (int k = 0; k < p; k++) {
                int a = t->face_vertex[f][k], b = t->face_vertex[f][(k + 1) % p];
                struct ap_vec3 m = {t->vertex_m[a].x + t->vertex_m[b].x,
                                    t->vertex_m[a].y + t->vertex_m[b].y,
                                    t->vertex_m[a].z + t->vertex_m[b].z};
                double near = ap_vec3_dot(ap_vec3_normalize(m), t->edge_out[e]);
                if (near <= best + 1e-9)
                    continue;
                best = near;
                t->edge_vertex[e][0] = a;
                t->edge_vertex[e][1] = b;
                t->edge_face[e][0] = f;
                t->edge_face[e][1] = t->face_neighbour[f][k];
            }
    }
}

static void fill_lengths(struct ap_tiling *t, const struct simplex *x, double unit_m) {
    struct ap_dd c, s;
    radius(x, &x->face, &c, &s);
    t->inradius_m = unit_m * length_of(x->kappa, c, s);
    radius(x, &x->edge, &c, &s);
    t->midradius_m = unit_m * length_of(x->kappa, c, s);
    radius(x, &x->vertex, &c, &s);
    t->circumradius_m = unit_m * length_of(x->kappa, c, s);
    t->edge_m = 2 * unit_m * between(x, &x->vertex, &x->edge);
    t->face_circumradius_m = unit_m * between(x, &x->vertex, &x->face);
    t->face_inradius_m = unit_m * between(x, &x->edge, &x->face);
}

// How many cells fill s3: the order of the whole group over that of the cell's. The first is
// 64·h/(12 − p − 2q − r + 4/p + 4/r) with h the order of a product of all four reflections, of
// which cos²(pi/h) is a root of a quadratic equation (Coxeter, Regular Polytopes, 12.3 and 12.8).
static int count_cells(struct ap_symbol s) {
    double p = s.p, q = s.q, r = s.r;
    double a = pow(cos(M_PI / p), 2), b = pow(cos(M_PI / q), 2), c = pow(cos(M_PI / r), 2);
    double sum = a + b + c, root = (sum + sqrt(sum * sum - 4 * a * c)) / 2;
    double h = M_PI / acos(sqrt(root));
    double order = 64 * h / (12 - p - 2 * q - r + 4 / p + 4 / r);
    double cell = 8 * p * q / (2 * p + 2 * q - p * q);
    return (int)lround(order / cell);
}

enum ap_status ap_tiling_init(struct ap_error *err, struct ap_symbol symbol, struct ap_space space,
                              double e3_edge_m, struct ap_tiling *tiling) {
    int kappa;
    enum ap_status st = ap_symbol_space(err, symbol, &kappa);
    if (st)
        return st;
    if (kappa != space.kappa)
        return ap_fail(err, AP_USAGE, "the honeycomb {%d,%d,%d} belongs to %s, not to %s", symbol.p,
                       symbol.q, symbol.r, ap_space_name((struct ap_space){kappa, 1}),
                       ap_space_name(space));
    if (kappa == 0 && !(e3_edge_m > 0 && e3_edge_m < 1e9))
        return ap_fail(err, AP_USAGE, "an edge of %g m: expected a length above 0", e3_edge_m);
    struct simplex x;
    struct turn group[AP_CELL_SYMMETRIES];
    bool reverses[AP_CELL_SYMMETRIES];
    struct ap_vec3 vertex_out[AP_CELL_VERTICES];
    struct ap_dd c, s;
    simplex_of(symbol, kappa, &x);
    memset(tiling, 0, sizeof *tiling);
    struct ap_tiling *t = tiling;
    t->symbol = symbol;
    t->space = space;
    double unit_m = kappa ? space.rho_m : e3_edge_m;
    int order = t->symmetry_count = make_group(&x, group, reverses);
    t->face_count =
        orbit(group, reverses, order, &x.face, t->face_out, AP_CELL_FACES, t->turn_to_face);
    t->edge_count =
        orbit(group, reverses, order, &x.edge, t->edge_out, AP_CELL_EDGES, t->turn_to_edge);
    t->vertex_count =
        orbit(group, reverses, order, &x.vertex, vertex_out, AP_CELL_VERTICES, t->turn_to_vertex);
    t->cell_count = kappa > 0 ? count_cells(symbol) : 0;
    fill_lengths(t, &x, unit_m);
    for (int i = 0; i < 3; i++)
        t->mirror[i] = rounded(&x.normal[i]);
    radius(&x, &x.face, &t->inradius_cos, &t->inradius_sin);
    if (kappa == 0)
        t->inradius_sin = ap_dd_div(ap_dd_scale(unit_m, t->inradius_sin), ap_dd_of(space.rho_m));
    radius(&x, &x.vertex, &c, &s);
    for (int v = 0; v < t->vertex_count; v++) {
        struct ap_vec3 p = ap_vec3_scale(unit_m * s.hi, vertex_out[v]);
        t->vertex_m[v] = (struct ap_vec4){p.x, p.y, p.z, space.rho_m * c.hi};
    }
    fill_symmetries(t, group, reverses, vertex_out);
    fill_faces(t);
    fill_edges(t);
    return AP_OK;
}

double ap_tiling_beyond(const struct ap_tiling *t, struct ap_vec4 p_m, int face) {
    struct ap_vec3 v = {p_m.x, p_m.y, p_m.z};
    double along = ap_vec3_dot(t->face_out[face], v);
    return (t->inradius_cos.hi * along - t->inradius_sin.hi * p_m.w) / t->space.rho_m;
}

void ap_tiling_across(const struct ap_tiling *t, int face, int symmetry, struct ap_iso *high,
                      struct ap_iso *low) {
    // The plane is where f = (out·C, −S) vanishes; its normal is n = (out·C, −kappa·S), and the
    // reflection I − 2·n·f.
    const struct ap_symmetry *to = &t->symmetry[t->turn_to_face[face]];
    const struct ap_symmetry *g = &t->symmetry[symmetry];
    struct ap_dd n[4], f[4];
    for (int i = 0; i < 3; i++) {
        struct ap_dd out = {-to->turn.m[i][1], -to->turn_low.m[i][1]}; // face 0 lies toward −y
        n[i] = f[i] = ap_dd_mul(out, t->inradius_cos);
    }
    f[3] = ap_dd_neg(t->inradius_sin);
    n[3] = ap_dd_scale(t->space.kappa, f[3]);
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            struct ap_dd sum = ap_dd_of(0);
            for (int k = 0; k < 4; k++) {
                struct ap_dd r = ap_dd_sub(ap_dd_of(i == k), ap_dd_scale(2, ap_dd_mul(n[i], f[k])));
                struct ap_dd m = {g->turn.m[k][j], g->turn_low.m[k][j]};
                sum = ap_dd_add(sum, ap_dd_mul(r, m));
            }
            high->m[i][j] = sum.hi;
            low->m[i][j] = sum.lo;
        }
}
