#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/app/bench/bench.h"

// 6. The share of each stage, and what leaving out saves.

enum { SMALLER = 8 }; // to each side

static enum ap_status renderer_of(struct ap_error *err, const struct ap_bench *bench,
                                  const struct ap_room *room, const struct ap_bench_screen *screen,
                                  const struct ap_renderer_params *with,
                                  struct ap_renderer **renderer) {
    struct ap_renderer_params params = {
        .color_format = VK_FORMAT_R8G8B8A8_SRGB, .width = screen->width, .height = screen->height};
    ap_room_renderer_params(room, &params);
    params.max_error_px = with->max_error_px;
    params.no_cull = with->no_cull;
    params.samples = with->samples;
    params.now_ns = ap_bench_thread_ns;
    return ap_renderer_create(err, &bench->gpu, room->scene, &params, renderer);
}

// A full picture; the same triangles in a picture an 8th as wide and high, which leaves what
// vertices cost; a full one with one sample a pixel; nothing in a full one, which leaves clearing
// and averaging.
enum { FULL, SMALL, ONE, EMPTY, CASES };

static enum ap_status race_stages(struct ap_error *err, const struct ap_bench *bench,
                                  const struct ap_room room[2], const struct ap_bench_view *view,
                                  const struct ap_bench_screen screen[2],
                                  struct ap_bench_case cases[CASES]) {
    const struct ap_renderer_params with[CASES] = {[FULL] = {.max_error_px = 0.25},
                                                   [SMALL] = {.max_error_px = 0.25 / SMALLER},
                                                   [ONE] = {.max_error_px = 0.25, .samples = 1},
                                                   [EMPTY] = {.max_error_px = 0.25}};
    enum ap_status st = AP_OK;
    for (int i = 0; !st && i < CASES; i++) {
        cases[i].screen = &screen[i == SMALL];
        cases[i].input =
            ap_bench_input(room->scene, view, screen[i == SMALL].width, screen[i == SMALL].height);
        st = renderer_of(err, bench, &room[i == SMALL], cases[i].screen, &with[i],
                         &cases[i].renderer);
    }
    if (!st)
        st = ap_bench_race(err, bench, cases, EMPTY);
    for (size_t i = 0; i < room->scene->part_count; i++)
        room->scene->parts[i].hidden = true;
    if (!st)
        st = ap_bench_race(err, bench, &cases[EMPTY], 1);
    for (int i = 0; i < CASES; i++)
        ap_renderer_destroy(cases[i].renderer);
    return st;
}

// Shares of the cost: preparing is one thread's work on the processor and is not in a GPU's time.
static void write_stages(FILE *csv, const struct ap_bench_view *view, const struct ap_bench *bench,
                         const struct ap_bench_case c[CASES]) {
    const struct ap_bench_screen *screen = c[FULL].screen;
    double megapixels = 2e-6 * screen->width * screen->height, rest[CASES];
    for (int i = 0; i < CASES; i++)
        rest[i] = c[i].cost_ms.median -
                  (bench->software ? c[i].place_ms.median + c[i].record_ms.median : 0);
    double frame = rest[EMPTY], vertices = rest[SMALL] - frame / (SMALLER * SMALLER),
           pixels = rest[FULL] - frame - vertices;
    fprintf(csv, "\"%s\",%ux%u,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%llu,%u\n",
            view->name, screen->width, screen->height, c[FULL].cost_ms.low, c[FULL].cost_ms.median,
            c[FULL].cost_ms.high, c[FULL].place_ms.median, c[FULL].record_ms.median,
            fmax(vertices, 0), fmax(pixels, 0), fmax(frame, 0), c[FULL].cpu_ms.median / megapixels,
            c[ONE].cpu_ms.median / megapixels, c[FULL].gpu_ms.median,
            (unsigned long long)(c[FULL].stats.eye[0].triangles + c[FULL].stats.eye[1].triangles),
            c[FULL].stats.cells.visited);
}

