#include "src/geom/pairing.h"

#include <stdlib.h>
#include <string.h>

enum { UNSET = 255, CYCLE_MAX = 1000, TRIES_MAX = 20000, MIRRORED = 100 };

// What is chosen so far: as in ap_pairing.
struct glue {
    unsigned char turn[AP_CELL_FACES], to[AP_CELL_FACES];
};

// A way to go on from a face.
struct candidate {
    double score; // how far from a translation: radians; mirrored ones after all others
    unsigned char turn, to;
};

// How far the step across `face` with this symmetry turns beside a translation along its normal.
static double twist_of(const struct ap_tiling *t, int face, const struct ap_symmetry *g) {
    // Reflection in the parallel plane through the centre, times g, is the turn.
    struct ap_vec3 u = t->face_out[face];
    const double n[3] = {u.x, u.y, u.z};
    double trace = 0, skew[3] = {0}, m[3][3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            m[i][j] = 0;
            for (int k = 0; k < 3; k++)
                m[i][j] += ((i == k) - 2 * n[i] * n[k]) * g->turn.m[k][j];
        }
    for (int i = 0; i < 3; i++) {
        trace += m[i][i];
        skew[i] = m[(i + 2) % 3][(i + 1) % 3] - m[(i + 1) % 3][(i + 2) % 3];
    }
    double angle = acos(fmax(-1, fmin(1, (trace - 1) / 2)));
    double along = skew[0] * n[0] + skew[1] * n[1] + skew[2] * n[2];
    // Seen from the cell, counterclockwise about the way out is clockwise.
    return along > 1e-9 ? -angle : angle;
}

static int face_of(const struct ap_tiling *t, int face, int g) {
    return t->symmetry[t->symmetry[g].inverse].face[face];
}

static void set_face(const struct ap_tiling *t, int face, int g, struct glue *p) {
    int to = face_of(t, face, g);
    p->turn[face] = (unsigned char)g;
    p->to[face] = (unsigned char)to;
    p->turn[to] = t->symmetry[g].inverse;
    p->to[to] = (unsigned char)face;
}

// Round the edge between faces f and f2, from corner v of it: how many cells until one is back
// where one was. 0: a face on the way is not paired yet.
static int cycle(const struct ap_tiling *t, const struct glue *p, int f, int f2, int v) {
    const int start[3] = {f, f2, v};
    for (int n = 1; n < CYCLE_MAX; n++) {
        if (p->turn[f] == UNSET)
            return 0;
        const struct ap_symmetry *back = &t->symmetry[t->symmetry[p->turn[f]].inverse];
        int from = back->face[f], next = back->face[f2];
        v = back->vertex[v];
        f = next; // the other face at this edge in the neighbour's frame
        f2 = from;
        if (f == start[0] && f2 == start[1] && v == start[2])
            return n;
    }
    return CYCLE_MAX;
}

// The first edge whose cycle is known and does not close; false where all do.
static bool open_edge(const struct ap_tiling *t, const struct glue *p, int *face, int *other,
                      int *length) {
    for (int f = 0; f < t->face_count; f++)
        for (int k = 0; k < t->symbol.p; k++) {
            int f2 = t->face_neighbour[f][k];
            int n = cycle(t, p, f, f2, t->face_vertex[f][k]);
            if (n == 0 || t->symbol.r % n == 0)
                continue;
            *face = f;
            *other = f2;
            *length = n;
            return true;
        }
    return false;
}

static bool fits(const struct ap_tiling *t, const struct glue *p) {
    int face, other, length;
    return !open_edge(t, p, &face, &other, &length);
}

static void finish(const struct ap_tiling *t, const struct glue *p, struct ap_pairing *out) {
    memset(out, 0, sizeof *out);
    for (int f = 0; f < t->face_count; f++) {
        const struct ap_symmetry *g = &t->symmetry[p->turn[f]];
        out->turn[f] = p->turn[f];
        out->to[f] = p->to[f];
        ap_tiling_across(t, f, p->turn[f], &out->cell_from_neighbour[f], &out->low[f]);
        out->reverses[f] = !g->reverses;
    }
}

static void clear(struct glue *p) {
    memset(p, UNSET, sizeof *p);
}

static int by_score(const void *a, const void *b) {
    const struct candidate *c = a, *d = b;
    if (c->score != d->score)
        return c->score < d->score ? -1 : 1;
    return (int)c->turn - (int)d->turn;
}

