#version 450
#extension GL_GOOGLE_include_directive : require

// Maps an array of points, so that tests can measure the log map on the device itself.

#include "logmap.glsl"

layout(local_size_x = 64) in;
layout(push_constant) uniform Push {
    int kappa, image, count;
};
layout(std430, set = 0, binding = 0) buffer Points {
    vec4 points[]; // in: a point over rho; out: its tangent point over rho
};

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < uint(count))
        points[i] = vec4(tangent_from_nose(kappa, image, points[i]), 0.0);
}
