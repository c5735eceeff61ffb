#include <math.h>
#include <stdlib.h>

#include "src/image/compare.h"

// LDR-FLIP, after the paper's formulas: Andersson et al., "FLIP: A Difference Evaluator for
// Alternating Images", Proc. ACM Comput. Graph. Interact. Tech. 3(2), 2020. Two pipelines: colours
// as the eye resolves them at this distance, and edges and points; the second amplifies the first.
// Everything is float planes; all filters are products (or sums of two products) of one-dimensional
// ones, edges repeated outwards.

static const double QC = 0.7, PC = 0.4, PT = 0.95; // colour: exponent, knee
static const double QF = 0.5, FEATURE_WIDTH_DEG = 0.082;

enum { MAX_RADIUS = 256 };

struct kernel {
    int radius;
    float w[2 * MAX_RADIUS + 1];
};

struct planes {
    size_t width, height;
    float *scratch;
};

static void convolve(const struct planes *p, const float *in, const struct kernel *along,
                     const struct kernel *down, float *out) {
    long w = (long)p->width, h = (long)p->height;
    for (long y = 0; y < h; y++)
        for (long x = 0; x < w; x++) {
            double sum = 0;
            for (int k = -along->radius; k <= along->radius; k++) {
                long at = x + k < 0 ? 0 : x + k >= w ? w - 1 : x + k;
                sum += (double)along->w[k + along->radius] * (double)in[y * w + at];
            }
            p->scratch[y * w + x] = (float)sum;
        }
    for (long y = 0; y < h; y++) {
        for (long x = 0; x < w; x++)
            out[y * w + x] = 0;
        for (int k = -down->radius; k <= down->radius; k++) {
            long at = y + k < 0 ? 0 : y + k >= h ? h - 1 : y + k;
            float weight = down->w[k + down->radius];
            for (long x = 0; x < w; x++)
                out[y * w + x] += weight * p->scratch[at * w + x];
        }
    }
}

// ---- colour spaces; white is linear (1, 1, 1)

struct white {
    double x, y, z;
};

static struct white xyz_of(double r, double g, double b) {
    return (struct white){(10135552 * r + 8788810 * g + 4435075 * b) / 24577794,
                          (2613072 * r + 8788810 * g + 887015 * b) / 12288897,
                          (1425312 * r + 8788810 * g + 70074185 * b) / 73733382};
}

// The inverse of xyz_of.
static void rgb_of(struct white v, double rgb[3]) {
    rgb[0] = 3.241003275 * v.x - 1.537398934 * v.y - 0.498615861 * v.z;
    rgb[1] = -0.969224334 * v.x + 1.875930071 * v.y + 0.041554224 * v.z;
    rgb[2] = 0.055639423 * v.x - 0.204011202 * v.y + 1.057148933 * v.z;
}

static double lab_curve(double t) {
    const double d = 6.0 / 29;
    return t > d * d * d ? cbrt(t) : t / (3 * d * d) + 4.0 / 29;
}

struct lab {
    double l, a, b;
};

// CIELAB with a and b shrunk in the dark (Hunt).
static struct lab hunt_lab(const double rgb[3]) {
    struct white w = xyz_of(1, 1, 1), v = xyz_of(rgb[0], rgb[1], rgb[2]);
    double x = lab_curve(v.x / w.x), y = lab_curve(v.y / w.y), z = lab_curve(v.z / w.z);
    double l = 116 * y - 16;
    return (struct lab){l, 0.01 * l * 500 * (x - y), 0.01 * l * 200 * (y - z)};
}

static double hyab(struct lab p, struct lab q) {
    return fabs(p.l - q.l) + hypot(p.a - q.a, p.b - q.b);
}

// ---- kernels

static int radius_of(double r) {
    return r > MAX_RADIUS ? MAX_RADIUS : (int)ceil(r);
}

// exp(−pi² d² / b) over pixels, d in degrees; returns its sum before it was made 1.
static double gaussian(double b, int radius, double ppd, struct kernel *k) {
    double sum = 0;
    k->radius = radius;
    for (int i = -radius; i <= radius; i++)
        sum += exp(-M_PI * M_PI * (i / ppd) * (i / ppd) / b);
    for (int i = -radius; i <= radius; i++)
        k->w[i + radius] = (float)(exp(-M_PI * M_PI * (i / ppd) * (i / ppd) / b) / sum);
    return sum;
}

