#version 450
#extension GL_GOOGLE_include_directive : require
#include "composite.glsl"
// Layers as a display's eye sees them: where the pixel's ray meets a layer picks the texel.

layout(location = 0) noperspective in vec3 ray_0;
layout(location = 1) noperspective in vec3 ray_1;
layout(location = 2) noperspective in vec3 ray_2;
layout(location = 3) noperspective in vec3 ray_3;
layout(location = 4) flat in vec4 origin_0;
layout(location = 5) flat in vec4 origin_1;
layout(location = 6) flat in vec4 origin_2;
layout(location = 7) flat in vec4 origin_3;
layout(location = 8) flat in vec4 shape_0;
layout(location = 9) flat in vec4 shape_1;
layout(location = 10) flat in vec4 shape_2;
layout(location = 11) flat in vec4 shape_3;
layout(location = 12) flat in vec4 limit_0;
layout(location = 13) flat in vec4 limit_1;
layout(location = 14) flat in vec4 limit_2;
layout(location = 15) flat in vec4 limit_3;
layout(location = 0) out vec4 color; // linear light, premultiplied; the target encodes it

layout(set = 0, binding = 0) uniform sampler2D image_0;
layout(set = 0, binding = 1) uniform sampler2D image_1;
layout(set = 0, binding = 2) uniform sampler2D image_2;
layout(set = 0, binding = 3) uniform sampler2D image_3;

// Of struct Layer, what every pixel needs: the same for all of them.
struct Constant {
    vec4 origin, shape, limit;
};

const float PI = 3.14159265;

const float NOT_ZERO = 1e-30; // for a ray along the axis

// Twice the arc tangent on -1…1, off by less than 4e-6. An angle is this of y / (length + x), which
// needs no cases for which of x and y is larger.
float angle(float x) {
    float s = x * x;
    return x * (1.99995444 +
                s * (-0.66524566 +
                     s * (0.38708078 + s * (-0.23285298 + s * (0.10529468 - s * 0.02343826)))));
}

// Of what lies behind, whose angle was taken as if it were before.
float around(vec3 p, float a) {
    return p.z > 0.0 ? (p.x < 0.0 ? -PI : PI) - a : a;
}

// Where on the inside of the unit cylinder or sphere, the farther of two places, the ray meets it.
// Scaled by a, which no angle minds: that saves a division. Its distance from the axis or the
// middle is a.
vec3 inside(uint way, vec4 origin, vec3 ray, float a, out float t, out bool seen) {
    float b = (way & SPHERE) != 0u ? dot(origin.xyz, ray) : dot(origin.xz, ray.xz);
    float square = b * b - a * origin.w;
    t = sqrt((way & EDGES) != 0u ? max(square, 0.0) : square) - b;
    seen = square >= 0.0 && t > 0.0;
    return a * origin.xyz + t * ray;
}

vec2 meet_sphere(uint way, Constant l, vec3 ray, out bool seen) {
    vec3 p = ray;
    float a = dot(ray, ray), t;
    seen = true;
    if ((way & CENTRED) != 0u)
        a = sqrt(a);
    else
        p = inside(way, l.origin, ray, a, t, seen);
    // Both quotients by one division.
    float across = sqrt(dot(p.xz, p.xz)), ahead = across + abs(p.z) + NOT_ZERO, up = across + a;
    float one = 1.0 / (ahead * up);
    return vec2(around(p, angle(p.x * (up * one))), angle(p.y * (ahead * one)));
}

vec2 meet_cylinder(uint way, Constant l, vec3 ray, out bool seen) {
    vec3 p = ray;
    float a = dot(ray.xz, ray.xz), t = 1.0;
    seen = true;
    if ((way & CENTRED) != 0u)
        a = sqrt(a);
    else
        p = inside(way, l.origin, ray, a, t, seen);
    float ahead = a + abs(p.z);
    float one = 1.0 / (ahead * a);
    return vec2(around(p, angle(p.x * (a * one))), t * ray.y * (ahead * one));
}

// Where on the layer's image the ray meets it.
vec2 meet(uint way, Constant l, vec3 ray, out bool seen) {
    uint kind = way & 3u;
    if (kind == 0u) {
        seen = ray.z > 0.0;
        return ray.xy * (1.0 / ray.z);
    }
    vec2 at = kind == SPHERE ? meet_sphere(way, l, ray, seen) : meet_cylinder(way, l, ray, seen);
    return at * l.shape.xz + l.shape.yw;
}

vec4 look(uint way, sampler2D image, Constant l, vec3 ray) {
    bool seen;
    vec2 at = meet(way, l, ray, seen), right = dFdx(at), down = dFdy(at);
    vec2 texel = (way & PART) != 0u ? clamp(at, l.limit.xy, l.limit.zw) : at;
    if ((way & EDGES) != 0u) {
        // The part ends half a texel beyond the limit.
        if ((way & PART) != 0u)
            seen = seen && all(lessThanEqual(abs(at - texel) * vec2(textureSize(image, 0)), vec2(0.5)));
        else
            seen = seen && all(greaterThanEqual(at, vec2(0.0))) && all(lessThanEqual(at, vec2(1.0)));
        if (!seen && COUNT == 1u && !FIRST)
            discard;
    }
    vec4 c = (way & MIPS) != 0u ? textureGrad(image, texel, right, down) : textureLod(image, texel, 0.0);
    c = layer_colour(way, c);
    return (way & EDGES) != 0u && !seen ? vec4(0.0) : c;
}

void main() {
    vec4 sum = look(WAY_0, image_0, Constant(origin_0, shape_0, limit_0), ray_0);
    if (COUNT > 1u) {
        vec4 c = look(WAY_1, image_1, Constant(origin_1, shape_1, limit_1), ray_1);
        sum = c + (1.0 - c.a) * sum;
    }
    if (COUNT > 2u) {
        vec4 c = look(WAY_2, image_2, Constant(origin_2, shape_2, limit_2), ray_2);
        sum = c + (1.0 - c.a) * sum;
    }
    if (COUNT > 3u) {
        vec4 c = look(WAY_3, image_3, Constant(origin_3, shape_3, limit_3), ray_3);
        sum = c + (1.0 - c.a) * sum;
    }
    if (FIRST)
        sum.a = 1.0;
    color = sum;
}
