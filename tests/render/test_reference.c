// The renderer's pictures against a reference that finds what each pixel sees in double: rooms and
// worlds of cells in all spaces, both views, both eyes, from random and from awkward places, and
// along real recordings. `test_reference --places N` looks from N places at each scene in each view
// at each bound; --help says what else it takes.
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/device/timeline.h"
#include "src/track/tracker.h"
#include "tests/render/compare.h"
#include "tests/render/exact.h"
#include "tests/render/stage.h"

static const double PI = 3.14159265358979323846;
// A headset's pictures, of which the test looks at a piece or (coarsely) at all.
static const double HEADSET_PX[2] = {1440, 1600};
// What an edge may lie beyond the bound by: corners are rounded to 1/256 px, and float32.
static const double ROUNDING_PX = 0.02;

// Cells that are seen with a radius of less than this (a tangent) are not drawn.
static const double HORIZON = 0.3;

static struct stage stage;
static struct {
    int places; // in each row; 0: the suite's short run
    int size;   // of a picture, pixels
    int seed;
    int first;            // place
    const char *scene;    // a part of its name
    const char *view;     // NULL: all
    double bound_px;      // 0: all
    const char *pictures; // the beginning of their names; NULL: none
} run = {.size = 20, .scene = ""};
static struct probe probe;
static struct exact_random random_of = {5};

static double uniform(double low, double high) {
    return exact_uniform(&random_of, low, high);
}

