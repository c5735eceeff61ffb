#include "tests/render/reference.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/render/reference_surface.h"

// Lengths are over rho throughout, and points of the space have the base point at (0, 0, 0, 1).

static const double PI = 3.14159265358979323846;
enum { TILE_PX = 8, MARGIN_PX = 4 };

struct candidate {
    int prim;
    double near; // along any line of the tile, at least
};

struct tile {
    struct candidate *list;
    int count;
};

// A ball about something as balls of the tangent space that lines start in, one for each image: log
// brings points of h3 nearer together, and those of s3 farther apart by at most theta/sin theta.
struct seen {
    double at[2][3], reach[2];
    int images; // 0: too near a pole of s3 for that
};

struct ref_world {
    struct ref_surfaces s;
    struct ap_viewer viewer;
    int kappa;
    bool tourist;
    double rho, forbidden;
    uint32_t size_px[2];
    int tiles[2];
    struct tile *tile;
    int eye, hint;
    double origin[3];               // native: the eye in tangent space
    struct ap_iso frame;            // the eye's axes and (tourist) its place, in nose space
    struct seen *seen, *seen_thing; // by primitive, by thing
};

static double dot3(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// The tangent vector of a point, for bounds only.
static void log_of(int kappa, const double x[4], double t[3]) {
    double s = sqrt(dot3(x, x));
    double r = kappa > 0 ? atan2(s, x[3]) : kappa < 0 ? asinh(s) : s;
    for (int i = 0; i < 3; i++)
        t[i] = s > 0 ? r / s * x[i] : 0;
}

static struct ref_ray line_of_sight(const struct ref_world *w, double x_px, double y_px) {
    const struct ap_frustum *f = &w->viewer.eye[w->eye].frustum;
    double d[3] = {f->left + (f->right - f->left) * x_px / w->size_px[0],
                   f->up - (f->up - f->down) * y_px / w->size_px[1], -1};
    double n = sqrt(dot3(d, d));
    struct ref_ray ray = {.kappa = w->kappa, .tourist = w->tourist};
    for (int i = 0; i < 4; i++) {
        if (i < 3)
            ray.own[i] = d[i] / n;
        for (int k = 0; k < 3; k++)
            ray.to[i] += w->frame.m[i][k] * d[k] / n;
        ray.from[i] = w->tourist ? w->frame.m[i][3] : i < 3 ? w->origin[i] : 0;
    }
    return ray;
}

// The first place where a line of a tile may be within `reach` of a point of s3: no step is longer
// than the distance that is left, for exp stretches nothing there. spread as in tile_meets.
static double first_near(const struct ref_ray *ray, const double centre[4], double reach,
                         double from, double spread) {
    double end = ref_ray_end(ray);
    for (double t = from; t < end;) {
        double x[4];
        ref_ray_point(ray, t, x);
        double inner = dot3(x, centre) + x[3] * centre[3];
        double away = acos(fmax(-1, fmin(1, inner))) - reach - spread * t;
        if (away <= 0)
            return fmax(from, t - 1e-5);
        t += fmax(away / (1 + spread), 1e-6);
    }
    return INFINITY;
}

static int spans_of(const struct ref_world *w, const struct ref_ray *ray, int prim, double before,
                    struct ref_span span[REF_SPANS]) {
    const struct seen *seen = &w->seen[prim];
    const double *direction = w->tourist ? ray->own : ray->to;
    int count = 0;
    if (seen->images == 0) {
        span[0] = (struct ref_span){w->forbidden, fmin(before, ref_ray_end(ray))};
        return 1;
    }
    for (int i = 0; i < seen->images; i++) {
        const double *at = seen->at[i];
        double b = dot3(at, direction), reach = seen->reach[i];
        double square = reach * reach - dot3(at, at) + b * b;
        if (square < 0 || b + sqrt(square) < w->forbidden)
            continue;
        span[count++] = (struct ref_span){fmax(w->forbidden, b - sqrt(square)), b + sqrt(square)};
    }
    return count;
}

static bool first_of(const struct ref_world *w, const struct ref_ray *ray, int prim,
                     struct ref_span span, double *root) {
    const struct ref_search s = {&w->s, &w->s.prims[prim], ray, w->forbidden,
                                 ref_steepest(ray, span)};
    return ref_first(&s, span, root);
}

static const struct tile *tile_at(const struct ref_world *w, double x_px, double y_px) {
    int tx = (int)fmax(0, fmin(w->tiles[0] - 1, floor(x_px / TILE_PX)));
    int ty = (int)fmax(0, fmin(w->tiles[1] - 1, floor(y_px / TILE_PX)));
    return &w->tile[ty * w->tiles[0] + tx];
}

// Whether a primitive is met before *best, which then is where.
static bool meet(const struct ref_world *w, const struct ref_ray *ray, int prim, double *best) {
    struct ref_span span[REF_SPANS];
    int count = spans_of(w, ray, prim, *best, span);
    for (int k = 0; k < count && span[k].begin < *best; k++) {
        double t;
        span[k].end = fmin(span[k].end, *best);
        if (!first_of(w, ray, prim, span[k], &t) || !(t < *best))
            continue;
        *best = t;
        return true;
    }
    return false;
}

struct ref_hit ref_cast(struct ref_world *w, double x_px, double y_px) {
    struct ref_hit hit = {.thing = -1};
    int first = w->hint;
    struct ref_ray ray = line_of_sight(w, x_px, y_px);
    const struct tile *tile = tile_at(w, x_px, y_px);
    struct ref_grid grid;
    double best = INFINITY;
    ref_fill_grid(&ray, w->forbidden, &grid);
    ray.grid = &grid;
    // What the line before met is often met again, and then little is left to look through.
    if (w->hint >= 0 && meet(w, &ray, w->hint, &best))
        hit.thing = w->s.prims[w->hint].thing;
    for (int i = 0; i < tile->count && tile->list[i].near < best; i++)
        if (tile->list[i].prim != w->hint && meet(w, &ray, tile->list[i].prim, &best)) {
            hit.thing = w->s.prims[tile->list[i].prim].thing;
            first = tile->list[i].prim;
        }
    w->hint = first;
    if (hit.thing < 0)
        return hit;
    hit.along_m = best * w->rho;
    hit.image = w->kappa > 0 && ref_far(&ray, best) > PI;
    if (!w->tourist)
        hit.tangent_m = (struct ap_vec3){w->rho * (ray.from[0] + best * ray.to[0]),
                                         w->rho * (ray.from[1] + best * ray.to[1]),
                                         w->rho * (ray.from[2] + best * ray.to[2])};
    return hit;
}

bool ref_meets(const struct ref_world *w, double x_px, double y_px, int thing, int image,
               double *along_m) {
    struct ref_ray ray = line_of_sight(w, x_px, y_px);
    const struct tile *tile = tile_at(w, x_px, y_px);
    struct ref_grid grid;
    double t, best = INFINITY;
    ref_fill_grid(&ray, w->forbidden, &grid);
    ray.grid = &grid;
    for (int i = 0; i < tile->count; i++) {
        struct ref_span span[REF_SPANS];
        int prim = tile->list[i].prim;
        if (w->s.prims[prim].thing != thing)
            continue;
        int count = spans_of(w, &ray, prim, INFINITY, span);
        for (int k = 0; k < count; k++)
            while (first_of(w, &ray, prim, span[k], &t)) {
                span[k].begin = t + 1e-9;
                if ((w->kappa > 0 && ref_far(&ray, t) > PI) != image)
                    continue;
                best = fmin(best, t);
                break;
            }
    }
    if (along_m)
        *along_m = best * w->rho;
    return best < INFINITY;
}

bool ref_from_nose(const struct ref_world *w, int thing, struct ap_vec3 near_m,
                   struct ap_vec3 *at_m) {
    const struct ref_prim *p = &w->s.prims[w->s.bounds[thing].first_prim];
    double d = ap_vec3_length(near_m), t0 = d / w->rho;
    if (p->shape == REF_FACET || !(d > 0))
        return false;
    struct ref_ray ray = {.kappa = w->kappa, .to = {near_m.x / d, near_m.y / d, near_m.z / d}};
    const struct ref_search s = {&w->s, p, &ray, w->forbidden, 1};
    double f0 = ref_value_at(&s, t0);
    for (double step = 1e-4; step < 0.2; step *= 1.5)
        for (int side = -1; side <= 1; side += 2) {
            double t = t0 * (1 + side * step), f = ref_value_at(&s, t);
            if ((f > 0) == (f0 > 0))
                continue;
            *at_m = ap_vec3_scale(ref_root(&s, t0, f0, t, f) * w->rho / d, near_m);
            return true;
        }
    return false;
}

// Along the geodesic across the surface: in the part's coordinates its point next to y. A stick's
// is about its middle line, which its ends share.
static bool next_on(int kappa, const struct ref_prim *p, double y[4]) {
    int axis = p->shape == REF_TUBE ? 0 : 2;
    bool tube = p->shape == REF_TUBE || p->shape == REF_STICK;
    double foot[4] = {0, 0, 0, 1}, out[3] = {y[0], y[1], y[2]}, radius = p->radius, c, s;
    if (tube) {
        double w = kappa > 0 ? hypot(y[axis], y[3]) : sqrt(y[3] * y[3] - y[axis] * y[axis]);
        foot[axis] = kappa ? y[axis] / w : y[axis];
        foot[3] = kappa ? y[3] / w : 1;
        out[axis] = 0;
        double along = kappa > 0 ? asin(foot[axis]) : kappa < 0 ? asinh(foot[axis]) : foot[axis];
        if (p->shape == REF_STICK && fabs(along) > p->half)
            return false;
        if (p->shape == REF_STICK)
            radius += (along / p->half + 1) / 2 * (p->radius2 - p->radius);
    }
    double far = sqrt(dot3(out, out));
    if (p->shape == REF_FACET || p->shape == REF_SHEET || !(far > 0))
        return false;
    ref_cos_sin(kappa, radius, &c, &s);
    for (int i = 0; i < 4; i++)
        y[i] = c * foot[i] + (i < 3 ? s / far * out[i] : 0);
    if (kappa == 0)
        y[3] = 1;
    return true;
}

bool ref_foot(const struct ref_world *w, int thing, struct ap_vec3 near_m, struct ap_vec3 *at_m) {
    const struct ref_prim *p = &w->s.prims[w->s.bounds[thing].first_prim];
    double t[3] = {near_m.x / w->rho, near_m.y / w->rho, near_m.z / w->rho}, x[4], y[4];
    ref_exp(w->kappa, t, x);
    ref_apply(&p->part_from_nose, x, y);
    if (!next_on(w->kappa, p, y))
        return false;
    ref_apply(&w->s.things[thing].nose_from_part, y, x);
    bool behind = w->kappa > 0 && sqrt(dot3(t, t)) > PI;
    log_of(w->kappa, x, t);
    double far = sqrt(dot3(t, t)), times = behind ? -(2 * PI - far) / far : 1;
    *at_m = ap_vec3_scale(w->rho * times, (struct ap_vec3){t[0], t[1], t[2]});
    return true;
}

static int by_near(const void *left, const void *right) {
    const struct candidate *a = left, *b = right;
    return a->near < b->near ? -1 : a->near > b->near ? 1 : a->prim - b->prim;
}

// Whether a line of a tile may meet a ball about a point, and not before *near. spread: the largest
// distance of a line's direction from the middle's.
static bool tile_meets(const struct ref_world *w, const struct ref_ray *middle, double spread,
                       const double centre[4], double reach, const struct seen *seen,
                       double *near) {
    if (seen->images == 0) {
        *near = first_near(middle, centre, reach, w->forbidden, spread) * (1 - 1e-9);
        return *near < INFINITY;
    }
    const double *direction = w->tourist ? middle->own : middle->to;
    *near = INFINITY;
    for (int i = 0; i < seen->images; i++) {
        double d = sqrt(dot3(seen->at[i], seen->at[i])), r = seen->reach[i];
        double off = d > r ? acos(fmax(-1, fmin(1, dot3(seen->at[i], direction) / d))) : 0;
        if (d <= r || off <= 2 * asin(spread / 2) + asin(r / d) + 1e-6)
            *near = fmin(*near, fmax(0, d - r) * (1 - 1e-9));
    }
    return *near < INFINITY;
}

static void fill_tile(struct ref_world *w, int tx, int ty, struct tile *tile) {
    double x0 = tx * TILE_PX - MARGIN_PX, y0 = ty * TILE_PX - MARGIN_PX;
    double side = TILE_PX + 2 * MARGIN_PX, spread = 0;
    struct ref_ray middle = line_of_sight(w, x0 + side / 2, y0 + side / 2);
    for (int k = 0; k < 4; k++) {
        struct ref_ray corner = line_of_sight(w, x0 + side * (k & 1), y0 + side * (k >> 1));
        double d[3];
        for (int i = 0; i < 3; i++)
            d[i] = corner.own[i] - middle.own[i];
        spread = fmax(spread, sqrt(dot3(d, d)));
    }
    tile->count = 0;
    int room = 0;
    for (int k = 0; k < w->s.thing_count; k++) {
        const struct ref_bound *b = &w->s.bounds[k];
        double near;
        if (!tile_meets(w, &middle, spread, b->centre, b->reach, &w->seen_thing[k], &near))
            continue;
        for (int i = b->first_prim; i < b->first_prim + b->prim_count; i++) {
            const struct ref_prim *p = &w->s.prims[i];
            if (!tile_meets(w, &middle, spread, p->centre, p->reach, &w->seen[i], &near))
                continue;
            if (tile->count >= room) {
                room = room ? 2 * room : 32;
                tile->list = ref_grow(tile->list, (size_t)room * sizeof *tile->list);
            }
            tile->list[tile->count++] = (struct candidate){i, near};
        }
    }
    if (tile->count > 0)
        qsort(tile->list, (size_t)tile->count, sizeof *tile->list, by_near);
}

static void drop_tiles(struct ref_world *w) {
    for (int i = 0; i < w->tiles[0] * w->tiles[1]; i++) {
        free(w->tile[i].list);
        w->tile[i] = (struct tile){0};
    }
}

static struct seen see(const struct ref_world *w, const struct ap_iso *eye_from_nose,
                       const double at[4], double reach) {
    struct seen seen = {.images = w->kappa > 0 ? 2 : 1};
    double x[4];
    memcpy(x, at, sizeof x);
    if (w->tourist)
        ref_apply(eye_from_nose, at, x);
    log_of(w->kappa, x, seen.at[0]);
    double far = sqrt(dot3(seen.at[0], seen.at[0]));
    if (w->kappa > 0 && fmin(far, PI - far) - reach < 0.2)
        return (struct seen){.images = 0};
    double sine = fmin(sin(far - reach), sin(far + reach));
    for (int i = 0; i < seen.images; i++) {
        double length = i ? 2 * PI - far : far;
        seen.reach[i] = w->kappa > 0 ? reach * fmax(1, (length + reach) / sine) : reach;
        seen.reach[i] = seen.reach[i] * (1 + 1e-9) + 1e-9;
        for (int k = 0; k < 3; k++)
            seen.at[i][k] = (i ? -length / far : 1) * seen.at[0][k];
    }
    for (int i = 0; !w->tourist && i < seen.images; i++)
        for (int k = 0; k < 3; k++)
            seen.at[i][k] -= w->origin[k];
    return seen;
}

void ref_aim(struct ref_world *w, int eye) {
    const struct ap_pose *pose = &w->viewer.eye[eye].view_from_eye;
    w->eye = eye;
    w->hint = -1;
    w->frame = ap_iso_rotate(pose->q);
    if (w->tourist)
        w->frame = ap_iso_mul(ap_iso_translate(w->viewer.space, pose->p), w->frame);
    struct ap_iso eye_from_nose = ap_iso_inverse(w->viewer.space, w->frame);
    const double p[3] = {pose->p.x, pose->p.y, pose->p.z};
    for (int k = 0; k < 3; k++)
        w->origin[k] = p[k] / w->rho;
    for (int i = 0; i < w->s.prim_count; i++)
        w->seen[i] = see(w, &eye_from_nose, w->s.prims[i].centre, w->s.prims[i].reach);
    for (int i = 0; i < w->s.thing_count; i++)
        w->seen_thing[i] = see(w, &eye_from_nose, w->s.bounds[i].centre, w->s.bounds[i].reach);
    drop_tiles(w);
    for (int ty = 0; ty < w->tiles[1]; ty++)
        for (int tx = 0; tx < w->tiles[0]; tx++)
            fill_tile(w, tx, ty, &w->tile[ty * w->tiles[0] + tx]);
}

bool ref_is_sheet(const struct ref_world *w, int thing) {
    return w->s.prims[w->s.bounds[thing].first_prim].shape == REF_SHEET;
}

bool ref_eye_inside(const struct ref_world *w) {
    for (int e = 0; e < 2; e++) {
        struct ap_vec3 p = w->viewer.eye[e].view_from_eye.p;
        double t[3] = {p.x / w->rho, p.y / w->rho, p.z / w->rho}, x[4];
        ref_exp(w->kappa, t, x);
        for (int i = 0; i < w->s.prim_count; i++) {
            double f = ref_value(&w->s, &w->s.prims[i], x);
            enum ref_shape shape = w->s.prims[i].shape;
            bool flat = shape == REF_SHEET || shape == REF_FACET;
            if (!flat && f < w->forbidden)
                return true;
        }
    }
    return false;
}

struct ref_world *ref_world_create(const struct ap_scene *scene, const struct ap_frame_input *input,
                                   uint32_t width_px, uint32_t height_px) {
    struct ref_world *w = ref_grow(NULL, sizeof *w);
    memset(w, 0, sizeof *w);
    w->viewer = input->viewer;
    w->kappa = scene->space.kappa;
    w->rho = scene->space.rho_m;
    w->tourist = input->viewer.mode == AP_VIEW_TOURIST;
    w->forbidden = AP_NEAR_M / w->rho;
    w->size_px[0] = width_px;
    w->size_px[1] = height_px;
    for (int i = 0; i < 2; i++)
        w->tiles[i] = (int)(w->size_px[i] + TILE_PX - 1) / TILE_PX;
    size_t tiles = (size_t)w->tiles[0] * (size_t)w->tiles[1];
    w->tile = ref_grow(NULL, tiles * sizeof *w->tile);
    memset(w->tile, 0, tiles * sizeof *w->tile);
    ref_surfaces_fill(&w->s, scene, input, w->size_px);
    w->seen = ref_grow(NULL, ((size_t)w->s.prim_count + 1) * sizeof *w->seen);
    w->seen_thing = ref_grow(NULL, ((size_t)w->s.thing_count + 1) * sizeof *w->seen_thing);
    ref_aim(w, 0);
    return w;
}

void ref_world_destroy(struct ref_world *w) {
    if (!w)
        return;
    drop_tiles(w);
    free(w->tile);
    free(w->seen);
    free(w->seen_thing);
    ref_surfaces_finish(&w->s);
    free(w);
}

int ref_thing_count(const struct ref_world *w) {
    return w->s.thing_count;
}

const struct ref_thing *ref_thing_at(const struct ref_world *w, int thing) {
    return &w->s.things[thing];
}
