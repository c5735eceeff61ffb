#version 450
#extension GL_GOOGLE_include_directive : require

#include "frame.glsl"
#include "light.glsl"
#include "finish.glsl"
#include "coded.glsl"

layout(location = 0) flat in vec4 color;
layout(location = 6) in vec4 place;
layout(location = 7) in vec4 face;
layout(location = 8) flat in int draw;
layout(location = 9) flat in vec4 lamp;
layout(location = 10) flat in vec4 nose;
layout(location = 11) flat in vec4 shape;
layout(location = 0) out vec4 result;

void main() {
    Surface matte = Surface(lamp, nose, color, shape, vec4(0.0));
    vec3 made;
    if (DRAWS == MATTE_ONLY)
        made = finished(matte, place, face);
    else
        made = finished(surface_of(draw), place, face);
    result = written(made);
}
