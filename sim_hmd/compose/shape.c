#include "sim_hmd/compose/shape.h"

#include <math.h>

// Curved layers are bounded piece by piece: this angle each.
static const double PIECE_RAD = 0.39269908169872414; // π/8
// A parallel of a sphere's piece lies poleward of the plane through the piece's corners by less.
static const double PARALLEL_RAD = 0.012;
static const double PI = 3.14159265358979323846;

// An eye so near to the middle of a curved layer sees it as from there: a thousandth of a pixel.
static const double CENTRED_RADII = 1e-7;

// A pixel's middle is farther inside than this.
static const double HALF_PIXEL = 1e-6;

// Tangents of a field of view.
struct tangents {
    double left, right, up, down;
};

static struct tangents tangents_of(XrFovf fov) {
    return (struct tangents){tan((double)fov.angleLeft), tan((double)fov.angleRight),
                             tan((double)fov.angleUp), tan((double)fov.angleDown)};
}

// The eye in the layer's space.
struct sight {
    const struct sim_layer *layer;
    const struct sim_layer_view *view;
    struct tangents fov;   // the eye's
    struct ap_quat turn;   // layer_from_eye
    struct ap_vec3 eye;    // in metres, or in radii for a curved layer
    struct ap_vec3 ray[3]; // of (u, v) = (0, 0), (1, 0), (0, 1)
};

static double unit_of(const struct sim_layer *layer) {
    if (layer->kind == SIM_LAYER_CYLINDER || layer->kind == SIM_LAYER_EQUIRECT)
        return layer->radius_m > 0 ? 1 / layer->radius_m : 0;
    return layer->kind == SIM_LAYER_QUAD ? 1 : 0; // of a projection only the rotation counts
}

static struct sight sight_of(const struct sim_frame *frame, int eye,
                             const struct sim_layer *layer) {
    struct sight s = {.layer = layer,
                      .view = &layer->view[eye],
                      .fov = tangents_of(frame->fov[eye]),
                      .turn = AP_QUAT_IDENTITY};
    struct ap_pose stage_from_layer = s.view->stage_from_view;
    struct ap_quat back = ap_quat_conj(ap_quat_normalize(stage_from_layer.q));
    // In the identity no rounding of the product's shall move the picture.
    if (layer->kind != SIM_LAYER_PROJECTION || !s.view->at_display)
        s.turn = ap_quat_mul(back, ap_quat_normalize(frame->stage_from_eye[eye].q));
    struct ap_vec3 apart = ap_vec3_sub(frame->stage_from_eye[eye].p, stage_from_layer.p);
    double unit = unit_of(layer);
    if (unit > 0)
        s.eye = ap_vec3_scale(unit, ap_quat_rotate(back, apart));
    const double corner[3][2] = {
        {s.fov.left, s.fov.up}, {s.fov.right, s.fov.up}, {s.fov.left, s.fov.down}};
    for (int k = 0; k < 3; k++)
        s.ray[k] = ap_quat_rotate(s.turn, (struct ap_vec3){corner[k][0], corner[k][1], -1});
    return s;
}

// ---- What the shader is told

// A plane's homogeneous coordinates on the picture of it, for a ray.
static struct ap_vec3 plane_of(const struct sight *s, struct ap_vec3 ray) {
    double w = -ray.z;
    if (s->layer->kind == SIM_LAYER_QUAD) {
        double width_m = s->layer->width_m, height_m = s->layer->height_m;
        return (struct ap_vec3){0.5 * w + (s->eye.x * w + s->eye.z * ray.x) / width_m,
                                0.5 * w - (s->eye.y * w + s->eye.z * ray.y) / height_m, w};
    }
    struct tangents t = tangents_of(s->view->fov);
    return (struct ap_vec3){(ray.x - t.left * w) / (t.right - t.left),
                            (t.up * w - ray.y) / (t.up - t.down), w};
}

