#version 450
#extension GL_GOOGLE_include_directive : require
#include "composite.glsl"
// One triangle over the whole viewport. The ray is linear over the picture.

layout(location = 0) out vec3 ray;

void main() {
    vec2 uv = vec2((gl_VertexIndex << 1) & 2, gl_VertexIndex & 2);
    vec3 at = vec3(uv, 1.0);
    ray = vec3(dot(push.from_uv[0].xyz, at), dot(push.from_uv[1].xyz, at),
               dot(push.from_uv[2].xyz, at));
    gl_Position = vec4(2.0 * uv - 1.0, 0.0, 1.0);
}
