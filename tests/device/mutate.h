#ifndef ANTIPODE_TESTS_DEVICE_MUTATE_H
#define ANTIPODE_TESTS_DEVICE_MUTATE_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// A small fuzzer for where libFuzzer is not linked: seeds, then random changes of them, the same
// in every run. With it: clang -fsanitize=fuzzer,address -DANTIPODE_LIBFUZZER fuzz_….c …

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len);

#ifndef ANTIPODE_LIBFUZZER
enum { MUTATE_MAX = 8192 };

static uint64_t mutate_state = 0x9e3779b97f4a7c15;

static inline size_t mutate_below(size_t n) {
    mutate_state ^= mutate_state << 13;
    mutate_state ^= mutate_state >> 7;
    mutate_state ^= mutate_state << 17;
    return n ? (size_t)((mutate_state >> 16) % n) : 0;
}

static inline size_t mutate_once(char *text, size_t len, const char *const *words, size_t count) {
    size_t at = mutate_below(len + 1), n = mutate_below(len - at + 1);
    switch (mutate_below(5)) {
    case 0: // a bit
        if (at < len)
            text[at] = (char)(text[at] ^ (1 << mutate_below(8)));
        return len;
    case 1: // a piece away
        memmove(text + at, text + at + n, len - at - n);
        return len - n;
    case 2: // a piece twice
        if (len + n > MUTATE_MAX)
            return len;
        memmove(text + at + n, text + at, len - at);
        return len + n;
    case 3: // the rest away
        return mutate_below(4) ? len : at;
    default: { // something that may mean something
        const char *word = words[mutate_below(count)];
        size_t size = strlen(word);
        if (len + size > MUTATE_MAX)
            return len;
        memmove(text + at + size, text + at, len - at);
        memcpy(text + at, word, size);
        return len + size;
    }
    }
}

struct mutate_seed {
    const char *bytes;
    size_t len;
};

#define MUTATE_SEED(array)                                                                         \
    { array, sizeof array - 1 }

// Just as long as it is, so that a reader that goes beyond is seen.
static inline void mutate_feed(const char *bytes, size_t len) {
    uint8_t *exact = malloc(len ? len : 1);
    if (!exact)
        abort();
    memcpy(exact, bytes, len);
    LLVMFuzzerTestOneInput(exact, len);
    free(exact);
}

// The seeds as files of this folder, for libFuzzer.
static inline int mutate_write(const struct mutate_seed *seeds, size_t seed_count) {
    for (size_t i = 0; i < seed_count; i++) {
        char name[32];
        snprintf(name, sizeof name, "seed-%zu", i);
        FILE *file = fopen(name, "wb");
        if (!file || fwrite(seeds[i].bytes, 1, seeds[i].len, file) != seeds[i].len || fclose(file))
            return 1;
    }
    return 0;
}

// rounds < 0: writes the seeds instead.
static inline int mutate_run_seeds(const struct mutate_seed *seeds, size_t seed_count,
                                   const char *const *words, size_t word_count, int rounds) {
    static char text[MUTATE_MAX];
    if (rounds < 0)
        return mutate_write(seeds, seed_count);
    for (int i = 0; i < rounds; i++) {
        const struct mutate_seed *seed = &seeds[(size_t)i % seed_count];
        size_t len = seed->len < MUTATE_MAX ? seed->len : MUTATE_MAX;
        memcpy(text, seed->bytes, len);
        size_t changes = (size_t)i < seed_count ? 0 : 1 + mutate_below(6);
        for (size_t k = 0; k < changes; k++)
            len = mutate_once(text, len, words, word_count);
        mutate_feed(text, len);
    }
    printf("%d inputs of %zu seeds\n", rounds, seed_count);
    return 0;
}

static inline int mutate_run(const char *const *texts, size_t seed_count, const char *const *words,
                             size_t word_count, int rounds) {
    struct mutate_seed seeds[64];
    if (seed_count > 64)
        return 1;
    for (size_t i = 0; i < seed_count; i++)
        seeds[i] = (struct mutate_seed){texts[i], strlen(texts[i])};
    return mutate_run_seeds(seeds, seed_count, words, word_count, rounds);
}
#endif

#endif
