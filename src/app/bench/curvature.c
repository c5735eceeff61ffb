#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/app/bench/bench.h"

// 5. The price of curvature: the same meshes, which are seen alike (the radius is 100 m, they are
// within 6 m), by a plain Euclidean pipeline, by tourist, by native; one eye, two by two passes,
// two by multiview.

enum { COLUMNS = 8, ROWS = 6, RINGS = 20, SEGMENTS = 40 };
static const double RADIUS_M = 100;

struct lane {
    const char *pipeline;
    int kappa;
    enum ap_view_mode mode;
};
static const struct lane LANES[] = {
    // A pipeline is made for its world, and e3's is a plain Euclidean one; it takes part twice,
    // which
    // shows how exact the measurement is.
    {"plain Euclidean", 0, AP_VIEW_NATIVE}, {"the same again", 0, AP_VIEW_NATIVE},
    {"h3 native", -1, AP_VIEW_NATIVE},      {"s3 native", 1, AP_VIEW_NATIVE},
    {"h3 tourist", -1, AP_VIEW_TOURIST},    {"s3 tourist", 1, AP_VIEW_TOURIST},
};
enum { LANE_COUNT = sizeof LANES / sizeof *LANES, EYES = 3, CASES = LANE_COUNT * EYES };
static const char *const EYE_NAMES[EYES] = {"one eye", "two eyes, two passes",
                                            "two eyes, multiview"};

// A sphere of 2·RINGS·SEGMENTS triangles, with a wave so that it is no ball.
static bool make_solid(struct ap_solid *solid) {
    const double pi = 3.14159265358979323846;
    *solid = (struct ap_solid){.vertex_count = (RINGS + 1) * (SEGMENTS + 1),
                               .index_count = 6 * RINGS * SEGMENTS,
                               .reach_m = 0.3};
    solid->positions = calloc(3 * solid->vertex_count, sizeof(float));
    solid->normals = calloc(3 * solid->vertex_count, sizeof(float));
    solid->indices = calloc(solid->index_count, sizeof(unsigned));
    if (!solid->positions || !solid->normals || !solid->indices)
        return false;
    size_t v = 0, k = 0;
    for (unsigned i = 0; i <= RINGS; i++)
        for (unsigned j = 0; j <= SEGMENTS; j++) {
            double a = pi * i / RINGS, b = 2 * pi * j / SEGMENTS, r = 0.25 + 0.02 * sin(5 * b);
            const double u[3] = {sin(a) * cos(b), cos(a), sin(a) * sin(b)};
            for (int c = 0; c < 3; c++, v++) {
                solid->positions[v] = (float)(r * u[c]);
                solid->normals[v] = (float)u[c];
            }
        }
    for (unsigned i = 0; i < RINGS; i++)
        for (unsigned j = 0; j < SEGMENTS; j++) {
            unsigned at = i * (SEGMENTS + 1) + j, below = at + SEGMENTS + 1;
            const unsigned two[6] = {at, at + 1, below, at + 1, below + 1, below};
            memcpy(&solid->indices[k], two, sizeof two);
            k += 6;
        }
    return true;
}

static bool make_scene(int kappa, struct ap_solid *solid, struct ap_scene *scene) {
    const struct ap_space space = {kappa, RADIUS_M};
    *scene = (struct ap_scene){.space = space,
                               .solids = solid,
                               .solid_count = 1,
                               .part_count = COLUMNS * ROWS,
                               .lamp = ap_exp(space, (struct ap_vec3){1, 4, 1}),
                               .lamp_reach_m = 5};
    scene->parts = calloc(scene->part_count, sizeof *scene->parts);
    for (size_t i = 0; scene->parts && i < scene->part_count; i++) {
        double x = (double)(i % COLUMNS) - 0.5 * (COLUMNS - 1),
               y = (double)i / COLUMNS - 0.5 * (ROWS - 1);
        struct ap_part *part = &scene->parts[i];
        part->kind = AP_PART_SOLID;
        part->carrier_from_part = ap_iso_translate(
            space, (struct ap_vec3){0.6 * x, 0.6 * floor(y), -2.5 - 0.05 * (double)i});
        part->lit = true;
        part->one_sided = true;
        for (int c = 0; c < 3; c++)
            part->color_srgb[c] = 0.4 + 0.2 * (double)((i + (size_t)c) % 3);
    }
    return scene->parts != NULL;
}

