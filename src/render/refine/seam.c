#include "src/render/refine/seam.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// Seams of more pieces than 2^this are cut piece by piece: what is so near is refined anyway.
enum { DEPTH_MAX = 4, DEPTH_BITS = 3 };

struct ap_snapped_mesh {
    uint64_t key; // 0: free
    struct ap_mesh mesh;
};

// The nearest and the farthest distance of a geodesic's points, over rho, in s3 and h3: W = w/rho
// of its ends, and C and S of its length. Along it W is a cosine. In h3 nobody asks for the
// farthest.
static void reach_of(struct ap_space space, const double w[2], double c, double s, double *near,
                     double *far) {
    double kappa = space.kappa, low = fmin(w[0], w[1]), high = fmax(w[0], w[1]);
    double square = kappa * (w[0] * w[0] + w[1] * w[1] - 2 * c * w[0] * w[1]) / (s * s);
    double top = sqrt(fmax(square, 0));
    bool turns = (w[1] - c * w[0]) * (w[0] - c * w[1]) > 0, rises = w[1] - c * w[0] > 0;
    if (kappa > 0) {
        high = turns && rises ? top : high;
        low = turns && !rises ? -top : low;
        *near = acos(fmin(high, 1));
        *far = acos(fmax(low, -1));
    } else {
        low = turns && !rises ? top : low;
        *near = acosh(fmax(low, 1));
        *far = INFINITY;
    }
}

static struct ap_line line_of(const struct ap_viewer *viewer, const struct ap_part *part,
                              const struct ap_seam *seam, const struct ap_iso *nose_from_part) {
    struct ap_space space = viewer->space;
    struct ap_line line = {.radius_m = part->form == AP_FORM_PLANE ? 0 : part->radius_m,
                           .length_m = seam->length_m,
                           .bend_rad = seam->bend_rad};
    struct ap_vec3 p[2];
    double w[2], near, far, rho = space.rho_m;
    for (int i = 0; i < 2; i++) {
        struct ap_vec4 q = ap_iso_apply(nose_from_part, seam->end[i]);
        p[i] = (struct ap_vec3){q.x, q.y, q.z};
        w[i] = q.w / rho;
        line.toward[i] = ap_vec3_normalize(p[i]);
    }
    if (space.kappa != 0) {
        reach_of(space, w, seam->chord_cos, seam->chord_sin, &near, &far);
    } else {
        struct ap_vec3 u = ap_vec3_sub(p[1], p[0]);
        double square = ap_vec3_dot(u, u), t = square > 0 ? -ap_vec3_dot(p[0], u) / square : 0;
        struct ap_vec3 foot = ap_vec3_add(p[0], ap_vec3_scale(fmin(fmax(t, 0), 1), u));
        near = ap_vec3_length(foot) / rho;
        far = fmax(ap_vec3_length(p[0]), ap_vec3_length(p[1])) / rho;
    }
    line.near_m = fmax(rho * near - seam->bulge_m, 0);
    line.far_m = rho * far + seam->bulge_m;
    return line;
}

bool ap_seams_cut(const struct ap_viewer *viewer, const struct ap_eyes *eyes,
                  const struct ap_part *part, const struct ap_shape *shape,
                  const struct ap_iso *nose_from_part, int image, double max_error_px,
                  struct ap_seam_cut cuts[AP_SEAMS_MAX], int *pieces) {
    bool equal = true;
    *pieces = 1;
    for (int k = 0; k < shape->seam_count; k++) {
        const struct ap_seam *seam = &shape->seam[k];
        const struct ap_line line = line_of(viewer, part, seam, nose_from_part);
        const struct ap_place place = {.far_m = line.far_m};
        int most = 0, depth;
        while (most < DEPTH_MAX && 2 << most <= shape->seam_pieces[shape->levels - 1])
            most++;
        depth = ap_line_depth(viewer, eyes, &line, image, max_error_px, most);
        bool held = depth >= 0;
        cuts[k].depth = held ? (signed char)depth : AP_SEAM_BY_PIECE;
        cuts[k].any_depth = ap_is_stretched(viewer, &place, image);
        *pieces = held && 1 << depth > *pieces ? 1 << depth : *pieces;
        equal = equal && held;
    }
    return equal;
}

// --- levels with coarser seams

void ap_snapped_clear(struct ap_snapped *s) {
    if (s->count > 0)
        memset(s->made, 0, s->room * sizeof *s->made);
    s->count = 0;
}

void ap_snapped_finish(struct ap_snapped *s) {
    free(s->made);
    free(s->moved);
    memset(s, 0, sizeof *s);
}

