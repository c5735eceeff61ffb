#include "tests/render/compare.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/render/refine/refine_surface.h"
#include "src/view/exact.h"
#include "tests/render/reference_surface.h"
#include "tests/render/stage.h"

static const double PI = 3.14159265358979323846;
enum { STRANGE = 0xfffff0 };

static void put(struct compare_values *values, double value) {
    if (values->count == values->room) {
        values->room = values->room ? 2 * values->room : 1024;
        values->at = ref_grow(values->at, values->room * sizeof *values->at);
    }
    values->at[values->count++] = (float)value;
}

static int by_value(const void *left, const void *right) {
    float a = *(const float *)left, b = *(const float *)right;
    return (a > b) - (a < b);
}

double compare_quantile(struct compare_values *values, double q) {
    if (values->count == 0)
        return 0;
    qsort(values->at, values->count, sizeof *values->at, by_value);
    return (double)values->at[(size_t)(q * (double)(values->count - 1))];
}

static void put_all(struct compare_values *sum, const struct compare_values *more) {
    for (size_t i = 0; i < more->count; i++)
        put(sum, (double)more->at[i]);
}

static void take_worst(double value, const char *text, double *most, char worst[96]) {
    if (!(value > *most))
        return;
    *most = value;
    memcpy(worst, text, 96);
}

void compare_tally_add(struct compare_tally *sum, const struct compare_tally *more) {
    sum->frames += more->frames;
    sum->pixels += more->pixels;
    put_all(&sum->edge_px, &more->edge_px);
    put_all(&sum->seam_px, &more->seam_px);
    put_all(&sum->depth, &more->depth);
    put_all(&sum->direction_px, &more->direction_px);
    put_all(&sum->near_px, &more->near_px);
    put_all(&sum->bare_px, &more->bare_px);
    put_all(&sum->direction_arcmin, &more->direction_arcmin);
    sum->strange += more->strange;
    sum->antipode += more->antipode;
    sum->antipode_differ += more->antipode_differ;
    sum->antipode_off += more->antipode_off;
    sum->beyond += more->beyond;
    take_worst(more->most_edge_px, more->worst_edge, &sum->most_edge_px, sum->worst_edge);
    take_worst(more->most_seam_px, more->worst_seam, &sum->most_seam_px, sum->worst_seam);
    take_worst(more->most_direction_px, more->worst_direction, &sum->most_direction_px,
               sum->worst_direction);
}

void compare_tally_finish(struct compare_tally *tally) {
    free(tally->edge_px.at);
    free(tally->seam_px.at);
    free(tally->depth.at);
    free(tally->near_px.at);
    free(tally->bare_px.at);
    free(tally->direction_px.at);
    free(tally->direction_arcmin.at);
    memset(tally, 0, sizeof *tally);
}

static double column_differs(const struct ap_iso *a, const struct ap_iso *b, int column) {
    double most = 0;
    for (int i = 0; i < 4; i++)
        most = fmax(most, fabs(a->m[i][column] - b->m[i][column]));
    return most / fmax(1, fabs(a->m[3][3]));
}

// Whether an item is this thing: the same part at the same place. Cells may be turned into one
// another, so that another part of the same kind stands there; what shows is the same.
static bool is_thing(const struct ap_scene *scene, const struct ap_draw_item *item,
                     const struct ref_thing *thing) {
    struct ap_space space = scene->space;
    const struct ap_part *a = &scene->parts[item->part], *b = &scene->parts[thing->part];
    const struct ap_iso *m = &item->nose_from_part, *n = &thing->nose_from_part;
    if (a->carrier != AP_CARRIER_CELL)
        return item->part == thing->part;
    struct ap_iso at_foot;
    if (item->at_foot) {
        at_foot = ap_iso_mul(*n, ap_plane_foot(space, n));
        n = &at_foot;
    }
    if (b->carrier != AP_CARRIER_CELL || a->kind != b->kind || a->form != b->form ||
        column_differs(m, n, 3) > 1e-6)
        return false;
    if (item->at_foot && column_differs(m, n, 0) > 1e-6)
        return false;
    // Walls face their cell by y, struts and joints by z.
    int facing = a->kind == AP_PART_BALL ? 3 : a->form == AP_FORM_PLANE ? 1 : 2;
    return column_differs(m, n, facing) < 1e-6;
}

