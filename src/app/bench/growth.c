#include <math.h>
#include <stdlib.h>
#include <unistd.h>

#include "src/app/bench/bench.h"
#include "src/geom/cells.h"
#include "src/render/place/frame.h"
#include "src/view/portal.h"

// 4. Growth: what a frame costs against the cells that exist, and against those that are seen.

enum { HORIZONS = 7, HORIZONS_QUICK = 4, PICTURE_PX = 400 };
// Worlds that are drawn; half the pixels are eight times the cells in e3, four times in h3.
static const struct {
    const char *name, *scene;
    double horizons_px[HORIZONS], horizons_quick_px[HORIZONS_QUICK];
} DRAWN[] = {
    {"{5,3,4} struts", "honeycomb:5,3,4,struts", {80, 40, 20, 12, 8, 5, 3}, {80, 40, 20, 12}},
    {"{4,3,4} struts", "honeycomb:4,3,4,struts", {80, 56, 40, 28, 20, 14, 10}, {80, 56, 40, 28}},
};
enum { DRAWN_COUNT = sizeof DRAWN / sizeof *DRAWN };

struct findings {
    size_t known;
    double walk_ms, test_ms;
};

static struct ap_frame_input look(const struct ap_scene *scene) {
    const struct ap_bench_view view = {.at_m = {0.1, 0.05, 0.2}, .pitch_rad = 0.2};
    return ap_bench_input(scene, &view, PICTURE_PX, PICTURE_PX);
}

// --- cells that exist: a world in which so many are known, and what finding the visible ones takes

// A third of the memory that nobody uses, at most 8 GiB: 10^7 cells take 3.
static size_t budget_bytes(void) {
    double pages = (double)sysconf(_SC_AVPHYS_PAGES), page = (double)sysconf(_SC_PAGESIZE);
    return (size_t)fmin(fmax(pages * page / 3, 0x1p26), 0x1p33);
}

// Asks for cells until so many are known, or the budget is used up.
static void populate(struct ap_cells *cells, size_t wanted) {
    for (size_t i = 0; i < cells->count && cells->count < wanted; i++)
        for (int face = 0; face < cells->tiling->face_count; face++)
            ap_cells_across(cells, (int32_t)i, face);
}

// All cells, one after the other, against both eyes' pyramids: what walking outward replaces.
static uint64_t test_all(const struct ap_cells *cells, const struct ap_viewer *viewer,
                         double horizon_m) {
    const struct ap_sides sides = ap_sides_of(viewer);
    const struct ap_iso nose_from_base = ap_iso_inverse(viewer->space, viewer->world_from_nose);
    const struct ap_vec4 base = {0, 0, 0, viewer->space.rho_m};
    uint64_t seen = 0;
    for (size_t i = 0; i < cells->count; i++) {
        struct ap_vec4 at = ap_iso_apply(&cells->cells[i].base_from_cell, base);
        at = ap_iso_apply(&nose_from_base, at);
        if (ap_vec3_length(ap_log_unchecked(viewer->space, at, 0)) > horizon_m)
            continue;
        double radius_m = cells->tiling->circumradius_m;
        seen += ap_sides_see_ball(&sides, viewer->space, at, radius_m, 0) != 0;
    }
    return seen;
}

