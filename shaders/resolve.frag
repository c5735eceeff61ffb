#version 450

// The mean of a pixel's samples. Reading an sRGB image gives linear light and writing one encodes
// it again, so edges are blended in linear light whatever a driver's own resolve would do.

layout(set = 0, binding = 0) uniform sampler2DMSArray samples_of;
layout(push_constant) uniform Push {
    int layer, samples;
};
layout(location = 0) out vec4 result;

void main() {
    ivec3 at = ivec3(gl_FragCoord.xy, layer);
    vec4 sum = vec4(0.0);
    for (int i = 0; i < samples; i++)
        sum += texelFetch(samples_of, at, i);
    result = vec4((sum / float(samples)).rgb, 1.0);
}
