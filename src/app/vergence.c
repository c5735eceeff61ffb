#include "src/app/vergence.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "src/app/command.h"
#include "src/base/file.h"
#include "src/base/log.h"
#include "src/image/blob.h"
#include "src/view/silhouette.h"

static const double ARCMIN = 180 * 60 / M_PI;

// A measured disc is believed where it is the exact one but for its place: neither larger nor
// smaller, no part of its rim elsewhere than the rest, hardly anything of it that something may
// hide, and its place told well enough. docs/vergence.md says what this lets through and what not.
static const double GROW_PX = 0.1, SIGMA_PX = 0.008, SIDE_PX = 0.06, STRANGE_EDGE = 0.1;
static const double LEAST_AREA_PX = 12;

// How far beyond the exact outline a disc is looked for.
static const double MARGIN_PX = 4;

static const double SAGITTA_PX = 0.002;

static enum ap_status no_memory(struct ap_error *err) {
    return ap_fail(err, AP_ENVIRONMENT, "out of memory");
}

// --- directions

// Pixels and tangents of one eye's picture.
struct screen {
    struct ap_view_eye eye;
    double px_per_a, px_per_b; // pixels per unit of tangent
    double width, height;
};

static struct screen screen_of(const struct ap_capture *c, const struct ap_viewer *v, int e) {
    const struct ap_frustum *f = &v->eye[e].frustum;
    double w = c->headset.eye[e].width_px, h = c->headset.eye[e].height_px;
    return (struct screen){.eye = v->eye[e],
                           .px_per_a = w / (f->right - f->left),
                           .px_per_b = h / (f->up - f->down),
                           .width = w,
                           .height = h};
}

static double px_i(const struct screen *s, double a) {
    return (a - s->eye.frustum.left) * s->px_per_a;
}

static double px_j(const struct screen *s, double b) {
    return (s->eye.frustum.up - b) * s->px_per_b;
}

static struct ap_vec3 view_direction(const struct screen *s, double a, double b) {
    return ap_quat_rotate(s->eye.view_from_eye.q, (struct ap_vec3){a, b, -1});
}

static double azimuth(struct ap_vec3 d) {
    return atan2(d.x, -d.z);
}

// The exact direction in VIEW axes, in front or behind; false where it is undefined.
static bool exact_direction(const struct ap_viewer *v, int e, struct ap_nose_point p, int image,
                            struct ap_vec3 *direction) {
    struct ap_vec3 line;
    bool undefined = p.x.x == 0 && p.x.y == 0 && p.x.z == 0;
    if (undefined || !ap_sight_line(v, e, p, image, &line))
        return false;
    *direction = ap_quat_rotate(v->eye[e].view_from_eye.q, line);
    return true;
}

// --- one target in one pair of pictures

struct outline {
    struct ap_silhouette s;
    double min_i, max_i, min_j, max_j; // pixels
};

static bool outline_inside(const struct ap_viewer *v, int e, const struct screen *screen,
                           const struct ap_capture_target *t, int image, struct outline *out) {
    struct outline o;
    if (!ap_ball_silhouette(v, e, t->at, t->radius_m, image, &o.s))
        return false;
    o.min_i = px_i(screen, o.s.min_a);
    o.max_i = px_i(screen, o.s.max_a);
    o.min_j = px_j(screen, o.s.max_b);
    o.max_j = px_j(screen, o.s.min_b);
    if (!(o.min_i > 0 && o.max_i < screen->width && o.min_j > 0 && o.max_j < screen->height))
        return false;
    *out = o;
    return true;
}

struct pair {
    const struct ap_capture *capture;
    const struct ap_viewer *viewer;
    struct screen screen[2];
    const struct ap_image *picture; // left, right
};

// Where the eye really sees the target's centre, from where its disc is in the picture: the exact
// direction, moved by what the disc's centroid is off the exact outline's (the centroid of a disc's
// image is not the image of its centre).
struct sight {
    struct ap_vec3 direction; // VIEW axes
    double px_rad;            // the angle of one pixel to the side, there
};

