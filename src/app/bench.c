#include <stdio.h>
#include <string.h>

#include "src/app/bench/bench.h"
#include "src/base/log.h"

static const char help[] =
    "Measures work against precision on this machine and writes, for each of these, a table\n"
    "(NAME.csv), a plot of it (NAME.png, where gnuplot is installed) and the script that draws the\n"
    "plot again (NAME.gnuplot) into DIR:\n"
    "  logmap     formulas of the log map: ns a point against the worst relative error\n"
    "  walkers    ns a step against the drift after a million steps\n"
    "  frames     cost of a frame against the worst pixel error, --max-error 4 px to 0.02 px\n"
    "  growth     cost of a frame against the cells that exist and those that are seen\n"
    "  curvature  the same meshes by a Euclidean pipeline, by tourist and native; one eye, two\n"
    "  stages     the share of each stage of a frame\n"
    "  skips      what leaving out what no eye can see saves\n"
    "Times are medians and quartiles of interleaved repetitions: CPU time of all threads where the\n"
    "Vulkan device is software, the GPU's own where it is not. Without a Vulkan device only what\n"
    "needs none is measured. docs/performance.md tells what the tables say.\n"
    "Exit statuses: 0; 2 usage; 4 DIR cannot be written, or what is asked for needs a device.";

static const struct {
    const char *name;
    enum ap_status (*run)(struct ap_error *err, const struct ap_bench *bench);
    bool needs_gpu;
} MEASUREMENTS[] = {
    {"logmap", ap_bench_logmap, false}, {"walkers", ap_bench_walkers, false},
    {"growth", ap_bench_growth, false}, {"curvature", ap_bench_curvature, true},
    {"stages", ap_bench_stages, true},  {"skips", ap_bench_skips, true},
    {"frames", ap_bench_frames, true},
};
enum { COUNT = sizeof MEASUREMENTS / sizeof *MEASUREMENTS, ROUNDS = 5, ROUNDS_QUICK = 3 };

// "logmap,stages": a bit each.
static enum ap_status parse_what(struct ap_error *err, const char *text, unsigned *what) {
    unsigned wanted = 0;
    for (const char *p = text; *p;) {
        size_t len = strcspn(p, ",");
        int found = -1;
        for (int i = 0; i < COUNT; i++)
            if (strlen(MEASUREMENTS[i].name) == len && !memcmp(MEASUREMENTS[i].name, p, len))
                found = i;
        if (found < 0)
            return ap_fail(err, AP_USAGE,
                           "--what: '%.*s': expected logmap, walkers, growth, curvature, stages, "
                           "skips or frames, separated by commas",
                           (int)len, p);
        wanted |= 1u << found;
        p += len + (p[len] == ',');
    }
    if (!wanted)
        return ap_fail(err, AP_USAGE, "--what: nothing to measure");
    *what = wanted;
    return AP_OK;
}

static void name_machine(char *name, size_t size) {
    char line[256];
    snprintf(name, size, "this processor");
    FILE *f = fopen("/proc/cpuinfo", "r");
    while (f && fgets(line, sizeof line, f)) {
        char *colon = strchr(line, ':');
        if (strncmp(line, "model name", 10) == 0 && colon) {
            colon[strcspn(colon, "\n")] = 0;
            snprintf(name, size, "%.100s", colon + 2);
            break;
        }
    }
    if (f)
        fclose(f);
}

static enum ap_status measure(struct ap_error *err, struct ap_bench *bench, unsigned what,
                              bool named) {
    struct ap_error why = {""};
    enum ap_status st = ap_make_dirs(err, bench->out);
    if (st)
        return st;
    bench->has_gpu =
        ap_gpu_create_headless(&why, &(struct ap_gpu_headless_params){0}, &bench->gpu) == AP_OK;
    bench->software =
        bench->has_gpu && bench->gpu.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
    for (int i = 0; !st && i < COUNT; i++) {
        if (!(what >> i & 1))
            continue;
        if (!MEASUREMENTS[i].needs_gpu || bench->has_gpu)
            st = MEASUREMENTS[i].run(err, bench);
        else if (named)
            st = ap_fail(err, AP_ENVIRONMENT, "%s: %s", MEASUREMENTS[i].name, why.text);
        else
            ap_log(AP_LOG_WARNING, "%s is left out: %s", MEASUREMENTS[i].name, why.text);
    }
    if (bench->has_gpu)
        ap_gpu_finish(&bench->gpu);
    return st;
}

static enum ap_status run_bench(struct ap_error *err, int argc, char **argv) {
    const char *list = NULL;
    struct ap_bench bench = {.out = "bench"};
    const struct ap_option options[] = {
        {"what", AP_OPTION_TEXT, &list, "logmap|walkers|growth|curvature|stages|skips|frames",
         "some of these, separated by commas (all)"},
        {"out", AP_OPTION_TEXT, &bench.out, "DIR", "where the tables go (bench)"},
        {"quick", AP_OPTION_FLAG, &bench.quick, "",
         "fewer repetitions, smaller pictures: to see that it works"},
    };
    const struct ap_usage usage = {.command = "bench",
                                   .operands = "",
                                   .text = help,
                                   .options = options,
                                   .option_count = sizeof options / sizeof *options};
    int operands;
    bool done;
    unsigned what = (1u << COUNT) - 1;
    enum ap_status st = ap_parse_options(err, &usage, argc, argv, &operands, &done);
    if (!st && !done && list)
        st = parse_what(err, list, &what);
    if (st || done)
        return st;
    bench.rounds = bench.quick ? ROUNDS_QUICK : ROUNDS;
    name_machine(bench.machine, sizeof bench.machine);
    return measure(err, &bench, what, list != NULL);
}

const struct ap_command ap_command_bench = {
    "bench", "measure cost against error on this machine, tables and plots", run_bench};
