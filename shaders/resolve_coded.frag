#version 450

// The mean of so many pixels of a larger picture, whose numbers are codes of sRGB (coded.glsl).

layout(constant_id = 0) const int LAYOUT = 513; // 1 + 256 · such pixels to each side
const int ACROSS = LAYOUT >> 8;

layout(set = 0, binding = 0) uniform usampler2DArray codes;
layout(push_constant) uniform Push {
    int layer;
};
layout(location = 0) out vec4 result;

// Within 0.05 of a code.
vec3 linear_of(uint code) {
    vec3 c = vec3(code & 255u, code >> 8 & 255u, code >> 16 & 255u) / 255.0;
    vec3 p = vec3(-0.115402065);
    p = p * c + 0.52386509;
    p = p * c + 0.56195398;
    p = p * c + 0.0280808457;
    p = p * c + 0.00106363306;
    return mix(p, c / 12.92, lessThan(c, vec3(0.04045)));
}

void main() {
    ivec2 from = ACROSS * ivec2(gl_FragCoord.xy);
    vec3 sum = vec3(0.0);
    for (int j = 0; j < ACROSS; j++)
        for (int i = 0; i < ACROSS; i++)
            sum += linear_of(texelFetch(codes, ivec3(from + ivec2(i, j), layer), 0).r);
    result = vec4(sum / float(ACROSS * ACROSS), 1.0);
}
