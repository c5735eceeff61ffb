#include "src/geom/cells.h"

#include <stdlib.h>
#include <string.h>

// Centres of cells are at least 0.27 apart in these units, and known to 1e-6 within 20 rho.
static const double grid = 0.05, offset = 0.0137, same = 1e-3, edge_of_grid = 1e-4;
enum { CELLS_LEAST = 256 };

static double unit_of(const struct ap_tiling *t) {
    return t->space.kappa ? 1 : t->inradius_m / t->space.rho_m;
}

static size_t bytes_per_cell(const struct ap_tiling *t) {
    // The hash has twice as many buckets as cells.
    return sizeof(struct ap_cell) + sizeof(int32_t) * ((size_t)t->face_count + 2);
}

static size_t hash(const int64_t key[4]) {
    uint64_t h = 0x9e3779b97f4a7c15u;
    for (int i = 0; i < 4; i++) {
        h ^= (uint64_t)key[i];
        h *= 0xff51afd7ed558ccdu;
        h ^= h >> 32;
    }
    return (size_t)h;
}

// The squares of the grid that a centre may have been put into: two where it is near a line.
static int keys_of(const struct ap_tiling *t, const struct ap_iso *m, int64_t keys[16][4]) {
    double unit = unit_of(t);
    int count = 1;
    for (int i = 0; i < 4; i++) {
        double x = m->m[i][3] / (i == 3 ? 1 : unit) / grid + offset, low = floor(x);
        for (int k = 0; k < count; k++)
            keys[k][i] = (int64_t)low;
        int64_t other = x - low < edge_of_grid       ? (int64_t)low - 1
                        : x - low > 1 - edge_of_grid ? (int64_t)low + 1
                                                     : (int64_t)low;
        if (other == (int64_t)low)
            continue;
        for (int k = 0; k < count; k++) {
            memcpy(keys[count + k], keys[k], sizeof keys[k]);
            keys[count + k][i] = other;
        }
        count *= 2;
    }
    return count;
}

static bool same_centre(const struct ap_tiling *t, const struct ap_iso *a, const struct ap_iso *b) {
    double unit = unit_of(t), far = 0;
    for (int i = 0; i < 4; i++)
        far = fmax(far, fabs(a->m[i][3] - b->m[i][3]) / (i == 3 ? 1 : unit));
    return far < same;
}

static int32_t find(const struct ap_cells *c, const struct ap_iso *m) {
    int64_t keys[16][4];
    int count = keys_of(c->tiling, m, keys);
    for (int k = 0; k < count; k++)
        for (int32_t i = c->bucket[hash(keys[k]) & (c->bucket_count - 1)]; i >= 0;
             i = c->cells[i].next)
            if (same_centre(c->tiling, &c->cells[i].base_from_cell, m))
                return i;
    return -1;
}

static void put(struct ap_cells *c, int32_t cell) {
    int64_t keys[16][4];
    keys_of(c->tiling, &c->cells[cell].base_from_cell, keys);
    int32_t *bucket = &c->bucket[hash(keys[0]) & (c->bucket_count - 1)];
    c->cells[cell].next = *bucket;
    *bucket = cell;
}

// Doubles all tables; false leaves them as they were.
static bool grow(struct ap_cells *c) {
    size_t room = 2 * c->room, faces = (size_t)c->tiling->face_count;
    if (room > c->most)
        room = c->most;
    if (room <= c->count)
        return false;
    struct ap_cell *cells = realloc(c->cells, room * sizeof *cells);
    if (!cells)
        return false;
    c->cells = cells;
    int32_t *neighbour = realloc(c->neighbour, room * faces * sizeof *neighbour);
    if (!neighbour)
        return false;
    c->neighbour = neighbour;
    c->room = room;
    if (c->bucket_count >= room)
        return true;
    int32_t *bucket = malloc(2 * c->bucket_count * sizeof *bucket);
    if (!bucket)
        return true; // only slower
    free(c->bucket);
    c->bucket = bucket;
    c->bucket_count *= 2;
    memset(bucket, -1, c->bucket_count * sizeof *bucket);
    for (size_t i = 0; i < c->count; i++)
        put(c, (int32_t)i);
    return true;
}

static int32_t add(struct ap_cells *c, struct ap_iso base_from_cell, bool reverses) {
    struct ap_space space = c->tiling->space;
    struct ap_vec4 base = {0, 0, 0, space.rho_m};
    double d = ap_vec3_length(ap_log_unchecked(space, ap_iso_apply(&base_from_cell, base), 0));
    if (space.kappa < 0 && d > 20 * space.rho_m)
        return -1;
    if (c->count == c->room && !grow(c))
        return -1;
    int32_t at = (int32_t)c->count++;
    c->cells[at] = (struct ap_cell){base_from_cell, d, reverses, -1};
    memset(&c->neighbour[(size_t)at * (size_t)c->tiling->face_count], -1,
           (size_t)c->tiling->face_count * sizeof *c->neighbour);
    put(c, at);
    return at;
}

enum ap_status ap_cells_create(struct ap_error *err, const struct ap_tiling *tiling,
                               const struct ap_pairing *pairing, size_t budget_bytes,
                               struct ap_cells **out) {
    struct ap_cells *c = calloc(1, sizeof *c);
    if (!c)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory for a tiling");
    c->tiling = tiling;
    c->pairing = pairing;
    c->most = budget_bytes / bytes_per_cell(tiling);
    c->most = c->most < CELLS_LEAST ? CELLS_LEAST : c->most > 100000000 ? 100000000 : c->most;
    c->room = c->bucket_count = CELLS_LEAST;
    c->cells = malloc(c->room * sizeof *c->cells);
    c->neighbour = malloc(c->room * (size_t)tiling->face_count * sizeof *c->neighbour);
    c->bucket = malloc(c->bucket_count * sizeof *c->bucket);
    if (!c->cells || !c->neighbour || !c->bucket) {
        ap_cells_destroy(c);
        return ap_fail(err, AP_ENVIRONMENT, "out of memory for a tiling");
    }
    memset(c->bucket, -1, c->bucket_count * sizeof *c->bucket);
    add(c, AP_ISO_IDENTITY, false);
    *out = c;
    return AP_OK;
}

size_t ap_cells_bytes(const struct ap_cells *cells) {
    return cells->room * bytes_per_cell(cells->tiling);
}

void ap_cells_destroy(struct ap_cells *cells) {
    if (!cells)
        return;
    free(cells->cells);
    free(cells->neighbour);
    free(cells->bucket);
    free(cells);
}

int32_t ap_cells_across(struct ap_cells *c, int32_t cell, int face) {
    size_t slot = (size_t)cell * (size_t)c->tiling->face_count + (size_t)face;
    if (c->neighbour[slot] >= 0)
        return c->neighbour[slot];
    const struct ap_cell *from = &c->cells[cell];
    struct ap_iso there = ap_iso_mul(from->base_from_cell, c->pairing->cell_from_neighbour[face]);
    int32_t at = find(c, &there);
    if (at < 0)
        at = add(c, there, from->reverses != c->pairing->reverses[face]);
    c->neighbour[slot] = at;
    return at;
}

int ap_cells_left_by(const struct ap_tiling *t, struct ap_vec4 at_m) {
    double most = 1e-6 * t->inradius_m / t->space.rho_m;
    int face = -1;
    for (int f = 0; f < t->face_count; f++) {
        double beyond = ap_tiling_beyond(t, at_m, f);
        if (!(beyond > most))
            continue;
        most = beyond;
        face = f;
    }
    return face;
}
