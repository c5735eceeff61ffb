#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "src/geom/cells.h"

struct known {
    struct ap_symbol symbol;
    int kappa, faces, vertices, edges, cells;
};

static const struct known KNOWN[] = {
    {{3, 3, 3}, 1, 4, 4, 6, 5},     {{3, 3, 4}, 1, 4, 4, 6, 16},    {{3, 3, 5}, 1, 4, 4, 6, 600},
    {{3, 4, 3}, 1, 8, 6, 12, 24},   {{4, 3, 3}, 1, 6, 8, 12, 8},    {{5, 3, 3}, 1, 12, 20, 30, 120},
    {{4, 3, 4}, 0, 6, 8, 12, 0},    {{5, 3, 4}, -1, 12, 20, 30, 0}, {{4, 3, 5}, -1, 6, 8, 12, 0},
    {{3, 5, 3}, -1, 20, 12, 30, 0}, {{5, 3, 5}, -1, 12, 20, 30, 0},
};
enum { KNOWN_COUNT = sizeof KNOWN / sizeof *KNOWN };

static struct ap_tiling tiling;
static struct ap_pairing pairing;

static void make(const struct known *k, double rho_m) {
    struct ap_error err = {""};
    if (ap_tiling_init(&err, k->symbol, (struct ap_space){k->kappa, rho_m}, 1.3, &tiling))
        fail_msg("%s", err.text);
    ap_pairing_find(&tiling, &pairing);
}

static void near(const char *what, const struct known *k, double got, double want, double within) {
    if (!(fabs(got - want) <= within))
        fail_msg("{%d,%d,%d} %s: %.17g, expected %.17g within %g", k->symbol.p, k->symbol.q,
                 k->symbol.r, what, got, want, within);
}

// Coxeter's closed forms in long double, which share nothing with the simplex in double-double.
static void lengths_are_coxeters(void **state) {
    (void)state;
    const long double pi = 3.14159265358979323846264338327950288L;
    for (int i = 0; i < KNOWN_COUNT; i++) {
        const struct known *k = &KNOWN[i];
        make(k, 0.7);
        if (k->kappa == 0)
            continue;
        long double p = pi / k->symbol.p, q = pi / k->symbol.q, r = pi / k->symbol.r;
        long double in = cosl(r) * sinl(p) / sqrtl(sinl(p) * sinl(p) - cosl(q) * cosl(q));
        long double half = cosl(p) * sinl(r) / sqrtl(sinl(r) * sinl(r) - cosl(q) * cosl(q));
        long double circum = cosl(p) * cosl(q) * cosl(r) /
                             sqrtl(sinl(p) * sinl(p) - cosl(q) * cosl(q)) /
                             sqrtl(sinl(r) * sinl(r) - cosl(q) * cosl(q));
        long double (*inverse)(long double) = k->kappa > 0 ? acosl : acoshl;
        double want_in = (double)(0.7L * inverse(in)), want_edge = (double)(1.4L * inverse(half));
        double want_circum = (double)(0.7L * inverse(circum));
        near("inradius", k, tiling.inradius_m, want_in, 4e-16 * want_in);
        near("edge", k, tiling.edge_m, want_edge, 4e-16 * want_edge);
        near("circumradius", k, tiling.circumradius_m, want_circum, 4e-16 * want_circum);
    }
}

static void cells_have_their_shape(void **state) {
    (void)state;
    for (int i = 0; i < KNOWN_COUNT; i++) {
        const struct known *k = &KNOWN[i];
        make(k, 1.7);
        near("faces", k, tiling.face_count, k->faces, 0);
        near("vertices", k, tiling.vertex_count, k->vertices, 0);
        near("edges", k, tiling.edge_count, k->edges, 0);
        near("cells", k, tiling.cell_count, k->cells, 0);
        for (int f = 0; f < k->faces; f++)
            for (int j = 0; j < k->symbol.p; j++) {
                struct ap_vec4 v = tiling.vertex_m[tiling.face_vertex[f][j]];
                near("a corner on its face", k, ap_tiling_beyond(&tiling, v, f), 0, 3e-15);
                // The planes of neighbours meet at 2·pi/r.
                struct ap_vec3 a = tiling.face_out[f],
                               b = tiling.face_out[tiling.face_neighbour[f][j]];
                double c = tiling.inradius_cos.hi, s = tiling.inradius_sin.hi;
                double inner = c * c * ap_vec3_dot(a, b) + k->kappa * s * s;
                near("dihedral cosine", k, -inner, cos(2 * M_PI / k->symbol.r), 1e-14);
            }
    }
}