static enum ap_status measure(struct ap_error *err, const struct ap_bench *bench,
                              const struct ap_bench_view *view, const uint32_t size[2], FILE *csv,
                              double *prepared) {
    struct ap_bench_case cases[CASES] = {{0}};
    struct ap_bench_screen screen[2] = {{0}};
    struct ap_room room[2] = {{0}}; // the second for the small picture
    enum ap_status st = ap_bench_open_room(err, view, size[0], &room[0]);
    if (!st)
        st = ap_bench_open_room(err, view, size[0], &room[1]);
    if (!st && room[1].scene->honeycomb)
        room[1].scene->honeycomb->horizon_px /= SMALLER;
    if (!st)
        st = ap_bench_screen_open(err, &bench->gpu, size[0], size[1], &screen[0]);
    if (!st)
        st = ap_bench_screen_open(err, &bench->gpu, size[0] / SMALLER, size[1] / SMALLER,
                                  &screen[1]);
    if (!st)
        st = race_stages(err, bench, room, view, screen, cases);
    if (!st)
        write_stages(csv, view, bench, cases);
    *prepared = fmax(*prepared, (cases[FULL].place_ms.median + cases[FULL].record_ms.median) /
                                    cases[FULL].cpu_ms.median);
    ap_bench_screen_close(&screen[0]);
    ap_bench_screen_close(&screen[1]);
    ap_room_close(&room[0]);
    ap_room_close(&room[1]);
    return st;
}

static const char STAGES[] =
    "set style data histograms\nset style histogram rowstacked\n"
    "set style fill solid 0.9 border -1\nset boxwidth 0.7\nset xtics rotate by -20\n"
    "set bmargin 9\nset key at screen 0.5, screen 0.015 center bottom horizontal maxrows 2\n"
    "stats $data skip 1 every ::0::(scenes-1) using ($6+$7+$8+$9+$10) nooutput\n"
    "set yrange [0:1.1*STATS_max]\n"
    "set title heading\nset ylabel cost\nset rmargin 8\n"
    "plot $data skip 1 every ::0::(scenes-1) using 6:xtic(1) title 'placing, culling, refining (one "
    "thread)' lc rgb '#1f77b4', '' skip 1 every ::0::(scenes-1) using 7 title 'recording' lc rgb "
    "'#9467bd', '' skip 1 every ::0::(scenes-1) using 8 title 'vertices and triangles' lc rgb "
    "'#2ca02c', '' skip 1 every ::0::(scenes-1) using 9 title 'pixels' lc rgb '#ff7f0e', '' skip 1 "
    "every ::0::(scenes-1) using 10 title 'clearing, averaging samples' lc rgb '#bbbbbb', '' skip 1 "
    "every ::0::(scenes-1) using 0:($6+$7+$8+$9+$10):(sprintf('%.0f ms a Mpx', $11)) with labels "
    "offset 0,0.7 font ',8' notitle\n";

enum ap_status ap_bench_stages(struct ap_error *err, const struct ap_bench *bench) {
    const uint32_t *shown = ap_bench_sizes_px[bench->quick];
    double prepared = 0, others = 0;
    struct ap_bench_table table = {0};
    enum ap_status st = ap_bench_begin(
        err, "stages",
        "scene,size_px,ms_low,ms,ms_high,place_ms,record_ms,vertices_ms,pixels_ms,"
        "clear_and_average_ms,cpu_ms_a_megapixel,one_sample_ms_a_megapixel,gpu_ms,triangles,cells",
        &table);
    for (int k = bench->quick; k < 2; k++)
        for (int i = 0; !st && i < ap_bench_view_count; i++)
            st = measure(err, bench, &ap_bench_views[i], ap_bench_sizes_px[k], table.csv,
                         k == bench->quick ? &prepared : &others);
    char script[2048], title[256];
    snprintf(script, sizeof script, "cost = '%s (down is better)'\nscenes = %d\n%s",
             ap_bench_cost_name(bench), ap_bench_view_count, STAGES);
    snprintf(title, sizeof title,
             "Where a frame's time goes: preparing it takes at most %.0f %%\\n%ux%u pixels an eye, "
             "--max-error 0.25 px",
             100 * prepared, shown[0], shown[1]);
    if (!st)
        st = ap_bench_end(err, bench, &table, title, bench->gpu.properties.deviceName, script);
    ap_bench_drop(&table);
    return st;
}

// --- leaving out

// The pixels, of all, that leaving out changes: none, but where cells are turned by the way to
// them.
static enum ap_status compare(struct ap_error *err, const struct ap_bench_case cases[2],
                              double *share) {
    size_t pixels = (size_t)2 * cases->screen->width * cases->screen->height, off = 0;
    uint32_t *with = malloc(pixels * sizeof *with);
    enum ap_status st = with ? ap_bench_picture(err, &cases[0])
                             : ap_fail(err, AP_ENVIRONMENT, "no memory for a picture");
    if (!st) {
        memcpy(with, cases->screen->pixels.mapped, pixels * sizeof *with);
        st = ap_bench_picture(err, &cases[1]);
    }
    const uint32_t *without = cases->screen->pixels.mapped;
    for (size_t i = 0; !st && i < pixels; i++)
        off += with[i] != without[i];
    free(with);
    *share = (double)off / (double)pixels;
    if (!st && *share > 1e-3)
        st = ap_fail(err, AP_ENVIRONMENT, "leaving out changes %.3g of all pixels", *share);
    return st;
}