static bool believable(const struct ap_blob *blob, double around_px) {
    return !blob->touches_edge && fabs(blob->grow_px) <= GROW_PX && blob->sigma_px <= SIGMA_PX &&
           blob->side_px <= SIDE_PX && blob->strange_px <= STRANGE_EDGE * sqrt(around_px);
}

// The exact outline as a polygon, in pixels: corners so near one another that its sides stay within
// SAGITTA_PX of it.
static double (*outline_points(const struct ap_viewer *v, int e, const struct screen *screen,
                               const struct ap_capture_target *t, int image,
                               const struct outline *o, size_t *count))[2] {
    double radius = fmax(o->max_i - o->min_i, o->max_j - o->min_j) / 2;
    int n = (int)fmin(fmax(M_PI * sqrt(radius / (2 * SAGITTA_PX)), 64), 2048);
    double(*points)[2] = malloc((size_t)n * sizeof *points);
    struct ap_outline_point *exact = malloc((size_t)n * sizeof *exact), nearest;
    bool ok =
        points && exact && ap_ball_outline(v, e, t->at, t->radius_m, image, n, exact, &nearest);
    for (int k = 0; k < n && ok; k++) {
        struct ap_vec3 line = exact[k].line;
        points[k][0] = px_i(screen, line.x / -line.z);
        points[k][1] = px_j(screen, line.y / -line.z);
    }
    free(exact);
    if (!ok) {
        free(points);
        return NULL;
    }
    *count = (size_t)n;
    return points;
}

static bool measure_disc(const struct pair *p, int e, const struct ap_capture_target *t, int image,
                         const struct outline *o, struct sight *sight) {
    const struct screen *screen = &p->screen[e];
    if (o->s.area * screen->px_per_a * screen->px_per_b < LEAST_AREA_PX)
        return false;
    size_t count;
    double(*points)[2] = outline_points(p->viewer, e, screen, t, image, o, &count);
    if (!points)
        return false;
    struct ap_blob_query query = {.color = {t->color[0], t->color[1], t->color[2]},
                                  .outline = (const double(*)[2])points,
                                  .count = count,
                                  .reach_px = MARGIN_PX};
    struct ap_blob blob;
    bool found = ap_find_blob(&p->picture[e], &query, &blob);
    free(points);
    double around = M_PI * ((o->max_i - o->min_i) + (o->max_j - o->min_j)) / 2;
    if (!found || !believable(&blob, around))
        return false;
    double a = o->s.centre_a + blob.shift_i / screen->px_per_a;
    double b = o->s.centre_b - blob.shift_j / screen->px_per_b;
    double half = 0.5 / screen->px_per_a;
    sight->direction = view_direction(screen, a, b);
    sight->px_rad =
        azimuth(view_direction(screen, a + half, b)) - azimuth(view_direction(screen, a - half, b));
    return true;
}

static void measure_image(const struct pair *p, const struct ap_capture_target *t,
                          const struct outline outline[2], struct ap_vergence_row *row) {
    struct sight sight[2];
    for (int e = 0; e < 2; e++)
        if (!measure_disc(p, e, t, row->image, &outline[e], &sight[e]))
            return;
    double measured = ap_vergence_of(sight[0].direction, sight[1].direction);
    row->measured_arcmin = measured * ARCMIN;
    row->error_px =
        (measured - row->exact_arcmin / ARCMIN) / ((sight[0].px_rad + sight[1].px_rad) / 2);
    row->inferred_m = ap_vergence_distance(p->viewer->eye[0].view_from_eye.p, sight[0].direction,
                                           p->viewer->eye[1].view_from_eye.p, sight[1].direction);
}

