#version 450
#extension GL_GOOGLE_include_directive : require
#include "composite.glsl"
// One triangle over the whole viewport. The rays are linear over the picture.

layout(location = 0) noperspective out vec3 ray_0;
layout(location = 1) noperspective out vec3 ray_1;
layout(location = 2) noperspective out vec3 ray_2;
layout(location = 3) noperspective out vec3 ray_3;
// The same for all pixels: cheaper on software Vulkan than the buffer's numbers for each.
layout(location = 4) flat out vec4 origin_0;
layout(location = 5) flat out vec4 origin_1;
layout(location = 6) flat out vec4 origin_2;
layout(location = 7) flat out vec4 origin_3;
layout(location = 8) flat out vec4 shape_0;
layout(location = 9) flat out vec4 shape_1;
layout(location = 10) flat out vec4 shape_2;
layout(location = 11) flat out vec4 shape_3;
layout(location = 12) flat out vec4 limit_0;
layout(location = 13) flat out vec4 limit_1;
layout(location = 14) flat out vec4 limit_2;
layout(location = 15) flat out vec4 limit_3;

vec3 ray(uint k, vec3 at) {
    return vec3(dot(layers[k].from_uv[0].xyz, at), dot(layers[k].from_uv[1].xyz, at),
                dot(layers[k].from_uv[2].xyz, at));
}

void main() {
    vec2 uv = vec2((gl_VertexIndex << 1) & 2, gl_VertexIndex & 2);
    vec3 at = vec3(uv, 1.0);
    ray_0 = ray(0u, at);
    ray_1 = COUNT > 1u ? ray(1u, at) : vec3(0.0);
    ray_2 = COUNT > 2u ? ray(2u, at) : vec3(0.0);
    ray_3 = COUNT > 3u ? ray(3u, at) : vec3(0.0);
    origin_0 = layers[0].origin;
    shape_0 = layers[0].shape;
    limit_0 = layers[0].limit;
    origin_1 = layers[1].origin;
    shape_1 = layers[1].shape;
    limit_1 = layers[1].limit;
    origin_2 = layers[2].origin;
    shape_2 = layers[2].shape;
    limit_2 = layers[2].limit;
    origin_3 = layers[3].origin;
    shape_3 = layers[3].shape;
    limit_3 = layers[3].limit;
    gl_Position = vec4(2.0 * uv - 1.0, 0.0, 1.0);
}