// By item: 2·thing + image.
static uint32_t *number_items(const struct probe_world *world, const struct ref_world *truth) {
    uint32_t *number = ref_grow(NULL, (world->list.count + 1) * sizeof *number);
    for (size_t i = 0; i < world->list.count; i++) {
        const struct ap_draw_item *item = world->list.order[i];
        int k = 0, count = ref_thing_count(truth);
        while (k < count && !is_thing(world->scene, item, ref_thing_at(truth, k)))
            k++;
        number[i] = k < count ? 2 * (uint32_t)k + (uint32_t)item->image : STRANGE;
    }
    return number;
}

struct pixel {
    int eye;
    double x, y;
    int thing, image; // that is drawn; −1: nothing
    double depth;
    struct ref_hit truth;
};

struct compare {
    const struct probe *probe;
    struct ref_world *truth;
    const struct ap_scene *scene;
    const struct ap_viewer *viewer;
    double bound_px;
    struct compare_tally *tally;
};

static bool same(int thing, int image, const struct ref_hit *hit) {
    return thing == hit->thing && (thing < 0 || image == hit->image);
}

enum question { SEES, MEETS, MISSES };

static bool answer(const struct compare *c, enum question question, int thing, int image, double x,
                   double y) {
    if (question != SEES)
        return ref_meets(c->truth, x, y, thing, image, NULL) == (question == MEETS);
    struct ref_hit hit = ref_cast(c->truth, x, y);
    return same(thing, image, &hit);
}

// How far off in the picture the nearest line is that sees a thing, meets it (hidden or not), or
// misses it.
static double nearest_px(const struct compare *c, const struct pixel *p, enum question question,
                         int thing, int image, double most_px) {
    static const double RING[] = {0,    0.01, 0.02, 0.04, 0.06, 0.08, 0.12,
                                  0.16, 0.2,  0.25, 0.32, 0.4,  0.5,  0.65,
                                  0.8,  1,    1.3,  1.6,  2,    2.5,  COMPARE_REACH_PX};
    enum { RINGS = sizeof RING / sizeof *RING, WAYS = 24 };
    for (int r = 0; r < RINGS && (r == 0 || RING[r - 1] < most_px); r++)
        for (int k = 0; k < (r > 0 ? WAYS : 1); k++) {
            double a = 2 * PI * (k + 0.5 * (r & 1)) / WAYS, low = r > 0 ? RING[r - 1] : 0,
                   high = RING[r];
            if (!answer(c, question, thing, image, p->x + high * cos(a), p->y + high * sin(a)))
                continue;
            for (int step = 0; step < 6; step++) {
                double m = (low + high) / 2;
                bool yes = answer(c, question, thing, image, p->x + m * cos(a), p->y + m * sin(a));
                *(yes ? &high : &low) = m;
            }
            return high;
        }
    return INFINITY;
}

// Pixels for a unit of tangent, the larger of the two axes.
static double pixels_of(const struct compare *c, int eye) {
    const struct ap_frustum *f = &c->viewer->eye[eye].frustum;
    return fmax(c->probe->width / (f->right - f->left), c->probe->height / (f->up - f->down));
}

// How far an outline must have moved for this to be drawn: to where the drawn thing is seen; or to
// where it would be, and what ought to be seen before it is not. Where two surfaces are so close to
// one another that no outline explains it, a quarter of how far they are apart counts, as an angle:
// *seam.
static double distance_px(const struct compare *c, const struct pixel *p, double drawn_along_m,
                          bool *seam) {
    double drawn = 0, hidden = 0, along_m;
    if (p->thing >= 0)
        drawn = nearest_px(c, p, MEETS, p->thing, p->image, COMPARE_REACH_PX);
    if (p->truth.thing >= 0 && (p->thing < 0 || drawn_along_m > p->truth.along_m))
        hidden = nearest_px(c, p, MISSES, p->truth.thing, p->truth.image, COMPARE_REACH_PX);
    double moved = fmax(drawn, hidden), limit = moved > 0 ? moved : INFINITY;
    double off = fmin(limit, nearest_px(c, p, SEES, p->thing, p->image, limit));
    *seam = p->thing >= 0 && drawn == 0 && off > c->bound_px &&
            ref_meets(c->truth, p->x, p->y, p->thing, p->image, &along_m);
    if (!*seam)
        return off;
    return fmin(off,
                fabs(along_m - p->truth.along_m) / p->truth.along_m / 4 * pixels_of(c, p->eye));
}