static void steps_are_isometries_that_fit(void **state) {
    (void)state;
    for (int i = 0; i < KNOWN_COUNT; i++) {
        const struct known *k = &KNOWN[i];
        make(k, 1);
        assert_int_equal(pairing.loose, k->symbol.p == 3 && k->symbol.q == 5);
        for (int f = 0; f < k->faces; f++) {
            const struct ap_iso *step = &pairing.cell_from_neighbour[f];
            struct ap_iso back = ap_iso_mul(*step, pairing.cell_from_neighbour[pairing.to[f]]);
            near("defect", k, ap_iso_defect(tiling.space, step), 0, 2e-14);
            for (int r = 0; r < 4; r++)
                for (int c = 0; c < 4; c++)
                    near("there and back", k, back.m[r][c], r == c, 2e-14);
        }
    }
}

// Every way to a cell gives it the same frame, and s3 is full with the number of cells it has.
static void graphs_close(void **state) {
    (void)state;
    for (int i = 0; i < KNOWN_COUNT; i++) {
        const struct known *k = &KNOWN[i];
        struct ap_cells *cells;
        make(k, 1);
        assert_int_equal(ap_cells_create(NULL, &tiling, &pairing, 1 << 20, &cells), AP_OK);
        for (size_t n = 0; n < cells->count && n < 700; n++)
            for (int f = 0; f < k->faces; f++) {
                int32_t m = ap_cells_across(cells, (int32_t)n, f);
                if (m < 0 || pairing.loose)
                    continue;
                struct ap_iso there =
                    ap_iso_mul(cells->cells[n].base_from_cell, pairing.cell_from_neighbour[f]);
                const struct ap_iso *known = &cells->cells[m].base_from_cell;
                double size = 1, off = 0;
                for (int e = 0; e < 16; e++) {
                    size = fmax(size, fabs(known->m[e / 4][e % 4]));
                    off = fmax(off, fabs(known->m[e / 4][e % 4] - there.m[e / 4][e % 4]));
                }
                near("the frame by another way", k, off / size, 0, 2e-14);
            }
        if (k->cells)
            near("cells found", k, (double)cells->count, k->cells, 0);
        else
            assert_true(cells->count > 700); // and no more than the budget holds
        assert_true(cells->count <= cells->most);
        ap_cells_destroy(cells);
    }
}

static void says(enum ap_status st, enum ap_status want, const struct ap_error *err,
                 const char *text) {
    if (st != want || !strstr(err->text, text))
        fail_msg("status %d, \"%s\"; expected %d and \"%s\"", st, err->text, want, text);
}

static void what_does_not_exist_says_so(void **state) {
    (void)state;
    struct ap_error err = {""};
    int kappa;
    says(ap_symbol_space(&err, (struct ap_symbol){6, 3, 3}, &kappa), AP_INPUT, &err, "flat planes");
    says(ap_symbol_space(&err, (struct ap_symbol){7, 3, 3}, &kappa), AP_INPUT, &err, "hyperbolic");
    says(ap_symbol_space(&err, (struct ap_symbol){3, 3, 6}, &kappa), AP_INPUT, &err, "at infinity");
    says(ap_symbol_space(&err, (struct ap_symbol){5, 3, 7}, &kappa), AP_INPUT, &err, "beyond");
    says(ap_symbol_space(&err, (struct ap_symbol){5, 3, 2}, &kappa), AP_INPUT, &err, "from 3");
    struct ap_tiling t;
    says(ap_tiling_init(&err, (struct ap_symbol){5, 3, 4}, (struct ap_space){0, 1}, 1, &t),
         AP_USAGE, &err, "belongs to h3, not to e3");
}