// A detector's profile across: its positive weights sum to 1, its negative ones to −1.
static void detector(int point, double sd, int radius, struct kernel *k) {
    double w[2 * MAX_RADIUS + 1], plus = 0, minus = 0;
    k->radius = radius;
    for (int i = -radius; i <= radius; i++) {
        double g = exp(-i * i / (2 * sd * sd));
        double v = point ? (i * i / (sd * sd) - 1) * g : -i * g;
        w[i + radius] = v;
        plus += v > 0 ? v : 0;
        minus += v < 0 ? -v : 0;
    }
    for (int i = 0; i <= 2 * radius; i++) {
        double by = w[i] > 0 ? plus : minus;
        k->w[i] = by > 0 ? (float)(w[i] / by) : 0;
    }
}

// ---- the two pipelines

enum { Y, CX, CZ, PLANES }; // the opponent colours YCxCz, linear in light

static void opponent(const struct ap_image *image, float *const plane[PLANES]) {
    double linear[256];
    for (int v = 0; v < 256; v++)
        linear[v] = ap_linear_from_srgb((uint8_t)v);
    struct white white = xyz_of(1, 1, 1);
    size_t n = (size_t)image->width * image->height;
    for (size_t i = 0; i < n; i++) {
        const uint8_t *p = image->rgb + 3 * i;
        struct white v = xyz_of(linear[p[0]], linear[p[1]], linear[p[2]]);
        double x = v.x / white.x, y = v.y / white.y, z = v.z / white.z;
        plane[Y][i] = (float)(116 * y - 16);
        plane[CX][i] = (float)(500 * (x - y));
        plane[CZ][i] = (float)(200 * (y - z));
    }
}

// The contrast sensitivity of the eye: each plane blurred by what cannot be resolved in it. Blue
// and yellow by a sum of two Gaussians.
static void blur(const struct planes *p, double ppd, float *const plane[PLANES], float *spare) {
    const double by_a[2] = {34.1, 13.5}, by_b[2] = {0.04, 0.025};
    int radius = radius_of(3 * sqrt(0.04 / (2 * M_PI * M_PI)) * ppd);
    struct kernel k[2];
    gaussian(0.0047, radius, ppd, &k[0]);
    convolve(p, plane[Y], &k[0], &k[0], plane[Y]);
    gaussian(0.0053, radius, ppd, &k[0]);
    convolve(p, plane[CX], &k[0], &k[0], plane[CX]);
    double share[2];
    for (int i = 0; i < 2; i++) {
        double sum = gaussian(by_b[i], radius, ppd, &k[i]);
        share[i] = by_a[i] * sqrt(M_PI / by_b[i]) * sum * sum;
    }
    convolve(p, plane[CZ], &k[0], &k[0], spare);
    convolve(p, plane[CZ], &k[1], &k[1], plane[CZ]);
    size_t n = p->width * p->height;
    for (size_t i = 0; i < n; i++)
        plane[CZ][i] = (float)((share[0] * (double)spare[i] + share[1] * (double)plane[CZ][i]) /
                               (share[0] + share[1]));
}

static struct lab seen(float *const plane[PLANES], size_t i) {
    struct white white = xyz_of(1, 1, 1);
    double y = ((double)plane[Y][i] + 16) / 116;
    double x = y + (double)plane[CX][i] / 500, z = y - (double)plane[CZ][i] / 200;
    double rgb[3];
    rgb_of((struct white){x * white.x, y * white.y, z * white.z}, rgb);
    for (int c = 0; c < 3; c++)
        rgb[c] = rgb[c] < 0 ? 0 : rgb[c] > 1 ? 1 : rgb[c];
    return hunt_lab(rgb);
}

// The largest distance there is, green to blue.
static double most_colour(void) {
    const double green[3] = {0, 1, 0}, blue[3] = {0, 0, 1};
    return pow(hyab(hunt_lab(green), hunt_lab(blue)), QC);
}

