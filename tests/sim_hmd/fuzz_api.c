#include <dlfcn.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "sim_hmd/core/negotiate.h"
#include "tests/sim_hmd/fuzz_api.h"

// Random call sequences with random values, straight into the runtime (the loader would catch some
// and crash on others): it may answer with any result, it may not crash, hang or leave a sanitizer
// anything to say. `fuzz_api [SEED [CALLS [THREADS]]]`; with one thread a seed repeats.

static _Thread_local uint64_t rng;

uint64_t fuzz_u64(void) {
    rng ^= rng << 13;
    rng ^= rng >> 7;
    rng ^= rng << 17;
    return rng;
}

// Three calls in five are right as far as they know, so that the runtime gets somewhere.
_Thread_local bool fuzz_tame;

bool fuzz_chance(unsigned percent) {
    return fuzz_u64() % 100 < percent;
}

uint32_t fuzz_below(uint32_t n) {
    return (uint32_t)(fuzz_u64() % n);
}

int64_t fuzz_i64(void) {
    static const int64_t edges[] = {0,          1,         -1,         2,          1000000000,
                                    1011111111, INT32_MAX, INT32_MIN,  INT64_MAX,  INT64_MIN,
                                    4096,       65535,     UINT32_MAX, -1000000000};
    return fuzz_chance(70) ? edges[fuzz_below(sizeof edges / sizeof edges[0])]
                           : (int64_t)fuzz_u64();
}

uint32_t fuzz_u32(void) {
    return fuzz_chance(60) ? fuzz_below(8) : (uint32_t)fuzz_i64();
}

float fuzz_float(void) {
    static const float edges[] = {0,
                                  1,
                                  -1,
                                  0.5F,
                                  -0.5F,
                                  1e-30F,
                                  1e30F,
                                  0.78F,
                                  -0.8F,
                                  1.57F,
                                  __builtin_nanf(""),
                                  __builtin_inff()};
    return edges[fuzz_below(sizeof edges / sizeof edges[0])];
}

XrPosef fuzz_pose(void) {
    XrPosef pose = {.orientation.w = 1};
    if (!fuzz_tame && fuzz_chance(30))
        pose.orientation = (XrQuaternionf){fuzz_float(), fuzz_float(), fuzz_float(), fuzz_float()};
    if (!fuzz_tame && fuzz_chance(50))
        pose.position = (XrVector3f){fuzz_float(), fuzz_float(), fuzz_float()};
    return pose;
}

XrFovf fuzz_fov(void) {
    return fuzz_tame || fuzz_chance(60)
               ? (XrFovf){-0.8F, 0.8F, 0.8F, -0.8F}
               : (XrFovf){fuzz_float(), fuzz_float(), fuzz_float(), fuzz_float()};
}

XrStructureType fuzz_type(XrStructureType right) {
    return fuzz_tame || fuzz_chance(93) ? right : (XrStructureType)fuzz_u32();
}

const void *fuzz_next(void) {
    static _Thread_local XrBaseInStructure chain[4];
    if (fuzz_tame || fuzz_chance(85))
        return NULL;
    for (int i = 0; i < 4; i++)
        chain[i] = (XrBaseInStructure){.type = (XrStructureType)fuzz_u32(),
                                       .next = i < 3 && fuzz_chance(50) ? &chain[i + 1] : NULL};
    return chain;
}

// --- handles: what was made, right or wrong, alive or dead

enum { POOL = 48 };
static _Atomic uint64_t pool[FUZZ_KINDS][POOL];

void fuzz_keep(enum fuzz_kind kind, uint64_t handle) {
    pool[kind][fuzz_below(POOL)] = handle;
}

uint64_t fuzz_handle(enum fuzz_kind kind) {
    if (fuzz_tame)
        return pool[kind][0];
    uint64_t dice = fuzz_u64() % 100;
    if (dice < 3)
        return 0;
    if (dice < 6)
        return fuzz_u64();
    if (dice < 12)
        kind = (enum fuzz_kind)fuzz_below(FUZZ_KINDS);
    // The newest more often than the rest, so that calls in order happen too.
    return pool[kind][dice < 70 ? 0 : fuzz_below(POOL)];
}

void fuzz_set_first(enum fuzz_kind kind, uint64_t handle) {
    fuzz_keep(kind, pool[kind][0]);
    pool[kind][0] = handle;
}

// --- the run

static PFN_xrGetInstanceProcAddr get_proc;