static int candidates(const struct ap_tiling *t, int face, struct candidate *list) {
    for (int g = 0; g < t->symmetry_count; g++) {
        double twist = twist_of(t, face, &t->symmetry[g]);
        // Rounded, so that the order does not hang on the last digit; to the left before right.
        double score = round(fabs(twist) * 1e6) * 1e-6 + (twist < 0 ? 1e-7 : 0);
        list[g] = (struct candidate){score + (t->symmetry[g].reverses ? 0 : MIRRORED),
                                     (unsigned char)g, (unsigned char)face_of(t, face, g)};
    }
    qsort(list, (size_t)t->symmetry_count, sizeof *list, by_score);
    return t->symmetry_count;
}

static bool may_pair(const struct ap_tiling *t, const struct glue *p, int face,
                     const struct candidate *c) {
    bool own_inverse = t->symmetry[c->turn].inverse == c->turn;
    return p->turn[c->to] == UNSET && (c->to != face || own_inverse);
}

struct flag {
    int face, other, corner;
};

// The unpaired face at which the longest of the open cycles stops, and where that cycle begins:
// there the next choice is tested soonest. −1: all are paired.
static int most_bound(const struct ap_tiling *t, const struct glue *p, struct flag *begin) {
    int best = -1, longest = -1;
    for (int f = 0; f < t->face_count; f++)
        for (int k = 0; k < t->symbol.p; k++) {
            int at = f, n = 0, f2 = t->face_neighbour[f][k];
            for (; p->turn[at] != UNSET && n <= t->symbol.r; n++) {
                const struct ap_symmetry *back = &t->symmetry[t->symmetry[p->turn[at]].inverse];
                int from = back->face[at];
                at = back->face[f2];
                f2 = from;
            }
            if (n <= longest || p->turn[at] != UNSET)
                continue;
            longest = n;
            best = at;
            *begin = (struct flag){f, t->face_neighbour[f][k], t->face_vertex[f][k]};
        }
    return best;
}

static bool search(const struct ap_tiling *t, struct candidate list[][AP_CELL_SYMMETRIES],
                   struct glue *p, long *tries) {
    struct flag flag;
    int face = most_bound(t, p, &flag);
    if (face < 0)
        return true;
    for (int i = 0; i < t->symmetry_count; i++) {
        const struct candidate *c = &list[face][i];
        if (!may_pair(t, p, face, c))
            continue;
        struct glue next = *p;
        set_face(t, face, c->turn, &next);
        int n = cycle(t, &next, flag.face, flag.other, flag.corner);
        if (n > 0 && t->symbol.r % n != 0)
            continue;
        if (--*tries < 0)
            return false;
        if (fits(t, &next) && search(t, list, &next, tries)) {
            *p = next;
            return true;
        }
    }
    return false;
}

// The same step across every face, as far as handedness and score go.
static bool uniform(const struct ap_tiling *t, double score, struct glue *p) {
    clear(p);
    for (int f = 0; f < t->face_count; f++) {
        struct candidate list[AP_CELL_SYMMETRIES];
        int count = p->turn[f] == UNSET ? candidates(t, f, list) : 0, i = 0;
        while (i < count && !(fabs(list[i].score - score) < 5e-8 && may_pair(t, p, f, &list[i])))
            i++;
        if (count > 0 && i == count)
            return false;
        if (count > 0)
            set_face(t, f, list[i].turn, p);
    }
    return fits(t, p);
}

static enum ap_status check_edges(struct ap_error *err, const struct ap_tiling *t,
                                  const struct glue *p) {
    int face, other, length;
    if (!open_edge(t, p, &face, &other, &length))
        return AP_OK;
    int r = t->symbol.r;
    return ap_fail(err, AP_INPUT,
                   "face %d: round its edge with face %d one is back after %d cells, %g degrees of "
                   "this space; expected %d cells (or a divisor), 360 degrees",
                   face, other, length, 360.0 * length / r, r);
}

enum ap_status ap_pairing_opposite(struct ap_error *err, const struct ap_tiling *t,
                                   double twist_rad, struct ap_pairing *pairing) {
    struct glue p;
    clear(&p);
    for (int f = 0; f < t->face_count; f++) {
        int g = 0;
        for (; g < t->symmetry_count; g++) {
            const struct ap_symmetry *s = &t->symmetry[g];
            struct ap_vec3 a = t->face_out[f], b = t->face_out[face_of(t, f, g)];
            if (s->reverses && ap_vec3_dot(a, b) < -1 + 1e-9 &&
                fabs(twist_of(t, f, s) - twist_rad) < 1e-6)
                break;
        }
        if (g == t->symmetry_count)
            return ap_fail(err, AP_INPUT,
                           "face %d of {%d,%d,%d} has no opposite that fits after a turn by %g rad",
                           f, t->symbol.p, t->symbol.q, t->symbol.r, twist_rad);
        if (p.turn[f] == UNSET)
            set_face(t, f, g, &p);
    }
    enum ap_status st = check_edges(err, t, &p);
    if (st)
        return st;
    finish(t, &p, pairing);
    return AP_OK;
}

