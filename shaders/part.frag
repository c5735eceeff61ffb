#version 450
#extension GL_GOOGLE_include_directive : require

#include "coded.glsl"

layout(location = 0) flat in vec4 color;
layout(location = 1) in vec2 light;
layout(location = 0) out vec4 result;

void main() {
    // Unlit colours go out exactly as they came.
    result = written(color.a > 0.5 ? min(color.rgb * light.x + light.y, vec3(1.0)) : color.rgb);
}
