#ifndef ANTIPODE_APP_BENCH_BENCH_H
#define ANTIPODE_APP_BENCH_BENCH_H

#include "src/app/room.h"
#include "src/base/file.h"
#include "src/render/renderer.h"

// `antipode bench`: work against precision. What each measurement shares; each is a file of its own
// and a line in bench.c.

// Repeated measurements of one thing: quartiles and median.
struct ap_spread {
    double low, median, high;
};

struct ap_bench {
    const char *out;
    bool quick;
    int rounds;        // of interleaved repetitions
    char machine[128]; // the processor, as it calls itself
    // The device that draws; has_gpu false where there is none.
    bool has_gpu, software;
    struct ap_gpu gpu;
};

enum { AP_BENCH_ROUNDS_MAX = 64 };

// CPU time of all threads of the process: on a software device the drawing itself, and independent
// of who else runs.
double ap_bench_cpu_ms(void);

// Sorts the values.
struct ap_spread ap_bench_spread(double *values, int count);

// DIR/NAME.csv and the plot of it. Rows are written to `csv`; ap_bench_end writes the file and, by
// a script that finds the table as $data, NAME.png and NAME.gnuplot, which repeats the plot. The
// title gets the device's or the processor's name as its second line.
struct ap_bench_table {
    FILE *csv;
    char *text;
    size_t size;
    const char *name;
};
enum ap_status ap_bench_begin(struct ap_error *err, const char *name, const char *header,
                              struct ap_bench_table *table);
enum ap_status ap_bench_end(struct ap_error *err, const struct ap_bench *bench,
                            struct ap_bench_table *table, const char *title, const char *device,
                            const char *script);
// Where something failed: drops what was written.
void ap_bench_drop(struct ap_bench_table *table);

// --- drawing

// Images to draw into, two layers of one.
struct ap_bench_screen {
    const struct ap_gpu *gpu;
    uint32_t width, height;
    struct ap_gpu_image image;
    struct ap_gpu_buffer pixels; // RGBA, eye after eye
};
enum ap_status ap_bench_screen_open(struct ap_error *err, const struct ap_gpu *gpu, uint32_t width,
                                    uint32_t height, struct ap_bench_screen *screen);
void ap_bench_screen_close(struct ap_bench_screen *screen);

// A scene and where it is seen from.
struct ap_bench_view {
    const char *name;  // in tables
    const char *scene; // NULL: billiards
    const char *space;
    struct ap_vec3 at_m;
    double pitch_rad;
};
extern const struct ap_bench_view ap_bench_views[];
extern const int ap_bench_view_count;
// Of an eye's picture: as in a headset; small, the only one of a quick look.
extern const uint32_t ap_bench_sizes_px[2][2];
// The horizon of a world of cells is taken for pixels of a picture 320 wide, so that pictures of
// any width show the same cells; width_px 0: as it is.
enum ap_status ap_bench_open_room(struct ap_error *err, const struct ap_bench_view *view,
                                  uint32_t width_px, struct ap_room *room);

// Two eyes 64 mm apart, 100 degrees wide, square pixels.
struct ap_frame_input ap_bench_input(const struct ap_scene *scene, const struct ap_bench_view *view,
                                     uint32_t width, uint32_t height);

// One contender of a comparison: what is drawn and what it took.
struct ap_bench_case {
    const struct ap_bench_screen *screen;
    struct ap_renderer *renderer;
    struct ap_frame_input input;
    struct ap_frame_stats stats; // of the last frame
    // CPU of all threads (software) or the GPU's own time, round by round and their spread.
    double round_ms[AP_BENCH_ROUNDS_MAX];
    struct ap_spread cost_ms;
    struct ap_spread place_ms, record_ms; // CPU of the calling thread, if its renderer has…
    struct ap_spread cpu_ms, gpu_ms;      // of all threads; by the device's clock
};
int64_t ap_bench_thread_ns(void); // …this as its clock

// Every contender draws once in every round, there and back in turn, the nose moved a little from
// round to round; the first two rounds (one of a quick look) compile and are not counted.
enum ap_status ap_bench_race(struct ap_error *err, const struct ap_bench *bench,
                             struct ap_bench_case *cases, int count);
// a's cost over b's, round by round.
struct ap_spread ap_bench_ratio(const struct ap_bench *bench, const struct ap_bench_case *a,
                                const struct ap_bench_case *b);
// Draws and reads both eyes back into screen->pixels.
enum ap_status ap_bench_picture(struct ap_error *err, const struct ap_bench_case *c);

// What cost_ms is called in a plot.
const char *ap_bench_cost_name(const struct ap_bench *bench);

// --- the measurements

enum ap_status ap_bench_logmap(struct ap_error *err, const struct ap_bench *bench);
enum ap_status ap_bench_frames(struct ap_error *err, const struct ap_bench *bench);
enum ap_status ap_bench_walkers(struct ap_error *err, const struct ap_bench *bench);
enum ap_status ap_bench_growth(struct ap_error *err, const struct ap_bench *bench);
enum ap_status ap_bench_curvature(struct ap_error *err, const struct ap_bench *bench);
enum ap_status ap_bench_stages(struct ap_error *err, const struct ap_bench *bench);
enum ap_status ap_bench_skips(struct ap_error *err, const struct ap_bench *bench);

#endif