enum ap_status ap_pairing_mirrors(struct ap_error *err, const struct ap_tiling *t,
                                  struct ap_pairing *pairing) {
    struct glue p;
    clear(&p);
    for (int f = 0; f < t->face_count; f++)
        set_face(t, f, 0, &p);
    enum ap_status st = check_edges(err, t, &p);
    if (st)
        return st;
    finish(t, &p, pairing);
    return AP_OK;
}

// The symmetry that takes the corners of `to` onto those of `face` as the pair says.
static int turn_of_pair(const struct ap_tiling *t, const struct ap_face_pair *pair) {
    int p = t->symbol.p;
    for (int g = 0; g < t->symmetry_count; g++) {
        const struct ap_symmetry *back = &t->symmetry[t->symmetry[g].inverse];
        bool same = true;
        for (int k = 0; k < p && same; k++) {
            int m = ((pair->turn + (pair->mirrored ? k : -k)) % p + p) % p;
            same = back->vertex[t->face_vertex[pair->face][k]] == t->face_vertex[pair->to][m];
        }
        if (same && back->face[pair->face] == pair->to)
            return g;
    }
    return -1;
}

static enum ap_status add_pair(struct ap_error *err, const struct ap_tiling *t,
                               const struct ap_face_pair *pair, struct glue *p) {
    const int named[2] = {pair->face, pair->to};
    for (int i = 0; i < 2; i++) {
        if (named[i] < 0 || named[i] >= t->face_count)
            return ap_fail(err, AP_INPUT, "there is no face %d: this cell has faces 0 to %d",
                           named[i], t->face_count - 1);
        if (p->turn[named[i]] != UNSET)
            return ap_fail(err, AP_INPUT, "face %d is paired already, with face %d", named[i],
                           p->to[named[i]]);
    }
    int g = turn_of_pair(t, pair);
    if (g < 0)
        return ap_fail(err, AP_INPUT, "no symmetry of the cell takes face %d to face %d so",
                       pair->face, pair->to);
    if (pair->face == pair->to && t->symmetry[g].inverse != g)
        return ap_fail(err, AP_INPUT,
                       "face %d is paired with itself, but not so that twice is the identity",
                       pair->face);
    set_face(t, pair->face, g, p);
    return AP_OK;
}

enum ap_status ap_pairing_from_faces(struct ap_error *err, const struct ap_tiling *t,
                                     const struct ap_face_pair *pairs, int count, int *at,
                                     struct ap_pairing *pairing) {
    struct glue p;
    clear(&p);
    for (int i = 0; i < count; i++) {
        *at = i;
        enum ap_status st = add_pair(err, t, &pairs[i], &p);
        if (st)
            return st;
    }
    *at = -1;
    for (int f = 0; f < t->face_count; f++)
        if (p.turn[f] == UNSET)
            return ap_fail(err, AP_INPUT, "face %d is not paired", f);
    enum ap_status st = check_edges(err, t, &p);
    if (st)
        return st;
    finish(t, &p, pairing);
    return AP_OK;
}

// Beside a translation as little as can be, at each face for itself.
static void loose(const struct ap_tiling *t, struct glue *p) {
    clear(p);
    for (int f = 0; f < t->face_count; f++) {
        struct candidate list[AP_CELL_SYMMETRIES];
        int count = p->turn[f] == UNSET ? candidates(t, f, list) : 0, i = 0;
        while (i < count && !may_pair(t, p, f, &list[i]))
            i++;
        if (i < count)
            set_face(t, f, list[i].turn, p);
    }
}

void ap_pairing_find(const struct ap_tiling *t, struct ap_pairing *pairing) {
    struct candidate list[AP_CELL_SYMMETRIES];
    struct glue p;
    int count = candidates(t, 0, list);
    bool found = false;
    for (int i = 0; i < count && !found && list[i].score < MIRRORED; i++)
        found = uniform(t, list[i].score, &p);
    if (!found && ap_pairing_mirrors(NULL, t, pairing) == AP_OK)
        return;
    if (!found) {
        struct candidate all[AP_CELL_FACES][AP_CELL_SYMMETRIES];
        long tries = TRIES_MAX;
        for (int f = 0; f < t->face_count; f++)
            candidates(t, f, all[f]);
        clear(&p);
        found = search(t, all, &p, &tries);
    }
    if (!found)
        loose(t, &p);
    finish(t, &p, pairing);
    pairing->loose = !found;
}