static bool is_plane(const struct sim_layer *layer) {
    return layer->kind == SIM_LAYER_PROJECTION || layer->kind == SIM_LAYER_QUAD;
}

// Where in its image a view's picture begins, and how large it is, of the whole.
struct part {
    double from[2], size[2];
};

static struct part part_of(const struct sim_layer_view *view) {
    const double width = view->width_px, height = view->height_px;
    return (struct part){{view->rect.offset.x / width, view->rect.offset.y / height},
                         {view->rect.extent.width / width, view->rect.extent.height / height}};
}

static void put_rays(const struct sight *s, struct sim_shape *shape) {
    struct part part = part_of(s->view);
    struct ap_vec3 r[3];
    for (int k = 0; k < 3; k++) {
        r[k] = is_plane(s->layer) ? plane_of(s, s->ray[k]) : s->ray[k];
        if (is_plane(s->layer)) {
            r[k].x = part.size[0] * r[k].x + part.from[0] * r[k].z;
            r[k].y = part.size[1] * r[k].y + part.from[1] * r[k].z;
        }
    }
    for (int k = 1; k < 3; k++)
        r[k] = ap_vec3_sub(r[k], r[0]);
    for (int k = 0; k < 3; k++) {
        int column = (k + 2) % 3; // u, v, 1
        shape->from_uv[0][column] = (float)r[k].x;
        shape->from_uv[1][column] = (float)r[k].y;
        shape->from_uv[2][column] = (float)r[k].z;
    }
}

static void put_curve(const struct sight *s, struct sim_shape *shape) {
    const struct sim_layer *layer = s->layer;
    bool sphere = layer->kind == SIM_LAYER_EQUIRECT;
    double up = sphere ? layer->upper_rad : 0.5 * layer->height_radii;
    double down = sphere ? layer->lower_rad : -up;
    double x = s->eye.x, y = s->eye.y, z = s->eye.z;
    shape->origin[0] = (float)x;
    shape->origin[1] = (float)y;
    shape->origin[2] = (float)z;
    shape->origin[3] = (float)(x * x + z * z + (sphere ? y * y : 0) - 1);
    struct part part = part_of(s->view);
    shape->shape[0] = (float)(part.size[0] / layer->central_rad);
    shape->shape[1] = (float)(part.from[0] + 0.5 * part.size[0]);
    shape->shape[2] = (float)(part.size[1] / (down - up));
    if (!sphere) // the shader counts heights from the eye's
        up -= y, down -= y;
    shape->shape[3] = (float)(part.from[1] + part.size[1] * up / (up - down));
}

// The whole width of the image spans the whole turn. (A part of the width, side by side, keeps half
// a texel of seam: no sampler joins the sides of a part.)
static bool goes_around(const struct sim_layer *layer, const struct sim_layer_view *view) {
    return layer->kind == SIM_LAYER_EQUIRECT &&
           fabs(fabs(layer->central_rad) - 2 * 3.14159265358979323846) < 1e-5 &&
           view->rect.extent.width == (int32_t)view->width_px;
}

static void put_part(const struct sim_layer_view *view, bool around, struct sim_shape *shape) {
    struct part part = part_of(view);
    const double half[2] = {0.5 / view->width_px, 0.5 / view->height_px};
    for (int k = 0; k < 2; k++) {
        shape->limit[k] = (float)(part.from[k] + half[k]);
        shape->limit[2 + k] = (float)(part.from[k] + part.size[k] - half[k]);
    }
    if (around) {
        shape->limit[0] = -1;
        shape->limit[2] = 2;
    }
}

// ---- What is in the picture

struct bounds {
    double low[2], high[2];
};

static void include(struct bounds *b, const struct sight *s, struct ap_vec3 p) {
    const double at[2] = {(p.x / -p.z - s->fov.left) / (s->fov.right - s->fov.left),
                          (p.y / -p.z - s->fov.up) / (s->fov.down - s->fov.up)};
    for (int k = 0; k < 2; k++) {
        b->low[k] = fmin(b->low[k], at[k]);
        b->high[k] = fmax(b->high[k], at[k]);
    }
}

