#version 450
#extension GL_GOOGLE_include_directive : require
#include "composite.glsl"
// Layers as a display's eye sees them: where the pixel's ray meets a layer picks the texel.

layout(location = 0) in vec3 ray_0;
layout(location = 1) in vec3 ray_1;
layout(location = 2) in vec3 ray_2;
layout(location = 3) in vec3 ray_3;
layout(location = 0) out vec4 color; // linear light, premultiplied; the target encodes it

layout(set = 0, binding = 0) uniform sampler2D image_0;
layout(set = 0, binding = 1) uniform sampler2D image_1;
layout(set = 0, binding = 2) uniform sampler2D image_2;
layout(set = 0, binding = 3) uniform sampler2D image_3;

const float PI = 3.14159265;

// The arc tangent on 0…1, off by less than 2e-6.
float small_atan(float x) {
    float s = x * x;
    return x * (0.99997722 +
                s * (-0.33262283 +
                     s * (0.19354039 + s * (-0.11642649 + s * (0.05264734 - s * 0.01171913)))));
}

// Of the point (x, y), between 0 and a right angle, for both not negative.
float sharp_angle(float y, float x) {
    float a = small_atan(min(y, x) / max(max(y, x), 1e-30));
    return y > x ? 0.5 * PI - a : a;
}

float angle(float y, float x) {
    float a = sharp_angle(abs(y), abs(x));
    a = x < 0.0 ? PI - a : a;
    return y < 0.0 ? -a : a;
}

// Where on the layer's image the ray meets it.
vec2 meet(uint way, Layer l, vec3 ray, out bool seen) {
    uint kind = way & 3u;
    seen = true;
    if (kind == 0u) {
        seen = ray.z > 0.0;
        return ray.xy * (1.0 / ray.z);
    }
    // The inside of the unit cylinder or sphere is the farther of two places on the ray. Scaled by
    // a, which no angle minds: that saves a division.
    vec3 p = ray;
    vec2 flat_ray = ray.xz;
    float a = kind == SPHERE ? dot(ray, ray) : dot(flat_ray, flat_ray);
    if ((way & CENTRED) == 0u) {
        float b = kind == SPHERE ? dot(l.origin.xyz, ray) : dot(l.origin.xz, flat_ray);
        float square = b * b - a * l.origin.w, t = sqrt(max(square, 0.0)) - b;
        seen = square >= 0.0 && t > 0.0;
        p = a * l.origin.xyz + t * ray;
    }
    float up;
    if (kind == SPHERE) {
        up = sharp_angle(abs(p.y), length(p.xz));
        up = p.y < 0.0 ? -up : up;
    } else {
        up = (way & CENTRED) != 0u ? p.y * inversesqrt(a) : p.y / a;
    }
    return vec2(angle(p.x, -p.z), up) * l.shape.xz + l.shape.yw;
}

vec4 look(uint way, sampler2D image, Layer l, vec3 ray) {
    bool seen;
    vec2 at = meet(way, l, ray, seen), right = dFdx(at), down = dFdy(at);
    if ((way & EDGES) != 0u) {
        seen = seen && all(greaterThanEqual(at, l.part.xy)) && all(lessThanEqual(at, l.part.zw));
        if (!seen && COUNT == 1u && !FIRST)
            discard;
    }
    if ((way & PART) != 0u)
        at = clamp(at, l.limit.xy, l.limit.zw);
    vec4 c = (way & MIPS) != 0u ? textureGrad(image, at, right, down) : textureLod(image, at, 0.0);
    c = layer_colour(way, c);
    return (way & EDGES) != 0u && !seen ? vec4(0.0) : c;
}

void main() {
    vec4 sum = look(WAY_0, image_0, layers[0], ray_0);
    if (COUNT > 1u) {
        vec4 c = look(WAY_1, image_1, layers[1], ray_1);
        sum = c + (1.0 - c.a) * sum;
    }
    if (COUNT > 2u) {
        vec4 c = look(WAY_2, image_2, layers[2], ray_2);
        sum = c + (1.0 - c.a) * sum;
    }
    if (COUNT > 3u) {
        vec4 c = look(WAY_3, image_3, layers[3], ray_3);
        sum = c + (1.0 - c.a) * sum;
    }
    if (FIRST)
        sum.a = 1.0;
    color = sum;
}
