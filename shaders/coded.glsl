// What a fragment writes. CODED: into an image of plain numbers, which are to be the codes of sRGB: a
// software device's own encoding of every sample costs it more than all of its light.
layout(constant_id = 4) const int CODED = 0;

// Within 0.009 of 1/255; by square roots, since no driver's powers can be relied on. From
// 0.0031308 on 1.055·u^(5/3) − 0.055, minimax (tests/render/fit_coded.c, as all of this page).
vec3 code_of(vec3 linear) {
    vec3 u = sqrt(sqrt(max(linear, vec3(0.0))));
    vec3 p = vec3(0.081330128);
    p = p * u - 0.335501969;
    p = p * u + 1.12268198;
    p = p * u + 0.196135715;
    p = p * u - 0.0646115169;
    return mix(p, 12.92 * linear, lessThan(linear, vec3(0.0031308)));
}

vec4 written(vec3 linear) { return vec4(CODED == 1 ? code_of(linear) : linear, 1.0); }

// The same for one colour in lights of many strengths from 0.16 to 4.2, within 0.05 of 1/255: root is
// 1.055·colour^(1/2.4), and to the power of 5/12 strength is within 2e-4.
vec4 written_lit(vec3 color, vec3 root, float strength) {
    if (CODED == 0)
        return vec4(min(color * strength, vec3(1.0)), 1.0);
    float t = sqrt(strength), p = -0.0139812473;
    p = p * t + 0.0900850818;
    p = p * t - 0.257026017;
    p = p * t + 1.13191974;
    p = p * t + 0.0490349159;
    vec3 code = root * p - 0.055;
    return vec4(mix(code, color * (12.92 * strength), lessThan(code, vec3(0.04045))), 1.0);
}