// The hull of these points of the layer's space, as far as it lies before the eye.
static void include_hull(struct bounds *b, const struct sight *s, struct ap_vec3 *p, int n) {
    struct ap_quat back = ap_quat_conj(s->turn);
    double far = 0;
    for (int k = 0; k < n; k++) {
        p[k] = ap_quat_rotate(back, ap_vec3_sub(p[k], s->eye));
        far = fmax(far, ap_vec3_length(p[k]));
    }
    double near = -1e-5 * far;
    for (int k = 0; k < n; k++) {
        if (p[k].z <= near)
            include(b, s, p[k]);
        for (int m = 0; m < k; m++)
            if ((p[k].z <= near) != (p[m].z <= near)) {
                double t = (near - p[k].z) / (p[m].z - p[k].z);
                include(b, s, ap_vec3_add(p[k], ap_vec3_scale(t, ap_vec3_sub(p[m], p[k]))));
            }
    }
}

static void bound_plane(struct bounds *b, const struct sight *s) {
    struct tangents t = tangents_of(s->view->fov);
    double z = -1;
    if (s->layer->kind == SIM_LAYER_QUAD) {
        t = (struct tangents){-0.5 * s->layer->width_m, 0.5 * s->layer->width_m,
                              0.5 * s->layer->height_m, -0.5 * s->layer->height_m};
        z = 0;
    }
    struct ap_vec3 corners[4] = {
        {t.left, t.up, z}, {t.right, t.up, z}, {t.left, t.down, z}, {t.right, t.down, z}};
    include_hull(b, s, corners, 4);
}

static struct ap_vec3 on_sphere(double lon, double lat, double radius) {
    return (struct ap_vec3){radius * sin(lon) * cos(lat), radius * sin(lat),
                            -radius * cos(lon) * cos(lat)};
}

// One piece: within the hull of its corners, on the surface and on planes that touch it.
static void bound_piece(struct bounds *b, const struct sight *s, const double lon[2],
                        const double up[2]) {
    struct ap_vec3 p[8];
    bool sphere = s->layer->kind == SIM_LAYER_EQUIRECT;
    for (int k = 0; k < 8; k++) {
        double out = k & 4 ? 1 / cos(0.5 * (lon[1] - lon[0])) : 1, at = up[k >> 1 & 1];
        if (sphere) {
            out = k & 4 ? out / cos(0.5 * (up[1] - up[0])) : 1;
            p[k] = on_sphere(lon[k & 1], at, out);
        } else {
            p[k] = on_sphere(lon[k & 1], 0, out);
            p[k].y = at;
        }
    }
    include_hull(b, s, p, 8);
}

static void bound_curved(struct bounds *b, const struct sight *s) {
    const struct sim_layer *layer = s->layer;
    bool sphere = layer->kind == SIM_LAYER_EQUIRECT;
    double half = fmin(0.5 * fabs(layer->central_rad), PI);
    double low = -0.5 * layer->height_radii, high = -low;
    if (sphere) {
        low = fmax(fmin(layer->lower_rad, layer->upper_rad) - PARALLEL_RAD, -0.5 * PI);
        high = fmin(fmax(layer->lower_rad, layer->upper_rad) + PARALLEL_RAD, 0.5 * PI);
    }
    int across = (int)ceil(2 * half / PIECE_RAD);
    int along = sphere ? (int)ceil((high - low) / PIECE_RAD) : 1;
    for (int i = 0; i < across; i++)
        for (int j = 0; j < along; j++) {
            const double lon[2] = {-half + 2 * half * i / across,
                                   -half + 2 * half * (i + 1) / across};
            double up[2] = {low + (high - low) * j / along, low + (high - low) * (j + 1) / along};
            if (sphere) {
                up[0] = fmax(up[0] - PARALLEL_RAD, -0.5 * PI);
                up[1] = fmin(up[1] + PARALLEL_RAD, 0.5 * PI);
            }
            bound_piece(b, s, lon, up);
        }
}

