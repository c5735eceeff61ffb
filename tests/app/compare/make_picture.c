// make_picture FILE WIDTH HEIGHT SEED [X Y W H STEP]: noise; in the box the green byte is moved by
// STEP.

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/image/image.h"

int main(int argc, char **argv) {
    if (argc != 5 && argc != 10)
        return 2;
    unsigned n[9] = {0};
    for (int k = 2; k < argc; k++)
        n[k - 2] = (unsigned)strtoul(argv[k], NULL, 10);
    unsigned width = n[0], height = n[1], seed = n[2];
    uint8_t *rgba = malloc((size_t)width * height * 4);
    if (!rgba)
        return 4;
    for (unsigned y = 0; y < height; y++)
        for (unsigned x = 0; x < width; x++)
            for (unsigned c = 0; c < 4; c++) {
                seed = seed * 1664525u + 1013904223u;
                unsigned moved = c == 1 && x - n[3] < n[5] && y - n[4] < n[6] ? n[7] : 0;
                rgba[4 * (y * width + x) + c] = (uint8_t)((seed >> 25) + moved);
            }
    struct ap_error err = {""};
    struct ap_pixels pixels = {rgba, width, height, (size_t)width * 4, false};
    size_t len = strlen(argv[1]);
    enum ap_status st = len > 4 && strcmp(argv[1] + len - 4, ".pam") == 0
                            ? ap_pam_write_pixels(&err, argv[1], &pixels, false)
                            : ap_png_write_pixels(&err, argv[1], &pixels, 0);
    if (st)
        fprintf(stderr, "%s\n", err.text);
    free(rgba);
    return (int)st;
}
