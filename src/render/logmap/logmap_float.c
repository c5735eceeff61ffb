#include "src/render/logmap/logmap_float.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

const float ap_logmap_asin[AP_LOGMAP_TERMS] = {0.166669056f,  0.0748851076f, 0.0464984886f,
                                               0.0164133403f, 0.0768947899f, -0.0924970061f,
                                               0.111241437f};
const float ap_logmap_asinh[AP_LOGMAP_TERMS] = {-0.1666646f,    0.0749432817f,  -0.0441043526f,
                                                0.0278709084f,  -0.0156835355f, 0.00619389676f,
                                                -0.00118202099f};
const float ap_logmap_atanh[AP_LOGMAP_LOG_TERMS] = {0.33333388f, 0.199887872f, 0.149354681f};

static float poly(const float *c, int terms, float t) {
    float p = 0;
    for (int k = terms - 1; k >= 0; k--)
        p = p * t + c[k];
    return 1.0f + t * p;
}

// x ≥ 1, finite: x = 2^e·m with m in [√½, √2), log m = 2·atanh((m − 1)/(m + 1)).
static float log_above_one(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    int e = (int)((bits - 0x3f3504f3u) >> 23); // 0x3f3504f3 is √½
    bits -= (uint32_t)e << 23;
    float m;
    memcpy(&m, &bits, sizeof m);
    float s = (m - 1.0f) / (m + 1.0f);
    return (float)e * 0.693147181f + 2.0f * s * poly(ap_logmap_atanh, AP_LOGMAP_LOG_TERMS, s * s);
}

// theta/sinh theta.
static float factor_h3(float t, float w) {
    if (t < 1.0f) // theta < 0.88; w would lose small distances
        return poly(ap_logmap_asinh, AP_LOGMAP_TERMS, t);
    if (w > 4096.0f) // r is w here, and t may have overflowed
        return log_above_one(2.0f * w) / w;
    float r = sqrtf(t);
    return log_above_one(w + r) / r;
}

// theta/sin theta; image 1: −(2·pi − theta)/sin theta. Each third of the range takes the smaller of
// r and w, so that nothing cancels.
static float factor_s3(int image, float t, float w) {
    const float pi = 3.14159265f;
    float r = sqrtf(t), asin_r = poly(ap_logmap_asin, AP_LOGMAP_TERMS, t), theta;
    if (w > 0.70710678f && image == 0)
        return asin_r; // 1 at the base point
    if (w > 0.70710678f)
        theta = r * asin_r;
    else if (w > -0.70710678f)
        theta = 0.5f * pi - w * poly(ap_logmap_asin, AP_LOGMAP_TERMS, w * w);
    else
        theta = pi - r * asin_r;
    return (image == 0 ? theta : theta - 2.0f * pi) / r;
}

void ap_logmap_float(int kappa, int image, const float p[4], float q[3]) {
    float t = p[0] * p[0] + p[1] * p[1] + p[2] * p[2], f = 1;
    if (kappa > 0)
        f = factor_s3(image, t, p[3]);
    else if (kappa < 0)
        f = factor_h3(t, p[3]);
    for (int i = 0; i < 3; i++)
        q[i] = f * p[i];
}