// Whether there is something that could be seen at all, which the shader's divisions need too.
static bool has_front(const struct sight *s) {
    const struct sim_layer *layer = s->layer;
    struct tangents t = tangents_of(s->view->fov);
    switch (layer->kind) {
    case SIM_LAYER_PROJECTION:
        return t.right - t.left != 0 && t.up - t.down != 0;
    case SIM_LAYER_QUAD:
        return layer->width_m > 0 && layer->height_m > 0 && s->eye.z > 0;
    case SIM_LAYER_CYLINDER:
        return layer->central_rad > 0 && layer->height_radii > 0;
    case SIM_LAYER_EQUIRECT:
        return layer->central_rad != 0 && layer->upper_rad - layer->lower_rad != 0;
    case SIM_LAYER_CUBE:
        return true;
    }
    return false;
}

static bool plane_covers(const struct sight *s) {
    struct ap_vec3 fourth = ap_vec3_sub(ap_vec3_add(s->ray[1], s->ray[2]), s->ray[0]);
    const struct ap_vec3 corner[4] = {s->ray[0], s->ray[1], s->ray[2], fourth};
    for (int k = 0; k < 4; k++) {
        struct ap_vec3 h = plane_of(s, corner[k]);
        double slack = HALF_PIXEL * h.z;
        if (!(h.z > 0 && h.x >= -slack && h.x <= h.z + slack && h.y >= -slack &&
              h.y <= h.z + slack))
            return false;
    }
    return true;
}

static bool covers(const struct sight *s) {
    const struct sim_layer *layer = s->layer;
    if (layer->kind == SIM_LAYER_CUBE)
        return true;
    if (is_plane(layer))
        return plane_covers(s);
    return layer->kind == SIM_LAYER_EQUIRECT && ap_vec3_length(s->eye) < 1 - HALF_PIXEL &&
           fabs(layer->central_rad) >= 2 * PI - HALF_PIXEL &&
           fmax(layer->upper_rad, layer->lower_rad) >= 0.5 * PI - HALF_PIXEL &&
           fmin(layer->upper_rad, layer->lower_rad) <= -0.5 * PI + HALF_PIXEL;
}

struct sim_seen sim_layer_seen(const struct sim_frame *frame, int eye,
                               const struct sim_layer *layer) {
    struct sim_seen seen = {.to_uv = {1, 1}};
    if (layer->hidden[eye])
        return seen;
    struct sight s = sight_of(frame, eye, layer);
    if (!has_front(&s))
        return seen;
    seen.all = seen.any = covers(&s);
    if (!seen.all) {
        struct bounds b = {{INFINITY, INFINITY}, {-INFINITY, -INFINITY}};
        if (is_plane(layer))
            bound_plane(&b, &s);
        else
            bound_curved(&b, &s);
        for (int k = 0; k < 2; k++) {
            seen.from_uv[k] = fmax(b.low[k], 0);
            seen.to_uv[k] = fmin(b.high[k], 1);
        }
        seen.any = seen.from_uv[0] < seen.to_uv[0] && seen.from_uv[1] < seen.to_uv[1];
    }
    seen.part = s.view->rect.extent.width != (int32_t)s.view->width_px ||
                s.view->rect.extent.height != (int32_t)s.view->height_px;
    seen.centred = ap_vec3_length(s.eye) < CENTRED_RADII;
    put_rays(&s, &seen.shape);
    seen.around = goes_around(layer, s.view);
    // With edges, so that the seam is none: what rounding puts beside the picture is on it.
    seen.part |= seen.around && !seen.all;
    put_part(s.view, seen.around, &seen.shape);
    if (layer->kind == SIM_LAYER_CYLINDER || layer->kind == SIM_LAYER_EQUIRECT)
        put_curve(&s, &seen.shape);
    return seen;
}
