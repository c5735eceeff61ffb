#include "src/scene/simplify.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "src/geom/vec.h"

enum {
    VERTEX_BYTES = 24 + 3 * 32, // a scene's; a renderer's, before, on the way and on the GPU
    INDEX_BYTES = 4 + 3 * 4
};
static const double FINEST = 1 << 20; // cubes to a side

size_t ap_solid_bytes(const struct ap_solid *solid) {
    return solid->vertex_count * VERTEX_BYTES + solid->index_count * INDEX_BYTES;
}

// Which vertices are one: by an open table of cubes, of which each entry is a cube's first vertex.
struct clusters {
    const struct ap_solid *solid;
    double low[3], extent;
    uint32_t *of_vertex, *table;
    size_t table_size; // a power of two
    size_t count;      // of cubes
    size_t index_count;
};

static void cube_of(const struct clusters *c, double fineness, size_t vertex, uint32_t cube[3]) {
    for (size_t i = 0; i < 3; i++) {
        double at = (c->solid->positions[3 * vertex + i] - c->low[i]) / c->extent;
        cube[i] = (uint32_t)fmin(fmax(at * fineness, 0), fineness - 1);
    }
}

// The first vertex that lies in the same cube.
static uint32_t first_in_cube(struct clusters *c, double fineness, size_t vertex) {
    uint32_t cube[3], other[3];
    cube_of(c, fineness, vertex, cube);
    uint64_t hash = cube[0] * UINT64_C(0x9e3779b97f4a7c15) ^
                    cube[1] * UINT64_C(0xc2b2ae3d27d4eb4f) ^ cube[2] * UINT64_C(0x165667b19e3779f9);
    for (size_t at = (hash ^ hash >> 29) & (c->table_size - 1);;
         at = (at + 1) & (c->table_size - 1)) {
        if (c->table[at] == UINT32_MAX) {
            c->table[at] = (uint32_t)vertex;
            c->count++;
            return (uint32_t)vertex;
        }
        cube_of(c, fineness, c->table[at], other);
        if (memcmp(cube, other, sizeof cube) == 0)
            return c->table[at];
    }
}

static bool is_left(const struct clusters *c, const unsigned *corner) {
    uint32_t a = c->of_vertex[corner[0]], b = c->of_vertex[corner[1]], d = c->of_vertex[corner[2]];
    return a != b && b != d && d != a;
}

static size_t join(struct clusters *c, double fineness) {
    const struct ap_solid *s = c->solid;
    memset(c->table, 0xff, c->table_size * sizeof *c->table);
    c->count = c->index_count = 0;
    for (size_t v = 0; v < s->vertex_count; v++)
        c->of_vertex[v] = first_in_cube(c, fineness, v);
    for (size_t k = 0; k < s->index_count; k += 3)
        c->index_count += is_left(c, s->indices + k) ? 3 : 0;
    return c->count * VERTEX_BYTES + c->index_count * INDEX_BYTES;
}

static void measure(struct clusters *c) {
    const struct ap_solid *s = c->solid;
    double high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t i = 0; i < 3; i++)
        c->low[i] = INFINITY;
    for (size_t k = 0; k < 3 * s->vertex_count; k++) {
        c->low[k % 3] = fmin(c->low[k % 3], s->positions[k]);
        high[k % 3] = fmax(high[k % 3], s->positions[k]);
    }
    c->extent = 1e-12;
    for (size_t i = 0; i < 3; i++)
        c->extent = fmax(c->extent, high[i] - c->low[i]);
}

// The finest grid that is found to leave so much, or one that leaves a triangle. Vertices go by the
// square of the fineness.
static void choose_grid(struct clusters *c, size_t most_bytes) {
    enum { TRIES = 40 };
    double fineness = fmin(fmax(2 * sqrt((double)most_bytes / VERTEX_BYTES), 2), FINEST), last = 0;
    size_t bytes = join(c, fineness);
    for (int i = 0; i < TRIES && bytes > most_bytes && c->index_count > 0 && fineness > 1; i++) {
        last = fineness;
        double next = floor(0.97 * fineness * sqrt((double)most_bytes / (double)bytes));
        fineness = fmax(fmin(next, fineness - 1), 1);
        bytes = join(c, fineness);
    }
    while (c->index_count == 0 && fineness < FINEST) { // too coarse: up again, slowly
        fineness =
            last > fineness + 1 && fineness * 1.2 < last ? ceil(fineness * 1.2) + 1 : fineness * 2;
        join(c, fineness);
    }
}

// Vertices and triangles that are left, in their old order.
static void keep(struct clusters *c, struct ap_solid *s) {
    for (size_t v = 0; v < s->vertex_count; v++)
        for (size_t i = 0; c->of_vertex[v] != v && i < 3; i++)
            s->normals[3 * (size_t)c->of_vertex[v] + i] += s->normals[3 * v + i];
    size_t indices = 0, vertices = 0;
    for (size_t k = 0; k < s->index_count; k += 3)
        if (is_left(c, s->indices + k))
            for (size_t i = 0; i < 3; i++)
                s->indices[indices++] = c->of_vertex[s->indices[k + i]];
    // From here on the new number of each vertex that is kept.
    for (size_t v = 0; v < s->vertex_count; v++) {
        if (c->of_vertex[v] != v)
            continue;
        const float *n = s->normals + 3 * v;
        struct ap_vec3 sum = {n[0], n[1], n[2]};
        double length = ap_vec3_length(sum);
        sum = length > 1e-6 ? ap_vec3_scale(1 / length, sum) : (struct ap_vec3){0, 1, 0};
        memmove(s->positions + 3 * vertices, s->positions + 3 * v, 3 * sizeof *s->positions);
        s->normals[3 * vertices] = (float)sum.x;
        s->normals[3 * vertices + 1] = (float)sum.y;
        s->normals[3 * vertices + 2] = (float)sum.z;
        c->of_vertex[v] = (uint32_t)vertices++;
    }
    for (size_t k = 0; k < indices; k++)
        s->indices[k] = c->of_vertex[s->indices[k]];
    s->vertex_count = vertices;
    s->index_count = indices;
}

static void give_back(void **items, size_t size) {
    void *less = realloc(*items, size + 1);
    *items = less ? less : *items;
}

bool ap_solid_simplify(struct ap_solid *solid, size_t most_bytes) {
    if (ap_solid_bytes(solid) <= most_bytes || solid->vertex_count >= UINT32_MAX / 4)
        return true;
    struct clusters c = {.solid = solid, .table_size = 1024};
    while (c.table_size < 2 * solid->vertex_count)
        c.table_size *= 2;
    c.of_vertex = malloc((solid->vertex_count + 1) * sizeof *c.of_vertex);
    c.table = malloc(c.table_size * sizeof *c.table);
    bool good = c.of_vertex && c.table;
    if (good) {
        measure(&c);
        choose_grid(&c, most_bytes);
        if (c.index_count > 0)
            keep(&c, solid);
        give_back((void **)&solid->positions, 3 * solid->vertex_count * sizeof *solid->positions);
        give_back((void **)&solid->normals, 3 * solid->vertex_count * sizeof *solid->normals);
        give_back((void **)&solid->indices, solid->index_count * sizeof *solid->indices);
    }
    free(c.of_vertex);
    free(c.table);
    return good;
}
