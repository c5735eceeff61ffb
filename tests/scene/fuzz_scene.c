#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "src/base/file.h"
#include "src/scene/scene.h"

// Any bytes give a scene whose every number is finite, or a sentence on one line. The entry point
// is libFuzzer's; main() below runs it over seeds and their mutations, the same in every run.
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void check(int ok, const char *what) {
    if (ok)
        return;
    fprintf(stderr, "fuzz_scene: %s\n", what);
    abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    // A file in memory: the disk would take most of the time.
    int fd = memfd_create("scene.json", MFD_CLOEXEC);
    check(fd >= 0 && write(fd, data, size) == (ssize_t)size, "cannot write the input");
    char path[64];
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    struct ap_error err = {""};
    struct ap_scene *scene = NULL;
    const struct ap_scene_params none = {0};
    enum ap_status st = ap_scene_read(&err, path, &none, &scene);
    check(st == AP_OK ? scene != NULL : (scene == NULL && err.text[0]), "no answer");
    check(st == AP_OK || st == AP_INPUT || st == AP_USAGE, "another status");
    check(!strchr(err.text, '\n'), "an error of several lines");
    for (size_t i = 0; scene && i < scene->part_count; i++) {
        const struct ap_part *p = &scene->parts[i];
        for (int k = 0; k < 16; k++)
            check(isfinite(p->carrier_from_part.m[k / 4][k % 4]), "a number that is not finite");
        check(isfinite(p->radius_m) && isfinite(p->length_m) && isfinite(p->edge_m),
              "a length that is not finite");
        check(p->kind != AP_PART_SOLID || (size_t)p->solid < scene->solid_count, "a lost solid");
    }
    ap_scene_destroy(scene);
    close(fd);
    return 0;
}

#ifndef ANTIPODE_LIBFUZZER
static uint64_t state = 0x853c49e6748fea9bu;

static size_t roll(size_t below) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (size_t)(state >> 33) % below;
}

// Bytes, numbers and structure: what a damaged or a clever file may hold.
static size_t mutate(uint8_t *text, size_t len, size_t room) {
    static const char *const words[] = {
        "1e308",       "-1e308", "1e-320", "0",           "-0.0",
        "null",        "[]",     "{}",     "\"#ff2020\"", "3.14159265358979",
        "99999999999", "true",   "\"s3\"", "\"h3\"",      "\"e3\"",
        "\\u0000",     "-1"};
    for (size_t n = 1 + roll(4); n > 0 && len > 8; n--) {
        size_t at = roll(len - 1);
        const char *word = words[roll(sizeof words / sizeof *words)];
        size_t w = strlen(word), cut = 1 + roll(6);
        switch (roll(4)) {
        case 0:
            text[at] = (uint8_t)roll(256);
            break;
        case 1: // drop some
            cut = cut < len - at ? cut : len - at;
            memmove(text + at, text + at + cut, len - at - cut);
            len -= cut;
            break;
        default: // a word in the place of a number
            while (at < len && !(text[at] >= '0' && text[at] <= '9'))
                at++;
            for (cut = 0; at + cut < len && strchr("0123456789.e-", text[at + cut]);)
                cut++;
            if (len + w >= room || at >= len)
                break;
            memmove(text + at + w, text + at + cut, len - at - cut);
            memcpy(text + at, word, w);
            len += w - cut;
        }
    }
    return len;
}

enum { ROUNDS = 1200, ROOM = 16384 };

int main(int argc, char **argv) {
    for (int i = 1; i < argc; i++) {
        char *bytes;
        size_t len;
        struct ap_error err = {""};
        if (ap_file_read(&err, argv[i], ROOM / 2, &bytes, &len)) {
            fprintf(stderr, "%s\n", err.text);
            return 1;
        }
        LLVMFuzzerTestOneInput((const uint8_t *)bytes, len);
        for (int round = 0; round < ROUNDS; round++) {
            static uint8_t text[ROOM];
            memcpy(text, bytes, len);
            LLVMFuzzerTestOneInput(text, mutate(text, len, ROOM));
        }
        free(bytes);
    }
    printf("%d seeds, %d mutations each\n", argc - 1, ROUNDS);
    return argc > 1 ? 0 : 1;
}
#endif
