// Derives the minimax polynomials of sRGB's codes anew and holds the coefficients that stand in
// shaders/coded.glsl and shaders/resolve_coded.frag against them. They are read from the shaders'
// text: "p = NUMBER" begins one, "p = p * x + NUMBER" goes on. With --print it writes the
// coefficients.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/render/remez.h"

enum { TERMS = 5, TEXT_MAX = 1 << 16 };

// IEC 61966-2-1 above 0.0031308, of the fourth root of the light.
static void code_of(long double u, long double *value, long double *weight) {
    *value = 1.055L * powl(u, 5 / 3.0L) - 0.055L;
    *weight = 255;
}

// strength^(5/12) of its square root: a factor.
static void written_lit(long double t, long double *value, long double *weight) {
    *value = powl(t, 5 / 6.0L);
    *weight = 1 / *value;
}

// The light of a code; what counts is how many codes that is.
static void linear_of(long double c, long double *value, long double *weight) {
    long double base = (c + 0.055L) / 1.055L;
    *value = powl(base, 2.4L);
    *weight = 255 * 1.055L / (2.4L * powl(base, 1.4L));
}

static const struct {
    const char *file, *function;
    struct remez_fit fit;
    double slack;
} FITS[] = {
    {"coded.glsl", "vec3 code_of(", {"code_of, codes", code_of, 0.2365444L, 1, TERMS}, 1e-4},
    {"coded.glsl",
     "vec4 written_lit(",
     {"written_lit, relative", written_lit, 0.4L, 2.04939015319L, TERMS},
     1e-6},
    {"resolve_coded.frag",
     "vec3 linear_of(",
     {"linear_of, codes", linear_of, 0.04045L, 1, TERMS},
     1e-4},
};

static char *read_shader(const char *name) {
    static char text[TEXT_MAX];
    char path[4096];
    const char *source = getenv("ANTIPODE_SOURCE");
    snprintf(path, sizeof path, "%s/shaders/%s", source ? source : ".", name);
    FILE *f = fopen(path, "rb");
    size_t len = f ? fread(text, 1, sizeof text - 1, f) : 0;
    if (f)
        fclose(f);
    text[len] = '\0';
    if (!len)
        fprintf(stderr, "%s cannot be read\n", path);
    return len ? text : NULL;
}

// From the highest power down, as Horner's scheme is written.
static int read_coefficients(const char *name, const char *function, float *c) {
    const char *at = read_shader(name);
    at = at ? strstr(at, function) : NULL;
    at = at ? strstr(at, " p = ") : NULL;
    for (int k = TERMS - 1; k >= 0 && at; k--) {
        if (k < TERMS - 1)
            at = strstr(at, "p = p * ");
        const char *end = at ? strchr(at, ';') : NULL;
        if (!end)
            return 0;
        const char *number = end;
        while (number > at && strchr("0123456789.)", number[-1]))
            number--;
        const char *sign = number - 1;
        while (sign > at && *sign == ' ')
            sign--;
        c[k] = strtof(number, NULL) * (*sign == '-' ? -1 : 1);
        at = end;
    }
    return at != NULL;
}

int main(int argc, char **argv) {
    int failures = 0, print = argc > 1 && strcmp(argv[1], "--print") == 0;
    for (size_t i = 0; i < sizeof FITS / sizeof FITS[0]; i++) {
        float c[TERMS];
        if (!read_coefficients(FITS[i].file, FITS[i].function, c)) {
            fprintf(stderr, "%s: no polynomial of %d terms after \"%s\"\n", FITS[i].file, TERMS,
                    FITS[i].function);
            failures++;
            continue;
        }
        failures += remez_hold(&FITS[i].fit, c, FITS[i].slack, print);
    }
    return failures;
}