static enum ap_status race_skips(struct ap_error *err, const struct ap_bench *bench,
                                 const struct ap_bench_view *view, const uint32_t size[2],
                                 FILE *csv, double *ratio) {
    struct ap_bench_case cases[2] = {{0}};
    struct ap_bench_screen screen = {0};
    struct ap_room room;
    double off = 0;
    enum ap_status st = ap_bench_open_room(err, view, size[0], &room);
    if (st)
        return st;
    st = ap_bench_screen_open(err, &bench->gpu, size[0], size[1], &screen);
    for (int i = 0; !st && i < 2; i++) {
        const struct ap_renderer_params with = {.max_error_px = 0.25, .no_cull = i == 1};
        cases[i].screen = &screen;
        cases[i].input = ap_bench_input(room.scene, view, size[0], size[1]);
        st = renderer_of(err, bench, &room, &screen, &with, &cases[i].renderer);
    }
    if (!st)
        st = compare(err, cases, &off);
    if (!st)
        st = ap_bench_race(err, bench, cases, 2);
    if (!st)
        *ratio = ap_bench_ratio(bench, &cases[0], &cases[1]).median;
    for (int i = 0; !st && i < 2; i++) {
        const struct ap_eye_stats *eye = cases[i].stats.eye;
        fprintf(csv, "\"%s\",%ux%u,%s,%.4g,%.4g,%.4g,%.3f,%.2g,%u,%u,%llu\n", view->name, size[0],
                size[1], i ? "off" : "on", cases[i].cost_ms.low, cases[i].cost_ms.median,
                cases[i].cost_ms.high, ap_bench_ratio(bench, &cases[i], &cases[1]).median, off,
                cases[i].stats.cells.visited, eye[0].draws + eye[1].draws,
                (unsigned long long)(eye[0].triangles + eye[1].triangles));
    }
    for (int i = 0; i < 2; i++)
        ap_renderer_destroy(cases[i].renderer);
    ap_bench_screen_close(&screen);
    ap_room_close(&room);
    return st;
}

static const char SKIPS[] =
    "set style data histograms\nset style histogram errorbars gap 1 lw 1\n"
    "set style fill solid 0.9 border -1\nset yrange [0:*]\nset offsets graph 0, 0, 0.1, 0\n"
    "set xtics rotate by -20\nset bmargin 7\nset key at screen 0.5, screen 0.015 center bottom horizontal\nset title heading\n"
    "set ylabel cost\nset rmargin 8\n"
    "plot $data skip 1 every 2::0 using 5:4:6:xtic(1) title 'what no eye can see is left out' lc rgb "
    "'#1f77b4', $data skip 1 every 2::1 using 5:4:6 title 'all of it drawn (--no-cull): the same "
    "picture' lc rgb '#d62728', $data skip 1 every 2::0 using ($0-0.17):6:(sprintf('%.2f', $7)) with "
    "labels offset 0,0.7 font ',8' notitle\n";

enum ap_status ap_bench_skips(struct ap_error *err, const struct ap_bench *bench) {
    const uint32_t *size = ap_bench_sizes_px[bench->quick];
    double least = INFINITY, most = 0;
    struct ap_bench_table table = {0};
    enum ap_status st = ap_bench_begin(err, "skips",
                                       "scene,size_px,skips,ms_low,ms,ms_high,of_all_drawn,"
                                       "pixels_off,cells,draws,triangles",
                                       &table);
    for (int i = 0; !st && i < ap_bench_view_count; i++) {
        double ratio = 1;
        st = race_skips(err, bench, &ap_bench_views[i], size, table.csv, &ratio);
        least = fmin(least, ratio);
        most = fmax(most, ratio);
    }
    char script[2048], title[256];
    snprintf(script, sizeof script, "cost = '%s (down is better)'\n%s", ap_bench_cost_name(bench),
             SKIPS);
    snprintf(
        title, sizeof title,
        "What leaving out saves: the same pictures for %.2f to %.2f of the cost (over the bars)\\n"
        "%ux%u pixels an eye",
        least, most, size[0], size[1]);
    if (!st)
        st = ap_bench_end(err, bench, &table, title, bench->gpu.properties.deviceName, script);
    ap_bench_drop(&table);
    return st;
}