static struct ap_vec3 any_direction(void) {
    struct ap_vec3 v;
    double r;
    do {
        v = (struct ap_vec3){uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
        r = ap_vec3_length(v);
    } while (r > 1 || r < 0.1);
    return ap_vec3_scale(1 / r, v);
}

static struct ap_iso any_turn(void) {
    struct ap_quat q = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
    return ap_iso_rotate(ap_quat_normalize(q));
}

// −z along d, +y as well as may be up.
static struct ap_iso looking_along(struct ap_vec3 d) {
    struct ap_vec3 z = ap_vec3_scale(-1, ap_vec3_normalize(d)), up = {0.01, 1, 0.02};
    struct ap_vec3 x = ap_vec3_normalize(ap_vec3_cross(up, z)), y = ap_vec3_cross(z, x);
    struct ap_iso m = AP_ISO_IDENTITY;
    const struct ap_vec3 column[3] = {x, y, z};
    for (int j = 0; j < 3; j++) {
        m.m[0][j] = column[j].x;
        m.m[1][j] = column[j].y;
        m.m[2][j] = column[j].z;
    }
    return m;
}

// Stands at v (tangent vector at `from`), looks at a point near `from`'s.
static struct ap_iso looking_back(struct ap_space space, struct ap_iso from, struct ap_vec3 v) {
    struct ap_iso there = ap_iso_mul(from, ap_iso_translate(space, v));
    struct ap_vec3 back = ap_vec3_scale(-1, ap_vec3_normalize(v));
    struct ap_vec3 aside = ap_vec3_scale(0.2, any_direction());
    return ap_iso_mul(there, looking_along(ap_vec3_add(back, aside)));
}

// Where somebody stands at the table.
static struct ap_iso at_table(const struct ap_scene *scene) {
    struct ap_space space = scene->space;
    double unit = space.kappa > 0 ? fmin(1, 0.8 * space.rho_m) : 1, a = uniform(0, 2 * PI);
    struct ap_vec3 v = {unit * uniform(0.3, 1.1) * sin(a), unit * uniform(0.15, 0.9),
                        unit * uniform(0.3, 1.1) * cos(a)};
    return looking_back(space, AP_ISO_IDENTITY, v);
}

// Close to some part, or in s3 now and then next to its antipode.
static struct ap_iso at_part(const struct ap_scene *scene) {
    const struct ap_part *part;
    do
        part = &scene->parts[(size_t)uniform(0, (double)scene->part_count)];
    while (part->carrier != AP_CARRIER_WORLD);
    struct ap_space space = scene->space;
    double gap = exp(uniform(log(0.006), log(0.2))), r = fmax(part->radius_m, part->radius2_m);
    struct ap_vec3 v = ap_vec3_scale(r + gap, any_direction());
    if (part->kind == AP_PART_POLYGON) {
        double a = uniform(0, 2 * PI), far = uniform(0, 0.8 * part->edge_m);
        v = (struct ap_vec3){far * sin(a), (uniform(-1, 1) < 0 ? -1 : 1) * gap, far * cos(a)};
    } else if (part->kind == AP_PART_STICK) {
        double a = uniform(0, 2 * PI);
        v = (struct ap_vec3){(r + gap) * sin(a), (r + gap) * cos(a),
                             uniform(-0.5, 0.5) * part->length_m};
    } else if (part->kind == AP_PART_SOLID) {
        v = ap_vec3_scale(0.3 + gap, any_direction());
    }
    if (space.kappa > 0 && uniform(0, 1) < 0.3)
        v = ap_vec3_scale(PI * space.rho_m - gap, ap_vec3_normalize(v));
    struct ap_iso there = ap_iso_mul(part->carrier_from_part, ap_iso_translate(space, v));
    struct ap_vec3 along =
        ap_vec3_normalize((struct ap_vec3){uniform(-1, 1), -0.05 * v.y / gap, uniform(-1, 1)});
    return ap_iso_mul(there, uniform(0, 1) < 0.5 ? any_turn() : looking_along(along));
}

// Anywhere in the cell, or close to a face, an edge or a corner.
static struct ap_iso in_cell(const struct ap_scene *scene, bool close) {
    const struct ap_tiling *t = &scene->honeycomb->tiling;
    struct ap_vec3 at;
    bool inside;
    do {
        at = ap_vec3_scale(uniform(0, 1) * t->circumradius_m, any_direction());
        if (close) {
            int k = (int)uniform(0, 3), f = (int)uniform(0, t->face_count);
            int e = (int)uniform(0, t->edge_count);
            const struct ap_vec4 p = t->vertex_m[(int)uniform(0, t->vertex_count)];
            struct ap_vec3 v = ap_vec3_normalize((struct ap_vec3){p.x, p.y, p.z});
            struct ap_vec3 to = k == 0   ? ap_vec3_scale(t->inradius_m, t->face_out[f])
                                : k == 1 ? ap_vec3_scale(t->midradius_m, t->edge_out[e])
                                         : ap_vec3_scale(t->circumradius_m, v);
            at = ap_vec3_add(to, ap_vec3_scale(exp(uniform(log(0.01), log(0.4))), any_direction()));
        }
        inside = true;
        for (int f = 0; inside && f < t->face_count; f++)
            inside = ap_tiling_beyond(t, ap_exp(scene->space, at), f) < 0;
    } while (!inside);
    return ap_iso_mul(ap_iso_translate(scene->space, at), any_turn());
}

// All of a headset's picture, or a piece of it as fine as the headset's.
static void set_frusta(struct ap_viewer *viewer, bool whole) {
    double left = -1.2, right = 1.0, up = 1.1, down = -1.1;
    double across = (right - left) * probe.width / HEADSET_PX[0];
    double tall = (up - down) * probe.height / HEADSET_PX[1];
    double x = uniform(left, right - across), y = uniform(down, up - tall);
    for (int e = 0; e < 2; e++)
        viewer->eye[e].frustum = whole ? (struct ap_frustum){left, right, up, down}
                                       : (struct ap_frustum){x, x + across, y + tall, y};
}

static struct ap_frame_input frame_of(const struct ap_scene *scene, enum ap_view_mode mode, int i) {
    struct ap_frame_input input = {.viewer = exact_viewer(&random_of, scene->space.kappa, mode),
                                   .plain = true};
    input.viewer.space = scene->space;
    set_frusta(&input.viewer, i % 2 == 0);
    bool awkward = i % 4 >= 2;
    const struct ap_frustum *f = &input.viewer.eye[0].frustum;
    if (scene->honeycomb) { // as far in a piece of a picture as in a whole one
        scene->honeycomb->horizon_px = HORIZON * probe.width / (f->right - f->left);
        input.viewer.world_from_nose = in_cell(scene, awkward);
    } else
        input.viewer.world_from_nose = awkward ? at_part(scene) : at_table(scene);
    for (int hand = 0; hand < 2; hand++) {
        // Behind her, where s3 shows them the long way round, or before her.
        double ahead = (i % 3 == 1 ? -1 : 1) * uniform(0.4, 0.6);
        struct ap_vec3 v = {uniform(-0.3, 0.3), uniform(-0.3, 0.1), -ahead};
        input.hand_tracked[hand] = !scene->honeycomb;
        input.world_from_hand[hand] =
            ap_iso_mul(input.viewer.world_from_nose,
                       ap_iso_mul(ap_iso_translate(scene->space, v), any_turn()));
    }
    return input;
}

static struct ap_scene *open_scene(const char *name) {
    struct ap_scene *scene = NULL;
    struct ap_scene_params params = {0};
    if (ap_scene_is_named(name)) {
        STAGE_CHECK(ap_scene_named(&stage_error, name, &params, &scene));
    } else {
        params.space_name = name;
        params.side_pockets = true;
        STAGE_CHECK(ap_scene_billiards(&stage_error, &params, &scene));
    }
    // Unlit balls would be discs, whose rims are computed: tests/render/test_centroid.c.
    for (size_t i = 0; i < scene->part_count; i++)
        scene->parts[i].lit = true;
    return scene;
}

// What a row of the table is about: frames where the renderer held the bound, and others.
struct row {
    const char *name;
    enum ap_view_mode mode;
    double bound_px;
    struct compare_tally held, over;
};

static void print_three(struct compare_values *v, const char *format) {
    printf(" |");
    printf(format, compare_quantile(v, 1));
    printf(format, compare_quantile(v, 0.99));
    printf(format, compare_quantile(v, 0.5));
}

static bool report(struct row *row) {
    struct compare_tally *t = &row->held;
    double most_px = row->bound_px + ROUNDING_PX, edge = compare_quantile(&t->edge_px, 1);
    double direction = compare_quantile(&t->direction_px, 1);
    bool bad = !(edge <= most_px) || !(direction <= most_px) ||
               !(compare_quantile(&t->near_px, 1) <= most_px) ||
               !(compare_quantile(&t->bare_px, 1) <= 4 * most_px) ||
               !(compare_quantile(&t->seam_px, 1) <= 2 * most_px) || t->strange > 0 ||
               (t->pixels > 10000 && t->depth.count < 1000);
    printf("%-24.24s %-7s %4.2f | %3ld %7ld %5.0f", row->name, ap_view_mode_name(row->mode),
           row->bound_px, t->frames, t->pixels,
           1e6 * (double)(t->edge_px.count + t->seam_px.count) / (double)(t->pixels + 1));
    print_three(&t->edge_px, " %5.3f");
    printf(" | %2zu %5.3f", t->seam_px.count, compare_quantile(&t->seam_px, 1));
    print_three(&t->depth, " %7.1e");
    print_three(&t->direction_px, " %6.4f");
    printf(" %6.3f", compare_quantile(&t->direction_arcmin, 1));
    if (t->antipode + row->over.antipode > 0)
        printf(" | near antipode %ld, %ld differ, %ld off", t->antipode + row->over.antipode,
               t->antipode_differ + row->over.antipode_differ,
               t->antipode_off + row->over.antipode_off);
    if (t->near_px.count > 0)
        printf(" | at the eye %.3f", compare_quantile(&t->near_px, 1));
    if (t->bare_px.count > 0)
        printf(" | bare %.3f", compare_quantile(&t->bare_px, 1));
    if (row->over.frames > 0)
        printf(" | bound not held in %ld frames: edge %.3f, direction %.3f", row->over.frames,
               compare_quantile(&row->over.edge_px, 1),
               compare_quantile(&row->over.direction_px, 1));
    printf("%s\n", bad ? "  FAILED" : "");
    if (bad || run.places > 0)
        printf("    edge: %s\n    seam: %s\n    direction: %s\n", t->worst_edge, t->worst_seam,
               t->worst_direction);
    fflush(stdout);
    return !bad;
}

static void finish(struct row *row) {
    compare_tally_finish(&row->held);
    compare_tally_finish(&row->over);
}

// False: nothing to be compared was there.
static bool look(struct probe_world *world, const struct ap_frame_input *input, int place,
                 struct row *row) {
    struct compare_tally t = {.place = place};
    char path[512];
    snprintf(path, sizeof path, "%s-%.24s-%s-%.2f-%d", run.pictures ? run.pictures : "", row->name,
             ap_view_mode_name(row->mode), row->bound_px, place);
    bool done = compare_frame(&probe, world, input, row->bound_px, run.pictures ? path : NULL, &t);
    compare_tally_add(t.beyond ? &row->over : &row->held, &t);
    compare_tally_finish(&t);
    return done;
}

static const double BOUNDS[] = {0.25, 0.05, 1};
enum { BOUND_COUNT = sizeof BOUNDS / sizeof *BOUNDS };

// Whether a row is asked for. turn: which bound a short run takes.
static bool is_asked(const struct row *row, int b, int turn) {
    if (run.view && strcmp(run.view, ap_view_mode_name(row->mode)) != 0)
        return false;
    if (run.bound_px > 0)
        return row->bound_px == run.bound_px;
    return run.places > 0 || b == (turn + (int)row->mode) % BOUND_COUNT;
}

// Each place by itself, so that one can be seen again without those before it.
static void begin_place(int row, int place) {
    random_of.seed = 1000003u * (uint64_t)(run.seed + 1) + 1009u * (uint64_t)row + (uint64_t)place;
    for (int i = 0; i < 4; i++) // what is near of seeds is near of the first numbers
        uniform(0, 1);
}

static int look_at_scene(const char *name, int places, int turn) {
    struct probe_world world;
    struct ap_scene *scene = open_scene(name);
    int failures = 0;
    probe_world_open(&world, &stage.gpu, scene);
    for (int mode = AP_VIEW_NATIVE; mode <= AP_VIEW_TOURIST; mode++)
        for (int b = 0; b < BOUND_COUNT; b++) {
            struct row row = {.name = name, .mode = (enum ap_view_mode)mode, .bound_px = BOUNDS[b]};
            if (!is_asked(&row, b, turn))
                continue;
            for (int i = run.first; i < run.first + places; i++) {
                begin_place(20 * turn + 3 * mode + b, i);
                for (int tries = 0; tries < 20; tries++) {
                    struct ap_frame_input input = frame_of(scene, row.mode, i + turn % 2 * 2);
                    if (look(&world, &input, i, &row))
                        break;
                }
            }
            failures += !report(&row);
            finish(&row);
        }
    probe_world_close(&world);
    ap_scene_destroy(scene);
    return failures;
}

static const struct recording {
    const char *file;
    bool z_up;
} RECORDINGS[] = {{"desk_walk_head.csv", false},         {"quest3_iwer.json", false},
                  {"vive_room_aframe.json", false},      {"vive_crouch_aframe.json", false},
                  {"quest2_beatsaber_60s.bsor", false},  {"vivepro2_beatsaber_60s.bsor", false},
                  {"tum_fr2_desk_groundtruth.txt", true}};
enum { RECORDING_COUNT = sizeof RECORDINGS / sizeof *RECORDINGS };

// The poses of a recording at the table, evenly.
static void follow(const struct recording *recording, const char *shared, int poses, int turn,
                   struct probe_world *world, struct row rows[2]) {
    char path[1024];
    const char *source = path;
    snprintf(path, sizeof path, "%s/data/poses/%s", shared, recording->file);
    const struct ap_poselog_params params = {.sources = &source,
                                             .source_count = 1,
                                             .z_up = recording->z_up,
                                             .skip_bad = true, // one has the same time twice
                                             .head_frame = recording->z_up ? AP_HEAD_FRAME_OPTICAL
                                                                           : AP_HEAD_FRAME_HEAD};
    const struct ap_tracker_params track = {.kind = AP_TRACKER_BILLIARDS,
                                            .space = world->scene->space,
                                            .table_height_m = world->scene->table_height_m,
                                            .table_edge_m = world->scene->table_edge_m};
    struct ap_poselog *log = NULL;
    struct ap_timeline *timeline = NULL;
    struct ap_tracker *tracker = NULL;
    STAGE_CHECK(ap_poselog_open(&stage_error, &params, &log));
    STAGE_CHECK(ap_timeline_load(&stage_error, log, &timeline));
    STAGE_CHECK(ap_tracker_create(&stage_error, &track, &tracker));
    int64_t t0 = ap_timeline_start_ns(timeline), t1 = ap_timeline_end_ns(timeline);
    for (int i = 0; i < poses; i++) {
        struct row *row = &rows[(i + turn) % 2];
        begin_place(1000 + turn, i);
        struct ap_frame_input input = frame_of(world->scene, row->mode, i / 2 + turn);
        int64_t t = t0 + (int64_t)((double)(t1 - t0) * (i + uniform(0, 1)) / poses);
        static const char *const NAMES[] = {"head", "left", "right"};
        for (int k = 0; k < 3; k++) {
            int device = ap_timeline_find_device(timeline, NAMES[k]);
            struct ap_sample sample;
            struct ap_iso *to =
                k == 0 ? &input.viewer.world_from_nose : &input.world_from_hand[k - 1];
            bool has_row = false;
            if (device >= 0 && ap_timeline_at(timeline, device, t, &sample) != AP_POSE_NONE)
                STAGE_CHECK(
                    ap_tracker_feed(&stage_error, tracker, NAMES[k], sample.pose, &has_row, to));
            if (k > 0)
                input.hand_tracked[k - 1] = has_row;
        }
        look(world, &input, i, row);
    }
    ap_tracker_destroy(tracker);
    ap_timeline_destroy(timeline);
    ap_poselog_close(log);
}

static int look_at_recordings(const char *name, const char *space, int turn) {
    const char *shared = getenv("ANTIPODE_SHARED");
    struct probe_world world;
    int failures = 0;
    if (!shared) {
        printf("skipped: recordings in %s (ANTIPODE_SHARED is not set)\n", space);
        return 0;
    }
    struct ap_scene *scene = open_scene(space);
    probe_world_open(&world, &stage.gpu, scene);
    for (int b = 0; b < BOUND_COUNT; b++) {
        struct row rows[2] = {{.name = name, .mode = AP_VIEW_NATIVE, .bound_px = BOUNDS[b]},
                              {.name = name, .mode = AP_VIEW_TOURIST, .bound_px = BOUNDS[b]}};
        if (!is_asked(&rows[0], b, turn))
            continue;
        for (int i = 0; i < RECORDING_COUNT; i++)
            if (run.places > 0 || i % 3 == turn % 3)
                follow(&RECORDINGS[i], shared, run.places > 0 ? run.places : 1, i / 3, &world,
                       rows);
        for (int i = 0; i < 2; i++) {
            failures += !report(&rows[i]);
            finish(&rows[i]);
        }
    }
    probe_world_close(&world);
    ap_scene_destroy(scene);
    return failures;
}

static int usage(void) {
    printf(
        "test_reference [--places N] [--first I] [--size PX] [--seed S] [--scene NAME]\n"
        "               [--view native|tourist|native-of] [--bound 0.25|0.05|1]\n"
        "               [--pictures PREFIX]\n"
        "N places in each row, from place I on: a place depends on the scene, the view, the\n"
        "bound, S and its number alone. NAME: scenes whose names hold it. PREFIX-….png: what is\n"
        "drawn, what is to be seen, both.\n");
    return 2;
}

static bool read_options(int argc, char **argv) {
    static const struct option OPTIONS[] = {
        {"places", 1, NULL, 'p'}, {"first", 1, NULL, 'f'},    {"size", 1, NULL, 's'},
        {"seed", 1, NULL, 'r'},   {"scene", 1, NULL, 'n'},    {"view", 1, NULL, 'v'},
        {"bound", 1, NULL, 'b'},  {"pictures", 1, NULL, 'o'}, {NULL, 0, NULL, 0}};
    int c;
    while ((c = getopt_long(argc, argv, "", OPTIONS, NULL)) != -1) {
        int number = optarg ? atoi(optarg) : 0;
        if (c == 'p')
            run.places = number;
        else if (c == 'f')
            run.first = number;
        else if (c == 's')
            run.size = number;
        else if (c == 'r')
            run.seed = number;
        else if (c == 'n')
            run.scene = optarg;
        else if (c == 'v')
            run.view = optarg;
        else if (c == 'b')
            run.bound_px = atof(optarg);
        else if (c == 'o')
            run.pictures = optarg;
        else
            return false;
    }
    return optind == argc && run.size >= 8 && run.size <= 2000 && run.places >= 0;
}

int main(int argc, char **argv) {
    static const struct {
        const char *name;
        int places; // of a short run
    } SCENES[] = {{"h3", 2},
                  {"e3", 2},
                  {"s3", 2},
                  {"honeycomb:5,3,4,walls,struts,balls", 1},
                  {"honeycomb:4,3,5,walls,struts,balls", 0},
                  {"honeycomb:3,5,3,walls,struts,balls", 0},
                  {"honeycomb:5,3,5,walls,struts,balls", 0},
                  {"honeycomb:4,3,4,walls,struts,balls", 0},
                  {"honeycomb:3,3,3,walls,struts,balls", 0},
                  {"honeycomb:4,3,3,walls,struts,balls", 1},
                  {"honeycomb:3,3,4,walls,struts,balls", 0},
                  {"honeycomb:3,4,3,walls,struts,balls", 0},
                  {"honeycomb:5,3,3,walls,balls", 0},
                  {"honeycomb:3,3,5,balls", 0},
                  {"torus,walls,struts,balls", 1},
                  {"poincare-dodecahedral,walls", 1},
                  {"seifert-weber,walls,struts,balls", 1},
                  {"mirrored-dodecahedron,walls,struts,balls", 0}};
    int failures = 0;
    if (!read_options(argc, argv))
        return usage();
    if (!stage_open(&stage, 64, 64, false))
        return 77;
    probe_open(&probe, &stage.gpu, (uint32_t)run.size, (uint32_t)run.size);
    printf(
        "scene, view, bound px | frames, pixels, of a million differ | those off by px: worst, 99 "
        "%%, half | seams, px | depth, relative | direction "
        "px, worst arcmin\n");
    for (size_t s = 0; s < sizeof SCENES / sizeof *SCENES; s++)
        if (strstr(SCENES[s].name, run.scene) && (run.places > 0 || SCENES[s].places > 0))
            failures += look_at_scene(SCENES[s].name,
                                      run.places > 0 ? run.places : SCENES[s].places, (int)s);
    static const char *const SPACES[] = {"h3", "e3", "s3"};
    static const char *const NAMES[] = {"h3, recordings", "e3, recordings", "s3, recordings"};
    for (int s = 0; s < 3; s++)
        if (strstr(NAMES[s], run.scene))
            failures += look_at_recordings(NAMES[s], SPACES[s], s);
    probe_close(&probe);
    stage_close(&stage);
    return failures > 0;
}
