#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/app/bench/bench.h"
#include "src/app/bench/facets.h"

// 2. Frames: what they cost against how far off they are, as --max-error goes from 4 px to 0.02 px.

static const double BOUNDS_PX[] = {4, 2, 1, 0.5, 0.25, 0.1, 0.05, 0.02};
static const double BOUNDS_QUICK_PX[] = {4, 1, 0.25, 0.05};
enum {
    BOUNDS = sizeof BOUNDS_PX / sizeof *BOUNDS_PX,
    BOUNDS_QUICK = sizeof BOUNDS_QUICK_PX / sizeof *BOUNDS_QUICK_PX,
    PLACES = 4,
    POINTS = 12000 // of a frame
};
static const double LEAST_PX = 0.001; // what is below is drawn as this

struct contest {
    const struct ap_bench *bench;
    const struct ap_bench_view *view;
    struct ap_room room;
    struct ap_bench_screen screen;
    const double *bounds_px;
    int count; // of bounds
    struct ap_bench_case cases[BOUNDS];
    struct ap_facet_errors errors[BOUNDS];
};

static enum ap_status time_all(struct ap_error *err, struct contest *c) {
    enum ap_status st = AP_OK;
    for (int i = 0; !st && i < c->count; i++) {
        struct ap_renderer_params params = {.color_format = VK_FORMAT_R8G8B8A8_SRGB,
                                            .width = c->screen.width,
                                            .height = c->screen.height};
        ap_room_renderer_params(&c->room, &params);
        params.max_error_px = c->bounds_px[i];
        c->cases[i] = (struct ap_bench_case){
            .screen = &c->screen,
            .input = ap_bench_input(c->room.scene, c->view, c->screen.width, c->screen.height)};
        st = ap_renderer_create(err, &c->bench->gpu, c->room.scene, &params, &c->cases[i].renderer);
    }
    if (!st)
        st = ap_bench_race(err, c->bench, c->cases, c->count);
    for (int i = 0; i < c->count; i++)
        ap_renderer_destroy(c->cases[i].renderer);
    return st;
}

// The place that is timed, and others about it.
static struct ap_frame_input place_of(const struct contest *c, int place) {
    struct ap_bench_view other = *c->view;
    other.at_m.x += 0.13 * place;
    other.at_m.z -= 0.11 * place;
    other.pitch_rad += 0.07 * place;
    return ap_bench_input(c->room.scene, &other, c->screen.width, c->screen.height);
}

static enum ap_status look_all(struct ap_error *err, struct contest *c) {
    struct ap_facets facets;
    enum ap_status st = ap_facets_open(err, c->room.scene, &facets);
    if (st)
        return st;
    for (int i = 0; !st && i < c->count; i++)
        for (int place = 0; !st && place < (c->bench->quick ? 1 : PLACES); place++) {
            struct ap_frame_input input = place_of(c, place);
            const struct ap_facets_params params = {.input = &input,
                                                    .size_px = {c->screen.width, c->screen.height},
                                                    .max_error_px = c->bounds_px[i],
                                                    .points = POINTS,
                                                    .seed = 11};
            st = ap_facets_look(err, &facets, &params, &c->errors[i]);
        }
    ap_facets_close(&facets);
    return st;
}

// Of all scenes.
struct findings {
    double of_bound;      // the worst error over what was asked for,
    double given_up;      // likewise where a frame says that it cannot hold the bound
    double over_coarsest; // the finest frame's cost over the coarsest's, at most
};

