#include "src/render/mesh/meshes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/geom/map.h"
#include "src/geom/table.h"
#include "src/render/mesh/budget.h"

static const double PI = 3.14159265358979323846;
static const int BALL_STEPS[] = {1, 2, 3, 4, 5, 6, 8, 11, 16, 24, 40, 64};
static const int STICK_AROUND[] = {5, 6, 8, 12, 16, 24, 32, 64};
static const int POLYGON_DIVISION[] = {1, 2, 4, 8, 16, 32, 64};
static const int POLYGON_TRIANGLES_MAX = 20480; // a level with more is left out

// Whether two parts can share their meshes.
static bool same_shape(const struct ap_part *a, const struct ap_part *b) {
    if (a->kind != b->kind)
        return false;
    switch (a->kind) {
    case AP_PART_BALL:
        return true;
    case AP_PART_STICK:
        return a->radius_m == b->radius_m && a->radius2_m == b->radius2_m &&
               a->length_m == b->length_m;
    case AP_PART_POLYGON:
        return a->sides == b->sides && a->edge_m == b->edge_m;
    case AP_PART_SOLID:
        return a->solid == b->solid;
    }
    return false;
}

static enum ap_status add_polygon(struct ap_error *err, struct ap_space space,
                                  const struct ap_part *part, struct ap_mesh_data *data,
                                  struct ap_shape *shape) {
    double circum, in;
    enum ap_status st = ap_regular_polygon(err, space, part->sides, part->edge_m, &circum, &in);
    for (size_t i = 0; st == AP_OK && i < sizeof POLYGON_DIVISION / sizeof *POLYGON_DIVISION; i++) {
        int n = POLYGON_DIVISION[i], k = shape->levels;
        if (k > 0 && part->sides * n * n > POLYGON_TRIANGLES_MAX)
            break;
        st = ap_mesh_polygon(err, space, part->sides, part->edge_m, n, data, &shape->mesh[k]);
        // Steps are even in the chord, so in curved space some are longer than others.
        shape->grain[k] = 1.3 * fmax(circum, part->edge_m) / n;
        shape->levels++;
    }
    return st;
}

// Where a piece of a cell faces, by the corners of its coarsest mesh.
static void find_facing(const struct ap_part *part, const struct ap_solid *solid,
                        struct ap_shape *shape) {
    if (!part->one_sided || part->form == AP_FORM_FACETS)
        return;
    if (part->form == AP_FORM_PLANE) {
        shape->out[shape->out_count++] = (struct ap_vec3){0, 1, 0};
        return;
    }
    for (size_t i = 0; i < solid->vertex_count; i++) {
        const float *p = solid->positions + 3 * i;
        struct ap_vec3 v = {part->form == AP_FORM_TUBE ? 0 : p[0], p[1], p[2]};
        v = ap_vec3_normalize(v);
        bool known = false;
        for (int k = 0; k < shape->out_count; k++)
            known = known || ap_vec3_dot(v, shape->out[k]) > 1 - 1e-9;
        if (known)
            continue;
        if (shape->out_count == AP_OUT_MAX) {
            shape->out_count = 0;
            return;
        }
        shape->out[shape->out_count++] = v;
    }
}

// Drops the levels of more than `most` triangles, but the coarsest; they are the last.
static void drop_large(size_t most, struct ap_mesh_data *data, struct ap_shape *shape) {
    while (shape->levels > 1 && shape->mesh[shape->levels - 1].index_count / 3 > most) {
        const struct ap_mesh *last = &shape->mesh[--shape->levels];
        data->vertex_count = last->first_vertex;
        data->index_count = last->first_index;
    }
}

// Point `at` (0…pieces) of a solid's seam, on the space.
static struct ap_vec4 seam_point(struct ap_space space, const struct ap_solid *solid, int seam,
                                 int at) {
    unsigned v = solid->seams[seam * (solid->seam_pieces + 1) + at];
    const float *p = solid->positions + 3 * v;
    return ap_exp(space, (struct ap_vec3){p[0], p[1], p[2]});
}

