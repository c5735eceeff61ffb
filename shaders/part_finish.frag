#version 450
#extension GL_GOOGLE_include_directive : require

#include "frame.glsl"
#include "light.glsl"
#include "finish.glsl"

layout(location = 6) in vec4 place;
layout(location = 7) in vec4 face;
layout(location = 8) flat in int draw;
layout(location = 0) out vec4 result;

void main() { result = vec4(finished(draws[draw], place, face), 1.0); }
