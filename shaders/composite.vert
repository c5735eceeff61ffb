#version 450
#extension GL_GOOGLE_include_directive : require
#include "composite.glsl"
// One triangle over the whole viewport. The rays are linear over the picture.

layout(location = 0) out vec3 ray_0;
layout(location = 1) out vec3 ray_1;
layout(location = 2) out vec3 ray_2;
layout(location = 3) out vec3 ray_3;

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
    gl_Position = vec4(2.0 * uv - 1.0, 0.0, 1.0);
}