static enum ap_status seam_of(struct ap_error *err, struct ap_space space,
                              const struct ap_part *part, const struct ap_solid *solid,
                              const struct ap_solid *finest, int k, struct ap_seam *seam) {
    struct ap_vec4 e[2] = {seam_point(space, solid, k, 0),
                           seam_point(space, solid, k, solid->seam_pieces)};
    double chord_m;
    enum ap_status st = ap_distance(err, space, e[0], e[1], &chord_m);
    if (st != AP_OK)
        return st;
    *seam = (struct ap_seam){.end = {e[0], e[1]},
                             .length_m = chord_m,
                             .chord_cos = ap_space_cos(space, chord_m / space.rho_m),
                             .chord_sin = ap_space_sin(space, chord_m / space.rho_m)};
    if (part->form == AP_FORM_PLANE)
        return AP_OK;
    struct ap_vec4 middle = seam_point(space, finest, k, finest->seam_pieces / 2);
    double half = ap_space_cos(space, chord_m / 2 / space.rho_m) * 2;
    struct ap_vec4 straight = {(e[0].x + e[1].x) / half, (e[0].y + e[1].y) / half,
                               (e[0].z + e[1].z) / half, (e[0].w + e[1].w) / half};
    st = ap_distance(err, space, middle, straight, &seam->bulge_m);
    if (st != AP_OK || part->form == AP_FORM_TUBE) {
        seam->length_m = solid->longest_m * solid->seam_pieces;
        return st;
    }
    struct ap_vec3 u[2];
    for (int i = 0; i < 2; i++)
        u[i] = ap_vec3_normalize((struct ap_vec3){e[i].x, e[i].y, e[i].z});
    seam->bend_rad = asin(fmin(ap_vec3_length(ap_vec3_sub(u[1], u[0])) / 2, 1));
    return AP_OK;
}

// The seams of a solid with a form, and what meshes with coarser ones are made of: copies of the
// levels that the shape has in data.
static enum ap_status keep_seams(struct ap_error *err, const struct ap_scene *scene,
                                 const struct ap_part *part, const struct ap_mesh_data *data,
                                 struct ap_mesh_data *kept, struct ap_shape *shape) {
    enum ap_status st = AP_OK;
    if (part->kind != AP_PART_SOLID || part->form == AP_FORM_FACETS)
        return AP_OK;
    const struct ap_solid *solid = &scene->solids[part->solid],
                          *finest = solid + (part->solid_levels > 1 ? part->solid_levels - 1 : 0);
    if (solid->seam_count > AP_SEAMS_MAX)
        return AP_OK;
    shape->seam_count = solid->seam_count;
    struct ap_seam *worst = &shape->worst_seam;
    for (int k = 0; st == AP_OK && k < shape->seam_count; k++) {
        struct ap_seam *seam = &shape->seam[k];
        st = seam_of(err, scene->space, part, solid, finest, k, seam);
        worst->length_m = fmax(worst->length_m, seam->length_m);
        worst->bulge_m = fmax(worst->bulge_m, seam->bulge_m);
        worst->bend_rad = fmax(worst->bend_rad, seam->bend_rad);
    }
    for (int k = 0; st == AP_OK && shape->seam_count > 0 && k < shape->levels; k++) {
        shape->seam_pieces[k] = solid[k].seam_pieces;
        shape->seam_vertex[k] = solid[k].seams;
        st = ap_mesh_data_append(err, kept, data, &shape->mesh[k], &shape->kept[k]);
    }
    return st;
}