static enum ap_status measure(struct ap_error *err, const struct ap_bench *bench,
                              const struct ap_bench_view *view, FILE *csv,
                              struct findings *findings) {
    struct contest c = {.bench = bench,
                        .view = view,
                        .bounds_px = bench->quick ? BOUNDS_QUICK_PX : BOUNDS_PX,
                        .count = bench->quick ? BOUNDS_QUICK : BOUNDS};
    const uint32_t *size = ap_bench_sizes_px[bench->quick];
    enum ap_status st = ap_bench_open_room(err, view, size[0], &c.room);
    if (st)
        return st;
    st = ap_bench_screen_open(err, &bench->gpu, size[0], size[1], &c.screen);
    if (!st)
        st = time_all(err, &c);
    if (!st)
        st = look_all(err, &c);
    for (int i = 0; !st && i < c.count; i++) {
        const struct ap_bench_case *k = &c.cases[i];
        fprintf(csv, "\"%s\",%g,%.4g,%.4g,%.4g,%.3g,%ld,%u,%llu,%u\n", view->name, c.bounds_px[i],
                k->cost_ms.low, k->cost_ms.median, k->cost_ms.high,
                fmax(c.errors[i].worst_px, LEAST_PX), c.errors[i].points, c.errors[i].beyond_bound,
                (unsigned long long)(k->stats.eye[0].triangles + k->stats.eye[1].triangles),
                k->stats.refined);
        double *worst = c.errors[i].beyond_bound ? &findings->given_up : &findings->of_bound;
        *worst = fmax(*worst, c.errors[i].worst_px / c.bounds_px[i]);
    }
    struct ap_spread finest = ap_bench_ratio(bench, &c.cases[c.count - 1], &c.cases[0]);
    findings->over_coarsest = st ? 0 : fmax(findings->over_coarsest, finest.median);
    ap_bench_screen_close(&c.screen);
    ap_room_close(&c.room);
    return st;
}

// Rows of a scene follow one another; gnuplot's strcol() ends at a comma in a name.
static const char SCRIPT[] =
    "set logscale xy\nset xrange [0.0008:6]\nset multiplot layout 1,2 title heading\n"
    "set bmargin 8\nset key at screen 0.5, screen 0.02 center bottom horizontal maxrows 2 samplen 2\n"
    "set xlabel 'worst error found, px (left is better)'\nset ylabel cost\n"
    "set title 'each line: --max-error from 4 px (right) down to the left'\n"
    "plot for [i=1:words(names)] $data skip 1 every ::(bounds*(i-1))::(bounds*i-1) using 6:4:3:5 "
    "with yerrorlines pt 7 ps 0.7 lw 1.5 lc i title word(names,i)\n"
    "set key off\nset xrange [0.012:6]\nset yrange [0.0008:6]\n"
    "set xlabel '--max-error asked for, px'\nset ylabel 'worst error found, px (down is better)'\n"
    "set title 'below the broken line the promise is kept'\n"
    "plot x with lines dt 2 lw 2 lc rgb '#000000', "
    "for [i=1:words(names)] $data skip 1 every ::(bounds*(i-1))::(bounds*i-1) using 2:6 with "
    "linespoints pt 7 ps 0.7 lw 1.5 lc i\nunset multiplot\n";

static bool takes_part(const struct ap_bench *bench, int i) {
    return !bench->quick || i == 2 || i == 4; // the room in h3, walls of {5,3,4}
}

enum ap_status ap_bench_frames(struct ap_error *err, const struct ap_bench *bench) {
    const uint32_t *size = ap_bench_sizes_px[bench->quick];
    struct ap_bench_table table = {0};
    enum ap_status st = ap_bench_begin(err, "frames",
                                       "scene,max_error_px,ms_low,ms,ms_high,worst_px,points,parts_"
                                       "beyond_bound,triangles,refined",
                                       &table);
    char script[4096], names[512] = "", title[256];
    struct findings findings = {0, 0, 0};
    for (int i = 0; i < ap_bench_view_count; i++)
        if (takes_part(bench, i))
            snprintf(names + strlen(names), sizeof names - strlen(names), "\"%s\" ",
                     ap_bench_views[i].name);
    snprintf(script, sizeof script, "cost = '%s (down is better)'\nnames = '%s'\nbounds = %d\n%s",
             ap_bench_cost_name(bench), names, bench->quick ? BOUNDS_QUICK : BOUNDS, SCRIPT);
    for (int i = 0; !st && i < ap_bench_view_count; i++)
        if (takes_part(bench, i))
            st = measure(err, bench, &ap_bench_views[i], table.csv, &findings);
    int len = snprintf(
        title, sizeof title,
        "What a smaller error costs, frames of %ux%u pixels an eye: %g px up to %.1f "
        "times as much as 4 px\\nworst error found: %.2f of what was asked for",
        size[0], size[1], bench->quick ? 0.05 : 0.02, findings.over_coarsest, findings.of_bound);
    if (findings.given_up > 0)
        snprintf(title + len, sizeof title - (size_t)len,
                 "; %.2f where triangles run out, which is counted", findings.given_up);
    if (!st)
        st = ap_bench_end(err, bench, &table, title, bench->gpu.properties.deviceName, script);
    ap_bench_drop(&table);
    return st;
}