static enum ap_status prepare(struct ap_error *err, const struct ap_bench *bench,
                              const struct ap_bench_screen *screen, const struct ap_scene *scene,
                              const struct lane *lane, struct ap_bench_case cases[EYES]) {
    enum ap_status st = AP_OK;
    for (int eyes = 0; !st && eyes < EYES; eyes++) {
        struct ap_bench_case *c = &cases[eyes];
        const struct ap_renderer_params params = {.color_format = VK_FORMAT_R8G8B8A8_SRGB,
                                                  .width = screen->width,
                                                  .height = screen->height,
                                                  .no_multiview = eyes < 2,
                                                  .multiview_in_software = eyes == 2};
        const struct ap_bench_view view = {.pitch_rad = 0};
        c->screen = screen;
        c->input = ap_bench_input(scene, &view, screen->width, screen->height);
        c->input.viewer.mode = lane->mode;
        c->input.closed_eyes = eyes == 0 ? 2 : 0;
        st = ap_renderer_create(err, &bench->gpu, scene, &params, &c->renderer);
    }
    return st;
}

struct pictures {
    size_t pixels; // of both eyes
    uint8_t *euclidean;
    double
        off[CASES]; // share of the pixels that differ from the Euclidean ones, by more than 2/255
};

// What is compared must be the same picture: in e3 to the byte, in a space of this radius nearly. A
// picture of nothing would be cheap.
static enum ap_status compare(struct ap_error *err, const struct ap_bench_case cases[CASES],
                              struct pictures *p) {
    enum ap_status st = AP_OK;
    size_t lit = 0;
    for (int i = 0; !st && i < LANE_COUNT; i++) {
        const struct ap_bench_case *c = &cases[i * EYES + 1];
        const uint8_t *got = c->screen->pixels.mapped;
        size_t off = 0;
        st = ap_bench_picture(err, c);
        for (size_t k = 0; !st && k < p->pixels; k++) {
            bool differs = false;
            for (size_t j = 4 * k; j < 4 * k + 3; j++) {
                if (i == 0)
                    p->euclidean[j] = got[j];
                differs = differs || abs(got[j] - p->euclidean[j]) > 2;
                lit += i == 0 && j % 4 == 0 && got[j] > 0;
            }
            off += differs;
        }
        for (int eyes = 0; eyes < EYES; eyes++)
            p->off[i * EYES + eyes] = (double)off / (double)p->pixels;
    }
    if (!st && lit < p->pixels / 20)
        st = ap_fail(err, AP_ENVIRONMENT, "only %zu of %zu pixels show anything", lit, p->pixels);
    if (!st && p->off[EYES] > 0)
        st = ap_fail(err, AP_ENVIRONMENT, "two pictures of e3 differ in %.3g of all pixels",
                     p->off[EYES]);
    return st;
}

// Over the Euclidean pipeline: two eyes as this device gets them. And two over one.
struct findings {
    double h3, s3, two_passes, multiview;
};

static void write_rows(FILE *csv, const struct ap_bench *bench,
                       const struct ap_bench_case cases[CASES], const double off[CASES],
                       struct findings *found) {
    int both = bench->software ? 1 : 2; // by two passes, by multiview
    found->h3 = ap_bench_ratio(bench, &cases[2 * EYES + both], &cases[both]).median;
    found->s3 = ap_bench_ratio(bench, &cases[3 * EYES + both], &cases[both]).median;
    found->two_passes = ap_bench_ratio(bench, &cases[2 * EYES + 1], &cases[2 * EYES]).median;
    found->multiview = ap_bench_ratio(bench, &cases[2 * EYES + 2], &cases[2 * EYES]).median;
    for (int i = 0; i < LANE_COUNT; i++)
        for (int eyes = 0; eyes < EYES; eyes++) {
            const struct ap_bench_case *c = &cases[i * EYES + eyes];
            struct ap_spread flat = ap_bench_ratio(bench, c, &cases[eyes]),
                             one = ap_bench_ratio(bench, c, &cases[i * EYES]);
            fprintf(csv, "%s,\"%s\",%ux%u,%.4g,%.4g,%.4g,%.3f,%.3f,%.3f,%.3f,%.2g,%llu\n",
                    LANES[i].pipeline, EYE_NAMES[eyes], c->screen->width, c->screen->height,
                    c->cost_ms.low, c->cost_ms.median, c->cost_ms.high, flat.low, flat.median,
                    flat.high, one.median, off[i * EYES + eyes],
                    (unsigned long long)(c->stats.eye[0].triangles + c->stats.eye[1].triangles));
        }
}