PFN_xrVoidFunction fuzz_proc(const char *name) {
    PFN_xrVoidFunction function = NULL;
    XrInstance instance = (XrInstance)pool[FUZZ_INSTANCE][0];
    if (get_proc(instance, name, &function) != XR_SUCCESS)
        get_proc(XR_NULL_HANDLE, name, &function);
    return function;
}

static bool load(void) {
    char path[4096];
    const char *build = getenv("ANTIPODE_BUILD");
    snprintf(path, sizeof path, "%s/sim_hmd/libopenxr_antipode.so", build ? build : ".");
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library) {
        fprintf(stderr, "%s\n", dlerror());
        return false;
    }
    XrResult(XRAPI_PTR * negotiate)(const struct sim_loader_info *, struct sim_runtime_request *);
    void *symbol = dlsym(library, "xrNegotiateLoaderRuntimeInterface");
    memcpy(&negotiate, &symbol, sizeof symbol);
    struct sim_loader_info loader = {.structType = SIM_LOADER_INFO,
                                     .structVersion = 1,
                                     .structSize = sizeof loader,
                                     .minInterfaceVersion = 1,
                                     .maxInterfaceVersion = 1,
                                     .minApiVersion = XR_MAKE_VERSION(1, 0, 0),
                                     .maxApiVersion = XR_MAKE_VERSION(1, 0x3ff, 0xfff)};
    struct sim_runtime_request request = {
        .structType = SIM_RUNTIME_REQUEST, .structVersion = 1, .structSize = sizeof request};
    if (negotiate(&loader, &request) != XR_SUCCESS)
        return false;
    get_proc = request.getInstanceProcAddr;
    return true;
}

static bool make_settings(char path[64], bool strict) {
    snprintf(path, 64, "/tmp/antipode-fuzz-%d.json", (int)getpid());
    FILE *f = fopen(path, "w");
    if (!f)
        return false;
    fprintf(f,
            "{\"poses\": {\"script\": \"walk\", \"duration_s\": 80000}, \"clock\": \"virtual\"%s}",
            strict ? ", \"strict\": true" : "");
    fclose(f);
    return setenv("ANTIPODE_SIM", path, 1) == 0;
}

// Everything ends and begins again after so many calls.
enum { ROUND = 3000, THREADS_MAX = 16 };

struct worker {
    uint64_t seed;
    int calls, good;
};

static void *work(void *data) {
    struct worker *w = data;
    rng = w->seed * 0x9e3779b97f4a7c15u + 1;
    for (int i = 0; i < w->calls; i++) {
        fuzz_tame = fuzz_chance(60);
        w->good += fuzz_call() >= 0;
    }
    w->seed = rng;
    return NULL;
}

// The calls that succeeded.
static int play_round(struct worker *workers, int threads) {
    pthread_t thread[THREADS_MAX];
    int good = 0;
    for (int i = 0; i < threads; i++)
        workers[i] = (struct worker){.seed = workers[i].seed, .calls = ROUND / threads};
    for (int i = 1; i < threads; i++)
        if (pthread_create(&thread[i], NULL, work, &workers[i]) != 0)
            abort();
    work(&workers[0]);
    for (int i = 1; i < threads; i++)
        pthread_join(thread[i], NULL);
    for (int i = 0; i < threads; i++)
        good += workers[i].good;
    return good;
}

int main(int argc, char **argv) {
    uint64_t seed = argc > 1 ? strtoull(argv[1], NULL, 10) : 1;
    long calls = argc > 2 ? strtol(argv[2], NULL, 10) : 150000;
    int threads = argc > 3 ? atoi(argv[3]) : 1;
    if (threads < 1 || threads > THREADS_MAX)
        return 2;
    struct worker workers[THREADS_MAX];
    for (int i = 0; i < THREADS_MAX; i++)
        workers[i].seed = seed + 1000 * (uint64_t)i;
    rng = seed;
    char settings[64];
    if (!load() || !make_settings(settings, false))
        return 1;
    long good = 0;
    for (long i = 0; i < calls; i += ROUND) {
        if (!fuzz_begin())
            return 77;
        good += play_round(workers, threads);
    }
    fuzz_end();
    remove(settings);
    printf("seed %llu: %ld calls, %ld succeeded\n", (unsigned long long)seed, calls, good);
    // A fuzzer whose calls all fail at the first check tests nothing.
    return good > calls / 20 ? 0 : 1;
}
