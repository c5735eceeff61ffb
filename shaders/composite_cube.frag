#version 450
#extension GL_GOOGLE_include_directive : require
#include "composite.glsl"
// A cube map around the eye, infinitely far: sampled along the ray.

layout(location = 0) noperspective in vec3 ray_0;
layout(location = 0) out vec4 color;

layout(set = 0, binding = 0) uniform samplerCube sky;

void main() {
    color = layer_colour(WAY_0, textureLod(sky, ray_0, 0.0));
    if (FIRST)
        color.a = 1.0;
}