static bool near_antipode(const struct compare *c, const struct ref_hit *hit) {
    double rho = c->viewer->space.rho_m;
    return c->viewer->space.kappa > 0 && c->viewer->mode == AP_VIEW_NATIVE && hit->thing >= 0 &&
           fabs(ap_vec3_length(hit->tangent_m) - PI * rho) < 0.1 * rho;
}

static const char *kind_of(const struct compare *c, int thing) {
    static const char *const KIND[] = {"ball", "stick", "polygon", "solid"}, *const FORM[] = {
                                                                                 "facets", "wall",
                                                                                 "strut", "joint"};
    if (thing < 0 || thing >= ref_thing_count(c->truth))
        return "nothing";
    const struct ap_part *part = &c->scene->parts[ref_thing_at(c->truth, thing)->part];
    return part->kind == AP_PART_SOLID ? FORM[part->form] : KIND[part->kind];
}

static void note(const struct compare *c, const struct pixel *p, double value, double *most,
                 char text[96]) {
    if (!(value > *most))
        return;
    *most = value;
    snprintf(text, 96, "place %d, %s (%.0f, %.0f): %s %d%s for %s %d%s at %.3f m", c->tally->place,
             p->eye ? "right" : "left", p->x - 0.5, p->y - 0.5, kind_of(c, p->thing), p->thing,
             p->image ? "'" : "", kind_of(c, p->truth.thing), p->truth.thing,
             p->truth.image ? "'" : "", p->truth.along_m);
}

// Where the drawn point of a surface would be seen if it were on the surface: at the point that the
// nose sees in the same direction.
static void look_at_direction(const struct compare *c, const struct pixel *p, double along_m) {
    const struct ap_view_eye *eye = &c->viewer->eye[p->eye];
    const struct ap_frustum *f = &eye->frustum;
    const uint32_t size_px[2] = {c->probe->width, c->probe->height};
    struct ap_vec3 d = {f->left + (f->right - f->left) * p->x / size_px[0],
                        f->up - (f->up - f->down) * p->y / size_px[1], -1};
    struct ap_vec3 way = ap_quat_rotate(eye->view_from_eye.q, ap_vec3_normalize(d)), at;
    struct ap_vec3 drawn = ap_vec3_add(eye->view_from_eye.p, ap_vec3_scale(along_m, way));
    // A sheet keeps directions from the nose; of what is round the nearest point counts too.
    double off = INFINITY, angle = 0;
    for (int way_there = 0; way_there < 2; way_there++) {
        double px[2];
        if (!(way_there ? ref_foot : ref_from_nose)(c->truth, p->thing, drawn, &at))
            continue;
        ap_exact_pixel(c->viewer, size_px, p->eye, at, px);
        struct ap_vec3 to = ap_vec3_sub(at, eye->view_from_eye.p);
        if (!(hypot(px[0] - p->x, px[1] - p->y) < off))
            continue;
        off = hypot(px[0] - p->x, px[1] - p->y);
        angle = atan2(ap_vec3_length(ap_vec3_cross(to, way)), ap_vec3_dot(to, way));
        if (ref_is_sheet(c->truth, p->thing))
            break;
    }
    if (off == INFINITY)
        return;
    if (ap_surface_is_bare(&c->scene->parts[ref_thing_at(c->truth, p->thing)->part])) {
        put(&c->tally->bare_px, off);
        return;
    }
    if (along_m < COMPARE_NEAR_M) {
        put(&c->tally->near_px, off);
        return;
    }
    put(&c->tally->direction_px, off);
    put(&c->tally->direction_arcmin, angle * 180 / PI * 60);
    note(c, p, off, &c->tally->most_direction_px, c->tally->worst_direction);
}

