#version 450

// The mean of a pixel's samples. Reading an sRGB image gives linear light and writing one encodes
// it again, so edges are blended in linear light whatever a driver's own resolve would do.

layout(set = 0, binding = 0) uniform sampler2DMSArray samples_of;
layout(push_constant) uniform Push {
    int layer, samples, across;
};
layout(location = 0) out vec4 result;

void main() {
    ivec2 from = across * ivec2(gl_FragCoord.xy);
    vec4 sum = vec4(0.0);
    for (int j = 0; j < across; j++)
        for (int i = 0; i < across; i++)
            for (int k = 0; k < samples; k++)
                sum += texelFetch(samples_of, ivec3(from + ivec2(i, j), layer), k);
    result = vec4((sum / float(samples * across * across)).rgb, 1.0);
}
