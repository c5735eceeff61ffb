// The log map of nose space to the Euclidean tangent space in float32 (Weeks 2021, section 5),
// without any inverse or hyperbolic built-in: no driver gets those right (docs/rendering.md). The
// same arithmetic in C, which is measured against the double reference: src/render/logmap/logmap_float.c;
// the coefficients are derived by tests/render/fit_logmap.c.

const float PI = 3.14159265;

// (arc sine of √t)/√t on [0, ½]
float ratio_of_arc_sine(float t) {
    float p = 0.111241437;
    p = p * t + -0.0924970061;
    p = p * t + 0.0768947899;
    p = p * t + 0.0164133403;
    p = p * t + 0.0464984886;
    p = p * t + 0.0748851076;
    p = p * t + 0.166669056;
    return 1.0 + t * p;
}

// (area sine of √t)/√t on [0, 1]
float ratio_of_area_sine(float t) {
    float p = -0.00118202099;
    p = p * t + 0.00619389676;
    p = p * t + -0.0156835355;
    p = p * t + 0.0278709084;
    p = p * t + -0.0441043526;
    p = p * t + 0.0749432817;
    p = p * t + -0.1666646;
    return 1.0 + t * p;
}

// (area tangent of √t)/√t on [0, 0.0295]
float ratio_of_area_tangent(float t) {
    float p = 0.149354681;
    p = p * t + 0.199887872;
    p = p * t + 0.33333388;
    return 1.0 + t * p;
}

// x >= 1, finite: x = 2^e·m with m in [√½, √2), log m = 2·(area tangent of (m − 1)/(m + 1)).
float log_above_one(float x) {
    uint bits = floatBitsToUint(x);
    int e = int((bits - 0x3f3504f3u) >> 23); // 0x3f3504f3 is √½
    float m = uintBitsToFloat(bits - (uint(e) << 23));
    float s = (m - 1.0) / (m + 1.0);
    return float(e) * 0.693147181 + 2.0 * s * ratio_of_area_tangent(s * s);
}

// theta over its hyperbolic sine.
float factor_h3(float t, float w) {
    if (t < 1.0) // theta < 0.88; w would lose small distances
        return ratio_of_area_sine(t);
    if (w > 4096.0) // r is w here, and t may have overflowed
        return log_above_one(2.0 * w) / w;
    float r = sqrt(t);
    return log_above_one(w + r) / r;
}

// theta over its sine; image 1: −(2·pi − theta) over it. Each third of the range takes the smaller of
// r and w, so that nothing cancels.
float factor_s3(int image, float t, float w) {
    float r = sqrt(t), theta;
    if (abs(w) < 0.70710678) {
        theta = 0.5 * PI - w * ratio_of_arc_sine(w * w);
    } else {
        float ratio = ratio_of_arc_sine(t);
        if (w > 0.0 && image == 0)
            return ratio; // 1 at the base point
        theta = w > 0.0 ? r * ratio : PI - r * ratio;
    }
    return (image == 0 ? theta : theta - 2.0 * PI) / r;
}

// p: a point of the space over rho. What its first three coordinates are multiplied by.
float factor_of(int kappa, int image, vec4 p) {
    float t = dot(p.xyz, p.xyz);
    return kappa == 0 ? 1.0 : kappa > 0 ? factor_s3(image, t, p.w) : factor_h3(t, p.w);
}

// The tangent point over rho.
vec3 tangent_from_nose(int kappa, int image, vec4 p) {
    return kappa == 0 ? p.xyz : factor_of(kappa, image, p) * p.xyz;
}

// exp in the space that somebody was born in, v over its radius: a multiple of the point, which is
// all that a projection needs; so h3 does not overflow. Relative errors up to 1e-6, which move what
// an eye beside the nose sees by that much of its vergence.
vec4 born_from_tangent(int born_kappa, vec3 v) {
    float square = dot(v, v), t = sqrt(square);
    if (born_kappa == 0)
        return vec4(v, 1.0);
    if (born_kappa < 0) {
        float ratio; // hyperbolic tangent of t, over t
        if (square < 0.25) {
            ratio = -0.00886323;
            ratio = ratio * square + 0.02186949;
            ratio = ratio * square - 0.05396825;
            ratio = ratio * square + 0.13333333;
            ratio = ratio * square - 0.33333333;
            ratio = ratio * square + 1.0;
        } else {
            float e = exp(-2.0 * t);
            ratio = (1.0 - e) / ((1.0 + e) * t);
        }
        return vec4(ratio * v, 1.0);
    }
    float ratio;
    if (square < 0.25) {
        ratio = 2.75573192e-6;
        ratio = ratio * square - 1.98412698e-4;
        ratio = ratio * square + 8.33333333e-3;
        ratio = ratio * square - 1.66666667e-1;
        ratio = ratio * square + 1.0;
    } else {
        ratio = sin(t) / t;
    }
    return vec4(ratio * v, cos(t));
}