static enum ap_status add_shape(struct ap_error *err, const struct ap_scene *scene,
                                const struct ap_part *part, struct ap_mesh_data *data,
                                struct ap_shape *shape) {
    enum ap_status st = AP_OK;
    memset(shape, 0, sizeof *shape);
    switch (part->kind) {
    case AP_PART_BALL:
        for (size_t k = 0; st == AP_OK && k < sizeof BALL_STEPS / sizeof *BALL_STEPS; k++)
            st = ap_mesh_sphere(err, BALL_STEPS[k], data, &shape->mesh[k], &shape->grain[k]);
        shape->levels = sizeof BALL_STEPS / sizeof *BALL_STEPS;
        return st;
    case AP_PART_STICK:
        for (size_t k = 0; st == AP_OK && k < sizeof STICK_AROUND / sizeof *STICK_AROUND; k++) {
            st = ap_mesh_stick(err, scene->space, part, STICK_AROUND[k], 0, data, &shape->mesh[k],
                               &shape->step_m[k]);
            shape->grain[k] = PI / STICK_AROUND[k];
            shape->levels++;
        }
        // Straight is straight in e3, but not for somebody who was born in a curved space.
        for (int along = 16; st == AP_OK && scene->space.kappa == 0 && along <= 128; along *= 2) {
            int k = shape->levels++, around = 64;
            st = ap_mesh_stick(err, scene->space, part, around, along, data, &shape->mesh[k],
                               &shape->step_m[k]);
            shape->grain[k] = PI / around;
        }
        return st;
    case AP_PART_POLYGON:
        return add_polygon(err, scene->space, part, data, shape);
    case AP_PART_SOLID:
        shape->levels = part->solid_levels > 1 ? part->solid_levels : 1;
        for (int k = 0; st == AP_OK && k < shape->levels; k++) {
            const struct ap_solid *solid = &scene->solids[part->solid + k];
            st = ap_mesh_solid(err, scene->space, solid, data, &shape->mesh[k]);
            shape->grain[k] = solid->turn_rad;
            shape->step_m[k] = solid->longest_m;
        }
        find_facing(part, &scene->solids[part->solid], shape);
        return st;
    }
    return ap_fail(err, AP_INPUT, "a part of an unknown kind %d", (int)part->kind);
}

static enum ap_status reach_of(struct ap_error *err, const struct ap_scene *scene,
                               const struct ap_part *part, double *reach_m) {
    double circum = 0, in = 0;
    enum ap_status st = AP_OK;
    switch (part->kind) {
    case AP_PART_BALL:
        circum = part->radius_m;
        break;
    case AP_PART_STICK:
        circum = part->length_m / 2 + fmax(part->radius_m, part->radius2_m);
        break;
    case AP_PART_POLYGON:
        st = ap_regular_polygon(err, scene->space, part->sides, part->edge_m, &circum, &in);
        break;
    case AP_PART_SOLID:
        for (int k = 0; k < part->solid_levels || k == 0; k++)
            circum = fmax(circum, scene->solids[part->solid + k].reach_m);
        break;
    }
    if (st == AP_OK)
        *reach_m = circum;
    return st;
}

static enum ap_status add_parts(struct ap_error *err, const struct ap_scene *scene, size_t most,
                                struct ap_mesh_data *data, struct ap_meshes *made,
                                size_t *first_part) {
    enum ap_status st = AP_OK;
    for (size_t i = 0; st == AP_OK && i < scene->part_count; i++) {
        const struct ap_part *part = &scene->parts[i];
        size_t s = 0;
        while (s < made->shape_count && !same_shape(&scene->parts[first_part[s]], part))
            s++;
        if (s == made->shape_count) {
            st = add_shape(err, scene, part, data, &made->shapes[s]);
            drop_large(most, data, &made->shapes[s]);
            if (st == AP_OK)
                st = keep_seams(err, scene, part, data, &made->kept, &made->shapes[s]);
            first_part[s] = i;
            made->shape_count++;
        }
        made->shape_of_part[i] = s;
        if (st == AP_OK)
            st = reach_of(err, scene, part, &made->reach_m[i]);
    }
    return st;
}

// With fewer levels, the fewer the budget has room for; never without the coarsest. What is finer
// is then made for the frame.
static enum ap_status add_within_budget(struct ap_error *err, const struct ap_scene *scene,
                                        struct ap_mesh_data *data, struct ap_meshes *made,
                                        size_t *first_part) {
    enum { FEWEST = 16 };
    size_t allowed = ap_budget_meshes(scene),
           most = 2 * (allowed / ap_budget_mesh_bytes(1, 2 * 3)); // two triangles a vertex
    for (;; most /= 2) {
        made->shape_count = data->vertex_count = data->index_count = 0;
        made->kept.vertex_count = made->kept.index_count = 0;
        enum ap_status st = add_parts(err, scene, most, data, made, first_part);
        size_t bytes = ap_budget_mesh_bytes(data->vertex_count, data->index_count) +
                       made->kept.vertex_count * sizeof *made->kept.vertices +
                       made->kept.index_count * sizeof *made->kept.indices;
        if (st != AP_OK || bytes <= allowed || most < FEWEST)
            return st;
    }
}

