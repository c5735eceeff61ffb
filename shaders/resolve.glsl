// The mean of a pixel's samples, of which ONE has one in each pixel of a larger picture. Included by
// resolve.frag and resolve_one.frag. Reading an sRGB image gives linear light and writing one encodes
// it again, so edges are blended in linear light whatever a driver's own resolve would do.

layout(constant_id = 0) const int LAYOUT = 4; // samples + 256 · such pixels to each side
const int SAMPLES = LAYOUT & 255, ACROSS = LAYOUT >> 8;

#ifdef ONE
layout(set = 0, binding = 0) uniform sampler2DArray samples_of;
#else
layout(set = 0, binding = 0) uniform sampler2DMSArray samples_of;
#endif
layout(push_constant) uniform Push {
    int layer;
};
layout(location = 0) out vec4 result;

void main() {
    ivec2 from = ACROSS * ivec2(gl_FragCoord.xy);
    vec3 sum = vec3(0.0);
    for (int j = 0; j < ACROSS; j++)
        for (int i = 0; i < ACROSS; i++)
            for (int k = 0; k < SAMPLES; k++)
                sum += texelFetch(samples_of, ivec3(from + ivec2(i, j), layer), k).rgb;
    result = vec4(sum / float(SAMPLES * ACROSS * ACROSS), 1.0);
}