static enum ap_status race(struct ap_error *err, const struct ap_bench *bench,
                           struct ap_solid *solid, const uint32_t size[2], FILE *csv,
                           struct findings *found) {
    struct ap_bench_case cases[CASES] = {{0}};
    struct ap_scene scenes[LANE_COUNT] = {{.parts = NULL}};
    struct ap_bench_screen screen = {0};
    struct pictures pictures = {.pixels = (size_t)2 * size[0] * size[1]};
    struct ap_bench more = *bench; // small differences: thrice the rounds
    more.rounds *= bench->quick ? 1 : 3;
    pictures.euclidean = malloc(4 * pictures.pixels);
    enum ap_status st =
        pictures.euclidean ? AP_OK : ap_fail(err, AP_ENVIRONMENT, "no memory for a picture");
    if (!st)
        st = ap_bench_screen_open(err, &bench->gpu, size[0], size[1], &screen);
    for (int i = 0; !st && i < LANE_COUNT; i++) {
        if (!make_scene(LANES[i].kappa, solid, &scenes[i]))
            st = ap_fail(err, AP_ENVIRONMENT, "out of memory");
        if (!st)
            st = prepare(err, bench, &screen, &scenes[i], &LANES[i], &cases[i * EYES]);
    }
    if (!st)
        st = compare(err, cases, &pictures);
    if (!st)
        st = ap_bench_race(err, &more, cases, CASES);
    if (!st)
        write_rows(csv, &more, cases, pictures.off, found);
    for (int i = 0; i < CASES; i++)
        ap_renderer_destroy(cases[i].renderer);
    for (int i = 0; i < LANE_COUNT; i++)
        free(scenes[i].parts);
    ap_bench_screen_close(&screen);
    free(pictures.euclidean);
    return st;
}

// The rows of the size that is shown come first.
static const char SCRIPT[] =
    "set style data histograms\nset style histogram errorbars gap 1 lw 1\n"
    "set style fill solid 0.9 border -1\nset yrange [0:*]\nset offsets graph 0, 0, 0.1, 0\n"
    "set bmargin 6\nset key at screen 0.5, screen 0.015 center bottom horizontal\nset title heading\n"
    "set ylabel cost\nset xlabel 'over each bar: how many times the plain Euclidean pipeline with the "
    "same eyes (aim: native at most 1.10)'\n"
    "plot for [e=0:2] $data skip 1 every 3::e::(rows-1) using 5:4:6:xtic(1) title (e==0 ? 'one eye' : "
    "e==1 ? 'two eyes, two passes' : 'two eyes, multiview') lc rgb (e==0 ? '#bbbbbb' : e==1 ? "
    "'#1f77b4' : '#2ca02c'), for [e=0:2] $data skip 1 every 3::e::(rows-1) using "
    "($0+0.25*(e-1)):6:(sprintf('%.2f',$8)) with labels offset 0,0.7 font ',8' notitle\n";

enum ap_status ap_bench_curvature(struct ap_error *err, const struct ap_bench *bench) {
    const uint32_t *shown = ap_bench_sizes_px[bench->quick];
    struct ap_solid solid;
    struct ap_bench_table table = {0};
    struct findings found[2] = {{0, 0, 0, 0}};
    enum ap_status st = make_solid(&solid) ? AP_OK : ap_fail(err, AP_ENVIRONMENT, "out of memory");
    if (!st)
        st = ap_bench_begin(err, "curvature",
                            "pipeline,eyes,size_px,ms_low,ms,ms_high,over_euclidean_low,"
                            "over_euclidean,over_euclidean_high,over_one_eye,pixels_off,triangles",
                            &table);
    for (int i = bench->quick; !st && i < 2; i++)
        st = race(err, bench, &solid, ap_bench_sizes_px[i], table.csv, &found[i]);
    char script[2048], title[256];
    snprintf(script, sizeof script, "cost = '%s (down is better)'\nrows = %d\n%s",
             bench->software ? "CPU ms of all threads" : "GPU ms", CASES, SCRIPT);
    snprintf(
        title, sizeof title,
        "The price of curvature, two eyes: h3 %.2f, s3 %.2f of a plain Euclidean pipeline\\ntwo eyes "
        "are %.2f of one by multiview, %.2f by two passes; the same 76,800 triangles an eye, %ux%u "
        "pixels an eye",
        found[bench->quick].h3, found[bench->quick].s3, found[bench->quick].multiview,
        found[bench->quick].two_passes, shown[0], shown[1]);
    if (!st)
        st = ap_bench_end(err, bench, &table, title, bench->gpu.properties.deviceName, script);
    ap_bench_drop(&table);
    free(solid.positions);
    free(solid.normals);
    free(solid.indices);
    return st;
}