// What finding takes, *last of walk and test.
static enum ap_status race_worlds(struct ap_error *err, const struct ap_bench *bench,
                                  const struct ap_room *room, size_t wanted, FILE *csv,
                                  struct findings *last) {
    static double walk_ms[AP_BENCH_ROUNDS_MAX], all_ms[AP_BENCH_ROUNDS_MAX];
    const struct ap_honeycomb *h = room->scene->honeycomb;
    const struct ap_frame_input input = look(room->scene);
    struct ap_cells *cells = NULL;
    struct ap_portal portal = {0};
    struct ap_portal_stats stats = {0};
    uint64_t found = 0;
    enum ap_status st = ap_cells_create(err, &h->tiling, &h->pairing, budget_bytes(), &cells);
    if (!st)
        populate(cells, wanted);
    double pixel = 2 * tan(50 * 3.14159265358979323846 / 180) / PICTURE_PX;
    const struct ap_portal_params params = {
        .viewer = &input.viewer,
        .horizon_m = ap_horizon_m(room->scene->space, h->tiling.circumradius_m, 40 * pixel)};
    int rounds = wanted > 200000 ? 3 : bench->rounds;
    for (int round = -1; !st && round < rounds; round++) {
        double a = ap_bench_cpu_ms();
        st = ap_portal_walk(err, cells, &params, &portal, &stats);
        double b = ap_bench_cpu_ms();
        found = test_all(cells, &input.viewer, params.horizon_m);
        double c = ap_bench_cpu_ms();
        if (round >= 0) {
            walk_ms[round] = b - a;
            all_ms[round] = c - b;
        }
    }
    if (!st && (found == 0 || stats.visited == 0))
        st = ap_fail(err, AP_ENVIRONMENT, "%u cells seen by walking, %llu by testing each",
                     stats.visited, (unsigned long long)found);
    if (!st) {
        struct ap_spread w = ap_bench_spread(walk_ms, rounds), a = ap_bench_spread(all_ms, rounds);
        fprintf(csv, "known,%zu,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%u,,\n", cells->count, w.low,
                w.median, w.high, a.low, a.median, a.high, stats.visited);
        *last = (struct findings){cells->count, w.median, a.median};
    }
    ap_portal_finish(&portal);
    ap_cells_destroy(cells);
    return st;
}

// --- cells that are seen: whole frames

// All that exists as far as the horizon, seen or not.
static enum ap_status count_within(struct ap_error *err, const struct ap_scene *scene,
                                   const struct ap_frame_input *input, size_t *count) {
    const struct ap_honeycomb *h = scene->honeycomb;
    struct ap_cells *cells = NULL;
    struct ap_portal portal = {0};
    struct ap_portal_stats stats = {0};
    struct ap_eyes eyes = ap_eyes_of(&input->viewer, PICTURE_PX, PICTURE_PX);
    const struct ap_portal_params params = {
        .viewer = &input->viewer,
        .horizon_m = ap_horizon_m(scene->space, h->tiling.circumradius_m,
                                  atan(h->horizon_px / fmax(eyes.pixels[0], eyes.pixels[1]))),
        .no_cull = true};
    enum ap_status st = ap_cells_create(err, &h->tiling, &h->pairing, budget_bytes(), &cells);
    if (!st)
        st = ap_portal_walk(err, cells, &params, &portal, &stats);
    *count = stats.visited;
    ap_portal_finish(&portal);
    ap_cells_destroy(cells);
    return st;
}

static enum ap_status draw_horizons(struct ap_error *err, const struct ap_bench *bench, int world,
                                    FILE *csv) {
    struct ap_bench_case cases[HORIZONS] = {{0}};
    struct ap_room room[HORIZONS] = {{0}};
    struct ap_bench_screen screen;
    int count = bench->quick ? HORIZONS_QUICK : HORIZONS;
    const double *horizon_px =
        bench->quick ? DRAWN[world].horizons_quick_px : DRAWN[world].horizons_px;
    enum ap_status st = ap_bench_screen_open(err, &bench->gpu, PICTURE_PX, PICTURE_PX, &screen);
    if (st)
        return st;
    for (int i = 0; !st && i < count; i++) {
        char text[96];
        snprintf(text, sizeof text, "%s,horizon=%g", DRAWN[world].scene, horizon_px[i]);
        const struct ap_bench_view view = {.scene = text};
        st = ap_bench_open_room(err, &view, 0, &room[i]);
        struct ap_renderer_params params = {
            .color_format = VK_FORMAT_R8G8B8A8_SRGB, .width = PICTURE_PX, .height = PICTURE_PX};
        cases[i].screen = &screen;
        if (st)
            break;
        cases[i].input = look(room[i].scene);
        st = ap_renderer_create(err, &bench->gpu, room[i].scene, &params, &cases[i].renderer);
    }
    if (!st)
        st = ap_bench_race(err, bench, cases, count);
    for (int i = 0; !st && i < count; i++) {
        const struct ap_bench_case *c = &cases[i];
        size_t within = 0;
        st = count_within(err, room[i].scene, &c->input, &within);
        fprintf(csv, "\"%s\",%zu,%.4g,%.4g,%.4g,,,,%u,%g,%llu\n", DRAWN[world].name, within,
                c->cost_ms.low, c->cost_ms.median, c->cost_ms.high, c->stats.cells.visited,
                horizon_px[i],
                (unsigned long long)(c->stats.eye[0].triangles + c->stats.eye[1].triangles));
    }
    for (int i = 0; i < HORIZONS; i++) {
        ap_renderer_destroy(cases[i].renderer);
        ap_room_close(&room[i]);
    }
    ap_bench_screen_close(&screen);
    return st;
}

