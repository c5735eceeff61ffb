#version 450
#extension GL_GOOGLE_include_directive : require
#include "composite.glsl"
// A layer as a display's eye sees it: where the pixel's ray meets the layer picks the texel.

layout(constant_id = 0) const uint KIND = 0u;    // 0: a plane, 1: a cylinder, 2: a sphere
// 0: opaque, 1: premultiplied, 2: unpremultiplied, 3: unpremultiplied, over black.
layout(constant_id = 1) const uint ALPHA = 0u;
layout(constant_id = 2) const bool EDGES = true; // some pixel of the scissor may miss the layer

layout(location = 0) in vec3 ray;
layout(location = 0) out vec4 color; // linear light, premultiplied; the target encodes it

layout(set = 0, binding = 0) uniform sampler2D layer;

// How far along the ray the inside of the unit cylinder or sphere is: the farther of two places.
float far_side(float a, float b) {
    float square = b * b - a * push.origin.w;
    return square < 0.0 ? -1.0 : (sqrt(square) - b) / a;
}

void main() {
    vec2 at;
    bool seen;
    if (KIND == 0u) {
        // The plane's coordinates are homogeneous: no ray needs to be met.
        at = ray.xy / ray.z;
        seen = ray.z > 0.0;
    } else if (KIND == 1u) {
        vec2 d = ray.xz, o = push.origin.xz;
        float t = far_side(dot(d, d), dot(o, d));
        vec3 p = push.origin.xyz + t * ray;
        at = vec2(atan(p.x, -p.z), p.y) * push.shape.xz + push.shape.yw;
        seen = t > 0.0;
    } else {
        float t = far_side(dot(ray, ray), dot(push.origin.xyz, ray));
        vec3 p = push.origin.xyz + t * ray;
        at = vec2(atan(p.x, -p.z), atan(p.y, length(p.xz))) * push.shape.xz + push.shape.yw;
        seen = t > 0.0;
    }
    if (EDGES &&
        !(seen && all(greaterThanEqual(at, vec2(0.0))) && all(lessThanEqual(at, vec2(1.0)))))
        discard;
    vec2 texel = clamp(push.place.xy + at * push.place.zw, push.limit.xy, push.limit.zw);
    vec4 c = textureLod(layer, texel, 0.0);
    if (ALPHA >= 2u)
        c.rgb *= c.a;
    if (ALPHA == 0u || ALPHA == 3u)
        c.a = 1.0;
    color = c;
}