static void pairings_are_checked(void **state) {
    (void)state;
    struct ap_error err = {""};
    struct ap_pairing p;
    int at;
    assert_int_equal(
        ap_tiling_init(&err, (struct ap_symbol){5, 3, 3}, (struct ap_space){1, 1}, 1, &tiling), 0);
    assert_int_equal(ap_pairing_opposite(&err, &tiling, M_PI / 5, &p), AP_OK);
    says(ap_pairing_opposite(&err, &tiling, 3 * M_PI / 5, &p), AP_INPUT, &err, "round its edge");
    says(ap_pairing_mirrors(&err, &tiling, &p), AP_INPUT, &err, "face 0");
    assert_int_equal(
        ap_tiling_init(&err, (struct ap_symbol){4, 3, 4}, (struct ap_space){0, 1}, 1, &tiling), 0);
    assert_int_equal(ap_pairing_opposite(&err, &tiling, 0, &p), AP_OK);
    // The same torus by hand, found by trying the turns; then broken in four ways.
    struct ap_face_pair pairs[3];
    int count = 0;
    for (int f = 0; f < 6; f++)
        for (int turn = 0; p.to[f] > f && turn < 4; turn++) {
            int v = tiling.face_vertex[f][0], w = tiling.face_vertex[p.to[f]][turn];
            struct ap_vec4 a = tiling.vertex_m[v], b = tiling.vertex_m[w];
            struct ap_vec3 d = {a.x - b.x, a.y - b.y, a.z - b.z};
            if (fabs(ap_vec3_length(d) - tiling.edge_m) < 1e-9) // straight across
                pairs[count++] = (struct ap_face_pair){f, p.to[f], turn, false};
        }
    assert_int_equal(count, 3);
    struct ap_pairing q;
    if (ap_pairing_from_faces(&err, &tiling, pairs, 3, &at, &q))
        fail_msg("%s", err.text);
    assert_memory_equal(q.turn, p.turn, 6);
    says(ap_pairing_from_faces(&err, &tiling, pairs, 2, &at, &q), AP_INPUT, &err, "is not paired");
    struct ap_face_pair bad[3] = {pairs[0], pairs[1], pairs[1]};
    says(ap_pairing_from_faces(&err, &tiling, bad, 3, &at, &q), AP_INPUT, &err, "paired already");
    assert_int_equal(at, 2);
    bad[2] = (struct ap_face_pair){pairs[2].face, 6, 0, false};
    says(ap_pairing_from_faces(&err, &tiling, bad, 3, &at, &q), AP_INPUT, &err, "no face 6");
    bad[2] = pairs[2];
    bad[2].mirrored = true;
    bad[1].turn++;
    says(ap_pairing_from_faces(&err, &tiling, bad, 3, &at, &q), AP_INPUT, &err, "round its edge");
}

// Files of face pairings rely on it, and docs/honeycombs.md tells it.
static void faces_are_numbered_as_documented(void **state) {
    (void)state;
    static const int cube[6][5] = {{2, 4, 3, 1}, {3, 5, 2, 0}, {1, 5, 4, 0},
                                   {4, 5, 1, 0}, {2, 5, 3, 0}, {3, 4, 2, 1}};
    static const int dodecahedron[12][5] = {{2, 4, 5, 3, 1},   {3, 6, 7, 2, 0},  {1, 7, 9, 4, 0},
                                            {5, 8, 6, 1, 0},   {2, 9, 10, 5, 0}, {4, 10, 8, 3, 0},
                                            {3, 8, 11, 7, 1},  {1, 6, 11, 9, 2}, {5, 10, 11, 6, 3},
                                            {2, 7, 11, 10, 4}, {4, 9, 11, 8, 5}, {6, 8, 10, 9, 7}};
    static const struct ap_symbol symbols[] = {{4, 3, 3}, {4, 3, 4}, {4, 3, 5},
                                               {5, 3, 3}, {5, 3, 4}, {5, 3, 5}};
    for (size_t i = 0; i < sizeof symbols / sizeof *symbols; i++) {
        struct ap_tiling t;
        int kappa, p = symbols[i].p;
        assert_int_equal(ap_symbol_space(NULL, symbols[i], &kappa), AP_OK);
        struct ap_space space = {kappa, 1};
        assert_int_equal(ap_tiling_init(NULL, symbols[i], space, 2, &t), AP_OK);
        assert_int_equal(t.face_count, p == 4 ? 6 : 12);
        for (int f = 0; f < t.face_count; f++)
            for (int k = 0; k < p; k++)
                assert_int_equal(t.face_neighbour[f][k], (p == 4 ? cube : dodecahedron)[f][k]);
        assert_true(t.face_out[0].y < -0.999 && t.face_out[t.face_count - 1].y > 0.999);
        assert_true(t.face_out[1].z > 0.8 && t.face_out[2].x > 0.8);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lengths_are_coxeters),
        cmocka_unit_test(cells_have_their_shape),
        cmocka_unit_test(steps_are_isometries_that_fit),
        cmocka_unit_test(graphs_close),
        cmocka_unit_test(what_does_not_exist_says_so),
        cmocka_unit_test(pairings_are_checked),
        cmocka_unit_test(faces_are_numbered_as_documented),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