static const char SCRIPT[] =
    "set logscale xy\nset multiplot layout 1,2 title heading\nset format x '10^%L'\n"
    "set xtics 1,10,1e8\nset format y '%g'\nset bmargin 9\n"
    "set key at screen 0.27, screen 0.02 center bottom samplen 3\n"
    "set title 'finding the cells of {5,3,4} that are seen'\n"
    "set xlabel 'cells that the program knows of'\nset ylabel 'CPU ms a frame (down is better)'\n"
    "set xrange [50:3e7]\nset yrange [0.01:1e4]\n"
    "plot $data skip 1 every ::0::(known-1) using 2:7:6:8 with yerrorlines pt 9 lw 1.5 lc rgb "
    "'#d62728' title 'by testing each cell that is known', '' skip 1 every ::0::(known-1) using "
    "2:4:3:5 with yerrorlines pt 7 lw 1.5 lc rgb '#1f77b4' title 'by walking from cell to cell (what "
    "is done)'\n"
    "set key at screen 0.77, screen 0.02 center bottom samplen 3\n"
    "set title 'whole frames of 400x400 px, the horizon ever farther'\n"
    "set xlabel 'cells'\nset ylabel cost\nset xrange [5:1e5]\nset yrange [10:2e4]\n"
    "rows(i) = known+horizons*(i-1)\n"
    "plot for [i=1:2] $data skip 1 every ::(rows(i))::(rows(i)+horizons-1) using 9:4:3:5 with "
    "yerrorlines pt 7 lw 1.5 lc i title word(names,i).', by cells drawn', for [i=1:2] '' skip 1 "
    "every ::(rows(i))::(rows(i)+horizons-1) using 2:4 with linespoints pt 6 dt 2 lc i title "
    "word(names,i).', by cells within the horizon', x with lines dt 3 lw 2 lc rgb '#888888' title "
    "'in proportion: 1 ms a cell'\nunset multiplot\n";

enum ap_status ap_bench_growth(struct ap_error *err, const struct ap_bench *bench) {
    static const size_t WORLDS[] = {100, 1000, 10000, 100000, 1000000, 10000000};
    const int known = bench->quick ? 3 : 6;
    struct findings last = {0, 0, 0};
    struct ap_bench_table table = {0};
    const struct ap_bench_view view = {.scene = "honeycomb:5,3,4,struts"};
    struct ap_room room;
    enum ap_status st = ap_bench_open_room(err, &view, 0, &room);
    if (st)
        return st;
    st = ap_bench_begin(err, "growth",
                        "what,cells,ms_low,ms,ms_high,all_ms_low,all_ms,all_ms_high,cells_drawn,"
                        "horizon_px,triangles",
                        &table);
    for (int i = 0; !st && i < known; i++)
        st = race_worlds(err, bench, &room, WORLDS[i], table.csv, &last);
    ap_room_close(&room);
    for (int i = 0; !st && bench->has_gpu && i < DRAWN_COUNT; i++)
        st = draw_horizons(err, bench, i, table.csv);
    char script[4096], device[512], title[256];
    snprintf(script, sizeof script,
             "cost = '%s (down is better)'\nnames = '\"%s\" \"%s\"'\n"
             "known = %d\nhorizons = %d\n%s",
             ap_bench_cost_name(bench), DRAWN[0].name, DRAWN[1].name, known,
             bench->quick ? HORIZONS_QUICK : HORIZONS, SCRIPT);
    snprintf(
        title, sizeof title,
        "Cost grows with what is seen, not with what exists: of %zu cells that are known, those "
        "seen are found in\\n%.2f ms by walking, %.1f ms by testing each",
        last.known, last.walk_ms, last.test_ms);
    snprintf(device, sizeof device, "%s; drawn by %.300s", bench->machine,
             bench->has_gpu ? bench->gpu.properties.deviceName : "nothing");
    if (!st)
        st = ap_bench_end(err, bench, &table, title, device, script);
    ap_bench_drop(&table);
    return st;
}