// The image that is looked at: the one that lies inside both pictures; where neither does, the one
// in front of the nose.
static int choose_image(const struct pair *p, const struct ap_capture_target *t,
                        struct ap_nose_point centre, bool *inside, struct outline outline[2]) {
    int images = p->viewer->space.kappa > 0 ? 2 : 1;
    for (int image = 0; image < images; image++) {
        *inside = true;
        for (int e = 0; e < 2 && *inside; e++)
            *inside = outline_inside(p->viewer, e, &p->screen[e], t, image, &outline[e]);
        if (*inside)
            return image;
    }
    return images == 2 && centre.x.z > 0 ? 1 : 0;
}

static struct ap_vergence_row measure_target(const struct pair *p, int index) {
    const struct ap_capture_target *t = &p->capture->targets[index];
    struct ap_nose_point centre = ap_nose_from_world(p->viewer, t->at);
    bool inside = false;
    struct outline outline[2];
    int image = choose_image(p, t, centre, &inside, outline);
    struct ap_vergence_row row = {.target = index,
                                  .image = image,
                                  .exact_arcmin = NAN,
                                  .measured_arcmin = NAN,
                                  .error_px = NAN,
                                  .inferred_m = NAN};
    row.true_m = ap_vec3_length(ap_tangent_from_nose(p->viewer->space, centre, image).x);
    struct ap_vec3 d[2];
    if (!exact_direction(p->viewer, 0, centre, image, &d[0]) ||
        !exact_direction(p->viewer, 1, centre, image, &d[1]))
        return row;
    row.exact_arcmin = ap_vergence_of(d[0], d[1]) * ARCMIN;
    if (inside)
        measure_image(p, t, outline, &row);
    return row;
}

// --- all of them

// *found false: the run did not come so far.
static enum ap_status read_picture(struct ap_error *err, const struct ap_capture *c, int64_t frame,
                                   int e, struct ap_image *picture, bool *found) {
    char *path = ap_capture_picture_path(c, frame, e ? "right.png" : "left.png");
    if (!path)
        return no_memory(err);
    enum ap_status st = AP_OK;
    struct ap_image image = {0};
    *found = ap_file_exists(path);
    if (*found)
        st = ap_png_read(err, path, &image);
    const struct ap_eye_profile *eye = &c->headset.eye[e];
    if (!st && *found && (image.width != eye->width_px || image.height != eye->height_px)) {
        st = ap_fail(err, AP_INPUT, "%s: %ux%u pixels, but the headset has %ux%u", path,
                     image.width, image.height, eye->width_px, eye->height_px);
        ap_image_finish(&image);
    }
    if (!st)
        *picture = image;
    free(path);
    return st;
}

static enum ap_status measure_frame(struct ap_error *err, const struct ap_capture *c, size_t k,
                                    struct ap_vergence_row *rows, bool *found) {
    struct ap_image picture[2] = {{0}, {0}};
    enum ap_status st = AP_OK;
    *found = true;
    for (int e = 0; e < 2 && !st && *found; e++)
        st = read_picture(err, c, c->frames[k].frame, e, &picture[e], found);
    if (!st && *found) {
        struct ap_viewer viewer = ap_capture_viewer(c, k);
        struct pair p = {.capture = c,
                         .viewer = &viewer,
                         .screen = {screen_of(c, &viewer, 0), screen_of(c, &viewer, 1)},
                         .picture = picture};
        for (size_t t = 0; t < c->target_count; t++) {
            rows[t] = measure_target(&p, (int)t);
            rows[t].frame = c->frames[k].frame;
        }
    }
    ap_image_finish(&picture[0]);
    ap_image_finish(&picture[1]);
    return st;
}

enum ap_status ap_vergence_measure(struct ap_error *err, const struct ap_capture *capture,
                                   struct ap_vergence_row **rows, size_t *count) {
    size_t each = capture->target_count, n = 0, missing = 0, room;
    if (__builtin_mul_overflow(capture->frame_count, each, &room))
        return no_memory(err);
    struct ap_vergence_row *all = calloc(room ? room : 1, sizeof *all);
    if (!all)
        return no_memory(err);
    for (size_t k = 0; k < capture->frame_count && each > 0; k++) {
        bool found;
        enum ap_status st = measure_frame(err, capture, k, all + n, &found);
        if (st) {
            free(all);
            return st;
        }
        if (found)
            n += each;
        else
            missing++;
    }
    if (missing)
        ap_log(AP_LOG_WARNING, "%s: %zu of %zu captured frames have no pictures; passed over",
               capture->dir, missing, capture->frame_count);
    *rows = all;
    *count = n;
    return AP_OK;
}