static void release(struct ap_meshes *meshes) {
    free(meshes->shapes);
    free(meshes->shape_of_part);
    free(meshes->reach_m);
    ap_mesh_data_finish(&meshes->kept);
    memset(meshes, 0, sizeof *meshes);
}

static enum ap_status upload(struct ap_error *err, const struct ap_gpu *gpu, const void *bytes,
                             size_t size, VkBufferUsageFlags usage, struct ap_gpu_buffer *buffer) {
    struct ap_gpu_buffer staging = {0}, made = {0};
    enum ap_status st =
        ap_gpu_buffer_create(err, gpu, size, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, true, &staging);
    if (st == AP_OK)
        st = ap_gpu_buffer_create(err, gpu, size, usage | VK_BUFFER_USAGE_TRANSFER_DST_BIT, false,
                                  &made);
    VkCommandBuffer cmd = VK_NULL_HANDLE;
    if (st == AP_OK)
        st = ap_gpu_commands_begin(err, gpu, &cmd);
    if (st == AP_OK) {
        memcpy(staging.mapped, bytes, size);
        vkCmdCopyBuffer(cmd, staging.buffer, made.buffer, 1, &(VkBufferCopy){0, 0, size});
        st = ap_gpu_commands_end(err, gpu, cmd);
    }
    ap_gpu_buffer_destroy(gpu, &staging);
    if (st == AP_OK)
        *buffer = made;
    else
        ap_gpu_buffer_destroy(gpu, &made);
    return st;
}

enum ap_status ap_meshes_make(struct ap_error *err, const struct ap_scene *scene,
                              struct ap_meshes *meshes, struct ap_mesh_data *data) {
    struct ap_meshes made = {0};
    size_t n = scene->part_count + 1; // an empty scene is a scene
    enum ap_status st = AP_OK;
    size_t *first_part = calloc(n, sizeof *first_part);
    made.shapes = calloc(n, sizeof *made.shapes);
    made.shape_of_part = calloc(n, sizeof *made.shape_of_part);
    made.reach_m = calloc(n, sizeof *made.reach_m);
    if (!first_part || !made.shapes || !made.shape_of_part || !made.reach_m)
        st = ap_fail(err, AP_ENVIRONMENT, "no memory for the meshes of %zu parts", n);
    else
        st = add_within_budget(err, scene, data, &made, first_part);
    free(first_part);
    if (st == AP_OK)
        *meshes = made;
    else
        release(&made);
    return st;
}

enum ap_status ap_meshes_create(struct ap_error *err, const struct ap_gpu *gpu,
                                const struct ap_scene *scene, struct ap_meshes *meshes) {
    struct ap_meshes made = {0};
    struct ap_mesh_data data = {0};
    enum ap_status st = ap_meshes_make(err, scene, &made, &data);
    if (st != AP_OK || data.index_count == 0)
        goto out;
    st = upload(err, gpu, data.vertices, data.vertex_count * sizeof *data.vertices,
                VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, &made.vertices);
    if (st == AP_OK)
        st = upload(err, gpu, data.indices, data.index_count * sizeof *data.indices,
                    VK_BUFFER_USAGE_INDEX_BUFFER_BIT, &made.indices);
out:
    ap_mesh_data_finish(&data);
    if (st == AP_OK)
        *meshes = made;
    else
        ap_meshes_destroy(gpu, &made);
    return st;
}

size_t ap_meshes_bytes(const struct ap_meshes *meshes) {
    return meshes->vertices.size + meshes->indices.size + ap_mesh_data_bytes(&meshes->kept);
}

void ap_meshes_destroy(const struct ap_gpu *gpu, struct ap_meshes *meshes) {
    ap_gpu_buffer_destroy(gpu, &meshes->vertices);
    ap_gpu_buffer_destroy(gpu, &meshes->indices);
    release(meshes);
}
