#version 450
#extension GL_GOOGLE_include_directive : require

// For parts that come near the eye or near an antipode: drops what lies within the forbidden
// millimetre, and what the straight facets of tangent space make up near s3's antipode, where the
// corners of one small triangle lie in widely different directions.

#include "logmap.glsl"
#include "frame.glsl"

layout(location = 0) flat in vec4 color;
layout(location = 1) in vec2 light;
layout(location = 2) in vec4 curved;
layout(location = 3) in vec3 tangent_m;
layout(location = 4) in vec3 eye_m;
layout(location = 5) flat in int image_of;
layout(location = 0) out vec4 result;

void main() {
    float square = dot(curved.xyz, curved.xyz) + float(kappa) * curved.w * curved.w;
    float size = kappa == 0 ? curved.w : sqrt(abs(square));
    if (tourist != 0) {
        if (length(curved.xyz) < forbidden_sine * size)
            discard;
    } else {
        if (length(eye_m) < forbidden)
            discard;
        if (kappa > 0) {
            // The antipode by the curved coordinates: a facet's middle lies a little nearer to the
            // nose in tangent space than the surface does.
            if (curved.w < 0.0 && length(curved.xyz) < forbidden_sine * size)
                discard;
            vec3 exact = rho * tangent_from_nose(kappa, image_of, curved / size);
            if (length(exact - tangent_m) > 0.05 * length(tangent_m))
                discard;
        }
    }
    result = vec4(color.a > 0.5 ? min(color.rgb * light.x + light.y, vec3(1.0)) : color.rgb, 1.0);
}
