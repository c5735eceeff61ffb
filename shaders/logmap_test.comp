#version 450
#extension GL_GOOGLE_include_directive : require

// Maps an array of points, so that the log map can be measured on the device itself.

#include "logmap.glsl"
#include "logmap_builtin.glsl"

layout(local_size_x = 64) in;
layout(push_constant) uniform Push {
    int kappa, image, count;
};
layout(constant_id = 0) const int WAY = 0; // enum ap_logmap_way
layout(std430, set = 0, binding = 0) readonly buffer Points {
    vec4 points[]; // over rho
};
layout(std430, set = 0, binding = 1) writeonly buffer Tangents {
    vec4 tangents[]; // over rho
};

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(count))
        return;
    vec4 p = points[i];
    vec3 q = WAY == 0 ? tangent_from_nose(kappa, image, p) : tangent_by_builtin(WAY, kappa, image, p);
    tangents[i] = vec4(q, 0.0);
}