static struct ap_snapped_mesh *slot_of(const struct ap_snapped *s, uint64_t key) {
    size_t i = (size_t)(key * 0x9e3779b97f4a7c15u >> 32) & (s->room - 1);
    while (s->made[i].key != 0 && s->made[i].key != key)
        i = (i + 1) & (s->room - 1);
    return &s->made[i];
}

static enum ap_status make_room(struct ap_error *err, struct ap_snapped *s) {
    if (2 * s->count < s->room)
        return AP_OK;
    struct ap_snapped grown = *s;
    grown.room = s->room ? 2 * s->room : 64;
    grown.made = calloc(grown.room, sizeof *grown.made);
    if (!grown.made)
        return ap_fail(err, AP_ENVIRONMENT, "no memory for %zu meshes", grown.room);
    for (size_t i = 0; i < s->room; i++)
        if (s->made[i].key != 0)
            *slot_of(&grown, s->made[i].key) = s->made[i];
    free(s->made);
    *s = grown;
    return AP_OK;
}

// Where each vertex of a level goes: along its seam to the nearest that is kept.
static enum ap_status find_moves(struct ap_error *err, struct ap_snapped *s,
                                 const struct ap_shape *shape, int level,
                                 const struct ap_seam_cut *cuts) {
    uint32_t count = shape->kept[level].vertex_count;
    if (count > s->moved_room) {
        uint32_t *moved = realloc(s->moved, count * sizeof *moved);
        if (!moved)
            return ap_fail(err, AP_ENVIRONMENT, "no memory for %u vertices", count);
        s->moved = moved;
        s->moved_room = count;
    }
    for (uint32_t i = 0; i < count; i++)
        s->moved[i] = i;
    int pieces = shape->seam_pieces[level];
    for (int k = 0; k < shape->seam_count; k++) {
        const unsigned *vertex = shape->seam_vertex[level] + k * (pieces + 1);
        int step = pieces >> cuts[k].depth;
        for (int i = 0; i <= pieces; i++)
            s->moved[vertex[i]] = vertex[(i + step / 2) / step * step];
    }
    return AP_OK;
}

static enum ap_status copy_snapped(struct ap_error *err, const struct ap_snapped *s,
                                   const struct ap_mesh_data *kept, const struct ap_mesh *from,
                                   struct ap_mesh_data *data, struct ap_mesh *mesh) {
    struct ap_mesh made = ap_mesh_data_begin(data);
    enum ap_status st = AP_OK;
    for (uint32_t i = 0; st == AP_OK && i < from->vertex_count; i++)
        st = ap_mesh_data_copy(err, data, &kept->vertices[from->first_vertex + i]);
    for (uint32_t i = 0; st == AP_OK && i + 2 < from->index_count; i += 3) {
        const uint32_t *t = kept->indices + from->first_index + i;
        uint32_t a = s->moved[t[0]], b = s->moved[t[1]], c = s->moved[t[2]];
        if (a != b && b != c && c != a)
            st = ap_mesh_data_triangle(err, data, a, b, c);
    }
    if (st != AP_OK)
        return st;
    ap_mesh_data_end(data, &made);
    *mesh = made;
    return AP_OK;
}

enum ap_status ap_snapped_mesh(struct ap_error *err, struct ap_snapped *s,
                               const struct ap_meshes *meshes, size_t index, int level,
                               const struct ap_seam_cut cuts[AP_SEAMS_MAX],
                               struct ap_mesh_data *data, struct ap_mesh *mesh, uint64_t *which,
                               bool *own) {
    const struct ap_shape *shape = &meshes->shapes[index];
    uint64_t key = (((uint64_t)index << 4 | (uint64_t)level) + 1) << (DEPTH_BITS * AP_SEAMS_MAX);
    bool same = true;
    for (int k = 0; k < shape->seam_count; k++) {
        key |= (uint64_t)cuts[k].depth << (DEPTH_BITS * k);
        same = same && 1 << cuts[k].depth == shape->seam_pieces[level];
    }
    *own = !same;
    *which = same ? 0 : key;
    if (same) {
        *mesh = shape->mesh[level];
        return AP_OK;
    }
    enum ap_status st = make_room(err, s);
    if (st != AP_OK)
        return st;
    struct ap_snapped_mesh *slot = slot_of(s, key);
    if (slot->key == 0) {
        st = find_moves(err, s, shape, level, cuts);
        if (st == AP_OK)
            st = copy_snapped(err, s, &meshes->kept, &shape->kept[level], data, &slot->mesh);
        if (st != AP_OK)
            return st;
        slot->key = key;
        s->count++;
    }
    *mesh = slot->mesh;
    return AP_OK;
}
