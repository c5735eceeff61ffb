#version 450
#extension GL_GOOGLE_include_directive : require

// For parts that come near the eye or near an antipode: drops what lies within the forbidden
// millimetre, and what the straight facets of tangent space make up near s3's antipode, where the
// corners of one small triangle lie in widely different directions.

#include "logmap.glsl"
#include "frame.glsl"
#include "light.glsl"
#include "finish.glsl"

layout(location = 0) flat in vec4 color;
layout(location = 1) in vec2 light;
layout(location = 2) in vec4 curved;
layout(location = 3) in vec3 tangent_m;
layout(location = 4) in vec3 eye_m; // native-of: over the radius of her space
layout(location = 5) flat in int image_of; // image + 2·way
layout(location = 6) in vec4 place;
layout(location = 7) in vec4 face;
layout(location = 8) flat in int draw;
layout(location = 0) out vec4 result;

void main() {
    Draw d = draws[draw];
    vec3 made = d.finish.x > 0.5 ? finished(d, place, face) : vec3(0.0);
    float square = dot(curved.xyz, curved.xyz) + float(kappa) * curved.w * curved.w;
    float size = kappa == 0 ? curved.w : sqrt(abs(square));
    if (mode == TOURIST) {
        if (length(curved.xyz) < forbidden_sine * size)
            discard;
    } else {
        if (length(eye_m) * (mode == BORN ? born_rho : 1.0) < forbidden)
            discard;
        if (mode == BORN && born_kappa > 0) {
            // Her antipode is a sphere in tangent space: on either side of it things are seen another
            // way round, and beyond the next one not at all. A facet that lies across it, or whose
            // corners are brought to widely different places, is a fiction.
            float far = length(tangent_m) / born_rho;
            int way = image_of >> 1;
            if (way == 0 ? far > PI : far < PI || far > 2.0 * PI)
                discard;
        }
        if (kappa > 0) {
            // The antipode by the curved coordinates: a facet's middle lies a little nearer to the
            // nose in tangent space than the surface does.
            if (curved.w < 0.0 && length(curved.xyz) < forbidden_sine * size)
                discard;
            vec3 exact = rho * tangent_from_nose(kappa, image_of & 1, curved / size);
            if (length(exact - tangent_m) > 0.05 * length(tangent_m))
                discard;
        }
    }
    vec3 plain = color.a > 0.5 ? min(color.rgb * light.x + light.y, vec3(1.0)) : color.rgb;
    result = vec4(d.finish.x > 0.5 ? made : plain, 1.0);
}