struct ap_vergence_summary ap_vergence_summarize(const struct ap_vergence_row *rows, size_t count,
                                                 int target) {
    struct ap_vergence_summary s = {
        .least_m = INFINITY, .most_m = 0, .least_arcmin = NAN, .most_arcmin = NAN};
    for (size_t i = 0; i < count; i++) {
        const struct ap_vergence_row *r = &rows[i];
        if (r->target != target)
            continue;
        s.frames++;
        s.least_m = fmin(s.least_m, r->true_m);
        s.most_m = fmax(s.most_m, r->true_m);
        if (isnan(r->measured_arcmin))
            continue;
        s.measured++;
        s.worst_px = fmax(s.worst_px, fabs(r->error_px));
        s.least_arcmin = fmin(s.least_arcmin, r->exact_arcmin);
        s.most_arcmin = fmax(s.most_arcmin, r->exact_arcmin);
    }
    return s;
}

void ap_vergence_print_summary(const struct ap_capture *capture, const struct ap_vergence_row *rows,
                               size_t count) {
    printf("%-20s %8s %9s %22s %15s\n", "target", "frames", "measured", "true distance (m)",
           "worst error px");
    for (size_t t = 0; t < capture->target_count; t++) {
        struct ap_vergence_summary s = ap_vergence_summarize(rows, count, (int)t);
        char range[48] = "-", worst[32] = "-";
        if (s.frames)
            snprintf(range, sizeof range, "%.3f ... %.3f", s.least_m, s.most_m);
        if (s.measured)
            snprintf(worst, sizeof worst, "%.4f", s.worst_px);
        // A name may hold what a terminal obeys.
        char name[sizeof capture->targets[t].name];
        snprintf(name, sizeof name, "%s", capture->targets[t].name);
        for (char *p = name; *p; p++)
            *p = (unsigned char)*p < 0x20 || *p == 0x7f ? '?' : *p;
        printf("%-20s %8zu %9zu %22s %15s\n", name, s.frames, s.measured, range, worst);
    }
}

static enum ap_status run_vergence(struct ap_error *err, int argc, char **argv) {
    static const struct ap_usage usage = {
        .command = "vergence",
        .operands = "DIR",
        .text =
            "Measures, in the captured pictures in DIR, where the two eyes see each target, and "
            "compares the angle between their lines of sight (the vergence) with the exact one."
            "\n\nWrites DIR/vergence.csv (frame,target,true_m,exact_arcmin,measured_arcmin,"
            "error_px,inferred_m) and, where gnuplot is installed, the plot DIR/vergence.png. "
            "measured_arcmin is empty where a target is cut or hidden."
            "\n\nExit status: 0; 2 usage; 3 DIR holds no capture, or a broken one; 4 DIR cannot "
            "be written.",
        .min_operands = 1,
        .max_operands = 1};
    int operands;
    bool done = false;
    enum ap_status st = ap_parse_options(err, &usage, argc, argv, &operands, &done);
    if (st || done)
        return st;
    struct ap_capture capture;
    st = ap_capture_read(err, argv[1], &capture);
    if (st)
        return st;
    struct ap_vergence_row *rows = NULL;
    size_t count = 0;
    st = ap_vergence_measure(err, &capture, &rows, &count);
    if (!st)
        st = ap_vergence_write(err, &capture, rows, count);
    if (!st)
        ap_vergence_print_summary(&capture, rows, count);
    free(rows);
    ap_capture_finish(&capture);
    return st;
}

const struct ap_command ap_command_vergence = {
    "vergence", "measure what the two eyes' pictures say about distance", run_vergence};
