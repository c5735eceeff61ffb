// The log map in float32, in C and on the device, against the double reference: every space, from
// next to the nose to next to the antipode and out to 80 rho.
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/geom/map.h"
#include "src/render/logmap/logmap_device.h"
#include "src/render/logmap/logmap_float.h"
#include "tests/render/stage.h"

enum { POINTS = 60000 };
static const double TOLERANCE = 4e-7;

struct samples {
    int kappa, image;
    float p[POINTS][4];      // rounded once, as a vertex is
    double truth[POINTS][3]; // of the rounded point
    double theta[POINTS];
};

// The truth for a rounded point: (x, y, z) alone where it knows the distance better than w does,
// both in s3; what the rounding itself moved is not the map's doing.
static void reference(struct samples *s, int i) {
    const float *p = s->p[i];
    double r = sqrt((double)p[0] * p[0] + (double)p[1] * p[1] + (double)p[2] * p[2]), f = 1;
    if (s->kappa > 0) {
        double theta = atan2(r, p[3]);
        f = (s->image ? theta - 2 * 3.14159265358979323846 : theta) / r;
    } else if (s->kappa < 0) {
        f = asinh(r) / r;
    }
    for (int k = 0; k < 3; k++)
        s->truth[i][k] = f * p[k];
}

static void fill(struct samples *s, int kappa, int image) {
    const double pi = 3.14159265358979323846;
    struct ap_space space = {kappa, 1};
    uint64_t seed = 7;
    s->kappa = kappa;
    s->image = image;
    for (int i = 0; i < POINTS; i++) {
        double u = (i + 0.5) / POINTS, t, v[3];
        for (int k = 0; k < 3; k++) {
            seed = seed * 6364136223846793005u + 1442695040888963407u;
            v[k] = (double)(seed >> 11) / 9007199254740992.0 - 0.5;
        }
        if (i % 3 == 0) // even
            t = u * (kappa > 0 ? pi : 80);
        else if (i % 3 == 1) // close to the nose
            t = exp(log(1e-8) + u * (log(2) - log(1e-8)));
        else // close to the antipode, or far
            t = kappa > 0 ? pi - exp(log(1e-5) + u * (log(2) - log(1e-5))) : u * 5;
        struct ap_vec3 dir = ap_vec3_normalize((struct ap_vec3){v[0], v[1], v[2]});
        struct ap_vec4 p = ap_exp(space, ap_vec3_scale(t, dir));
        s->theta[i] = t;
        s->p[i][0] = (float)p.x;
        s->p[i][1] = (float)p.y;
        s->p[i][2] = (float)p.z;
        s->p[i][3] = (float)p.w;
        reference(s, i);
    }
}

static int judge(const struct samples *s, const char *what, const float (*q)[4]) {
    double worst = 0, at = 0;
    for (int i = 0; i < POINTS; i++) {
        const double *t = s->truth[i];
        double e = sqrt(pow(q[i][0] - t[0], 2) + pow(q[i][1] - t[1], 2) + pow(q[i][2] - t[2], 2)) /
                   sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]);
        if (!(e <= worst)) {
            worst = e;
            at = s->theta[i];
        }
    }
    bool bad = !(worst <= TOLERANCE);
    printf("%s image %d, %s: worst relative error %.3g at theta %.6g (tolerance %.3g)%s\n",
           ap_space_name((struct ap_space){s->kappa, 1}), s->image, what, worst, at, TOLERANCE,
           bad ? "  FAILED" : "");
    return bad;
}

int main(void) {
    static const int CASES[][2] = {{1, 0}, {1, 1}, {0, 0}, {-1, 0}};
    static struct samples samples;
    static float mapped[POINTS][4];
    struct ap_gpu gpu = {0};
    struct ap_logmap_device *device = NULL;
    int failures = 0, validation_errors = 0;
    struct ap_gpu_headless_params params = {true, &validation_errors};
    bool there = ap_gpu_create_headless(&stage_error, &params, &gpu) == AP_OK;
    if (there)
        STAGE_CHECK(ap_logmap_device_create(&stage_error, &gpu, POINTS, &device));
    else
        printf("skipped on the device: %s\n", stage_error.text);
    for (int c = 0; c < 4; c++) {
        fill(&samples, CASES[c][0], CASES[c][1]);
        for (int i = 0; i < POINTS; i++)
            ap_logmap_float(samples.kappa, samples.image, samples.p[i], mapped[i]);
        failures += judge(&samples, "C twin", (const float(*)[4])mapped);
        if (!there)
            continue;
        STAGE_CHECK(ap_logmap_device_map(&stage_error, device, AP_LOGMAP_POLYNOMIAL, CASES[c],
                                         (const float(*)[4])samples.p, POINTS, mapped, 1));
        failures += judge(&samples, gpu.properties.deviceName, (const float(*)[4])mapped);
        double worst, at;
        STAGE_CHECK(ap_logmap_device_error(&stage_error, device, CASES[c], POINTS, &worst, &at));
        printf("%s image %d, as doctor tells it: %.3g at theta %.6g (tolerance %.3g)\n",
               ap_space_name((struct ap_space){CASES[c][0], 1}), CASES[c][1], worst, at, TOLERANCE);
        failures += !(worst <= TOLERANCE);
    }
    ap_logmap_device_destroy(device);
    if (there)
        ap_gpu_finish(&gpu);
    return failures + validation_errors;
}
