#version 450

// The mean of two by two pixels of a larger picture, whose numbers are codes of sRGB (coded.glsl).

layout(set = 0, binding = 0) uniform usampler2DArray codes;
layout(push_constant) uniform Push {
    int layer;
};
layout(location = 0) out vec4 result;

// Within 0.052 of a code, minimax (tests/render/fit_coded.c).
vec3 linear_of(uint code) {
    vec3 c = vec3(code & 255u, code >> 8 & 255u, code >> 16 & 255u) / 255.0;
    vec3 p = vec3(-0.116794243);
    p = p * c + 0.526517034;
    p = p * c + 0.560368955;
    p = p * c + 0.0284046084;
    p = p * c + 0.00104625674;
    return mix(p, c / 12.92, lessThan(c, vec3(0.04045)));
}

void main() {
    // gl_FragCoord is a pixel's middle, the corner that its four share.
    vec2 corner = 2.0 * gl_FragCoord.xy / vec2(textureSize(codes, 0).xy);
    uvec4 four = textureGather(codes, vec3(corner, layer));
    vec3 sum = linear_of(four.x) + linear_of(four.y) + linear_of(four.z) + linear_of(four.w);
    result = vec4(0.25 * sum, 1.0);
}