static double colour_difference(struct lab p, struct lab q, double most) {
    double d = pow(hyab(p, q), QC), knee = PC * most;
    return d < knee ? PT / knee * d : PT + (d - knee) / (most - knee) * (1 - PT);
}

// What edge (or point) detectors find of a plane of grey, 0 to about 1: the length of (x, y).
static void detect(const struct planes *p, const float *grey, const struct kernel *across,
                   const struct kernel *smooth, float *spare, float *out) {
    convolve(p, grey, across, smooth, out);
    convolve(p, grey, smooth, across, spare);
    size_t n = p->width * p->height;
    for (size_t i = 0; i < n; i++)
        out[i] = hypotf(out[i], spare[i]);
}

// feature[i] becomes the larger of the differences in edges and in points; buffers are 3 planes.
static void feature_difference(const struct planes *p, double ppd, const float *grey[2],
                               float *const buffer[3], float *feature) {
    double sd = 0.5 * FEATURE_WIDTH_DEG * ppd;
    int radius = radius_of(3 * sd);
    struct kernel across, smooth;
    gaussian(2 * M_PI * M_PI * sd * sd / (ppd * ppd), radius, ppd, &smooth);
    size_t n = p->width * p->height;
    for (int point = 0; point < 2; point++) {
        detector(point, sd, radius, &across);
        detect(p, grey[0], &across, &smooth, buffer[2], buffer[0]);
        detect(p, grey[1], &across, &smooth, buffer[2], buffer[1]);
        for (size_t i = 0; i < n; i++) {
            float d = fabsf(buffer[0][i] - buffer[1][i]);
            feature[i] = point && feature[i] > d ? feature[i] : d;
        }
    }
}

// plane[image][0…2] are the opponent colours, spare has 3 more planes and the result's.
static double pool(const struct planes *p, double ppd, float *plane[2][PLANES], float *spare[4],
                   float *map) {
    size_t n = p->width * p->height;
    const float *grey[2] = {plane[0][Y], plane[1][Y]};
    float *feature = spare[3];
    // Linear: a detector's weights sum to 0, so what is added to Y does not matter.
    feature_difference(p, ppd, grey, spare, feature);
    blur(p, ppd, plane[0], spare[0]);
    blur(p, ppd, plane[1], spare[0]);
    double most = most_colour(), sum = 0;
    for (size_t i = 0; i < n; i++) {
        double f = pow((double)feature[i] / 116 / M_SQRT2, QF);
        double c = colour_difference(seen(plane[0], i), seen(plane[1], i), most);
        double flip = pow(c, 1 - (f > 1 ? 1 : f));
        sum += flip;
        if (map)
            map[i] = (float)flip;
    }
    return sum / (double)n;
}

enum ap_status ap_image_flip(struct ap_error *err, const struct ap_image *reference,
                             const struct ap_image *test, double ppd, double *flip, float *map) {
    if (reference->width != test->width || reference->height != test->height)
        return ap_fail(err, AP_INPUT, "pictures of %ux%u and %ux%u pixels cannot be compared",
                       reference->width, reference->height, test->width, test->height);
    if (!(ppd > 0 && ppd <= 1000))
        return ap_fail(err, AP_INPUT, "expected pixels per degree above 0, at most 1000");
    enum { SPARE = 4, ALL = 2 * PLANES + SPARE + 1 };
    size_t n = (size_t)reference->width * reference->height;
    float *all = calloc(n, ALL * sizeof *all);
    if (!all)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    float *plane[2][PLANES], *spare[SPARE];
    for (int k = 0; k < 2 * PLANES; k++)
        plane[k / PLANES][k % PLANES] = all + (size_t)k * n;
    for (int k = 0; k < SPARE; k++)
        spare[k] = all + (size_t)(2 * PLANES + k) * n;
    struct planes p = {reference->width, reference->height, all + (size_t)(ALL - 1) * n};
    opponent(reference, plane[0]);
    opponent(test, plane[1]);
    *flip = pool(&p, ppd, plane, spare, map);
    free(all);
    return AP_OK;
}