static void look_at_pixel(const struct compare *c, const struct pixel *p) {
    struct compare_tally *t = c->tally;
    bool agree = same(p->thing, p->image, &p->truth), close = near_antipode(c, &p->truth);
    t->pixels++;
    t->antipode += close;
    double along_m =
        p->thing < 0 ? 0 : probe_along(c->probe, c->viewer, p->eye, p->image, p->x, p->y, p->depth);
    if (agree) {
        if (p->thing < 0 || close)
            return;
        put(&t->depth, fabs(along_m - p->truth.along_m) / p->truth.along_m);
        if (c->viewer->mode == AP_VIEW_NATIVE)
            look_at_direction(c, p, along_m);
        return;
    }
    bool seam;
    double off = distance_px(c, p, along_m, &seam);
    if (close) {
        t->antipode_differ++;
        t->antipode_off += off > c->bound_px;
        return;
    }
    put(seam ? &t->seam_px : &t->edge_px, off);
    note(c, p, off, seam ? &t->most_seam_px : &t->most_edge_px,
         seam ? t->worst_seam : t->worst_edge);
}

static void paint(uint8_t *rgb, int thing, int image) {
    uint32_t h = (uint32_t)(2 * thing + image + 2) * 2654435761u;
    for (int k = 0; k < 3; k++)
        rgb[k] = thing < 0 ? 0 : (uint8_t)(64 + (h >> (8 * k + 7)) % 192);
}

static void write_pictures(const struct compare *c, const char *name, int eye,
                           const struct pixel *pixels) {
    uint32_t w = c->probe->width, h = c->probe->height;
    struct ap_image image;
    char path[512];
    STAGE_CHECK(ap_image_create(&stage_error, 3 * w, h, &image));
    for (uint32_t y = 0; y < h; y++)
        for (uint32_t x = 0; x < w; x++) {
            const struct pixel *p = &pixels[y * w + x];
            uint8_t *rgb = image.rgb + 3 * ((size_t)y * 3 * w + x);
            paint(rgb, p->thing, p->image);
            paint(rgb + 3 * w, p->truth.thing, p->truth.image);
            bool agree = same(p->thing, p->image, &p->truth);
            for (int k = 0; k < 3; k++)
                rgb[6 * w + (uint32_t)k] = agree ? rgb[k] / 4 : 255;
        }
    snprintf(path, sizeof path, "%s-%s.png", name, eye ? "right" : "left");
    STAGE_CHECK(ap_png_write(&stage_error, path, &image));
    ap_image_finish(&image);
}

static void look_at_eye(const struct compare *c, int eye, const uint32_t *ids, const float *depth,
                        const char *pictures) {
    uint32_t w = c->probe->width, h = c->probe->height;
    struct pixel *pixels = ref_grow(NULL, (size_t)w * h * sizeof *pixels);
    for (uint32_t i = 0; i < w * h; i++) {
        struct pixel *p = &pixels[i];
        *p = (struct pixel){
            .eye = eye, .x = i % w + 0.5, .y = i / w + 0.5, .depth = (double)depth[i]};
        p->thing = ids[i] == 0 ? -1 : (int)((ids[i] - 1) / 2);
        p->image = ids[i] == 0 ? 0 : (int)((ids[i] - 1) % 2);
        p->truth = ref_cast(c->truth, p->x, p->y);
        c->tally->strange += ids[i] == STRANGE + 1;
    }
    if (pictures)
        write_pictures(c, pictures, eye, pixels);
    for (uint32_t i = 0; i < w * h; i++)
        look_at_pixel(c, &pixels[i]);
    free(pixels);
}

bool compare_frame(struct probe *probe, struct probe_world *world,
                   const struct ap_frame_input *input, double max_error_px, const char *pictures,
                   struct compare_tally *tally) {
    struct ref_world *truth = ref_world_create(world->scene, input, probe->width, probe->height);
    if (ref_eye_inside(truth)) {
        ref_world_destroy(truth);
        return false;
    }
    struct compare c = {probe, truth, world->scene, &input->viewer, max_error_px, tally};
    size_t count = (size_t)probe->width * probe->height;
    uint32_t *ids = ref_grow(NULL, count * sizeof *ids);
    float *depth = ref_grow(NULL, count * sizeof *depth);
    probe_list(probe, world, input, max_error_px);
    uint32_t *number = number_items(world, truth);
    for (int e = 0; e < 2; e++) {
        ref_aim(truth, e);
        probe_draw(probe, world, input, e, number, ids, depth);
        look_at_eye(&c, e, ids, depth, pictures);
    }
    tally->frames++;
    tally->beyond += world->list.stats.beyond_bound > 0;
    free(number);
    free(ids);
    free(depth);
    ref_world_destroy(truth);
    return true;
}
