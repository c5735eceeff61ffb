// Models that are larger than their budget: what is left of a sphere is one still.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "src/scene/mesh.h"
#include "src/scene/simplify.h"

static struct ap_solid sphere(void) {
    struct ap_mesh mesh = {.sagitta_m = 1e-6};
    ap_mesh_ellipsoid(&mesh, (struct ap_pose){{0.3, -0.2, 5}, {0, 0, 0, 1}},
                      (struct ap_vec3){1, 1, 1});
    assert_false(mesh.out_of_memory);
    return mesh.solid;
}

static void finish(struct ap_solid *s) {
    free(s->positions);
    free(s->normals);
    free(s->indices);
}

// The volume that the triangles enclose, and the worst of the vertices and normals.
static double measure(const struct ap_solid *s, double *off_sphere, double *off_normal) {
    double volume = 0;
    const struct ap_vec3 middle = {0.3, -0.2, 5};
    struct ap_vec3 corner[3];
    *off_sphere = *off_normal = 0;
    for (size_t k = 0; k < s->index_count; k++) {
        assert_true(s->indices[k] < s->vertex_count);
        const float *p = s->positions + 3 * (size_t)s->indices[k],
                    *n = s->normals + 3 * (size_t)s->indices[k];
        struct ap_vec3 at = ap_vec3_sub((struct ap_vec3){p[0], p[1], p[2]}, middle);
        struct ap_vec3 out = {n[0], n[1], n[2]};
        *off_sphere = fmax(*off_sphere, fabs(ap_vec3_length(at) - 1));
        *off_normal = fmax(*off_normal, 1 - ap_vec3_dot(out, at) / ap_vec3_length(at));
        corner[k % 3] = at;
        if (k % 3 == 2)
            volume += ap_vec3_dot(corner[0], ap_vec3_cross(corner[1], corner[2])) / 6;
    }
    return volume;
}

static void stays_a_sphere(void **state) {
    (void)state;
    struct ap_solid s = sphere();
    size_t whole = ap_solid_bytes(&s);
    double off, normal, before = measure(&s, &off, &normal);
    for (size_t most = whole; most > 6000; most = most * 2 / 3) {
        struct ap_solid less = sphere();
        assert_true(ap_solid_simplify(&less, most));
        double volume = measure(&less, &off, &normal);
        printf("%zu bytes of %zu allowed: %zu triangles, volume %.3f of %.3f, off the sphere by "
               "%.1e, normals by %.3f\n",
               ap_solid_bytes(&less), most, less.index_count / 3, volume / before, 1.0, off,
               normal);
        assert_true(ap_solid_bytes(&less) <= most);
        assert_true(ap_solid_bytes(&less) > most / 4);
        assert_true(volume > 0.6 * before && volume < 1.2 * before);
        assert_true(off < 1e-6);    // vertices that were there
        assert_true(normal < 0.15); // 32 degrees
        finish(&less);
    }
    finish(&s);
}

// Whatever the budget: something is left, and what is flat, one point or nothing at all goes well.
static void something_is_left(void **state) {
    (void)state;
    for (size_t most = 0; most < 2000; most += 97) {
        struct ap_solid s = sphere();
        assert_true(ap_solid_simplify(&s, most));
        assert_true(s.index_count >= 3 && s.index_count % 3 == 0);
        double off, normal;
        measure(&s, &off, &normal);
        finish(&s);
    }
    float same[9] = {1, 2, 3, 1, 2, 3, 1, 2, 3}, normals[9] = {0};
    for (int flat = 0; flat < 2; flat++) {
        struct ap_solid s = {.vertex_count = 3, .index_count = 3};
        s.positions = malloc(sizeof same);
        s.normals = malloc(sizeof normals);
        s.indices = malloc(3 * sizeof *s.indices);
        assert_non_null(s.positions && s.normals && s.indices ? s.indices : NULL);
        memcpy(s.positions, same, sizeof same);
        memcpy(s.normals, normals, sizeof normals);
        for (unsigned i = 0; i < 3; i++)
            s.indices[i] = i;
        s.positions[3] += (float)flat;
        s.positions[8] += (float)flat;
        assert_true(ap_solid_simplify(&s, 10));
        assert_int_equal(s.index_count, 3);
        finish(&s);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(stays_a_sphere),
                                       cmocka_unit_test(something_is_left)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
