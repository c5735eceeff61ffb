// The fragment shader of parts that come near the eye or near an antipode: drops what lies within the
// forbidden millimetre, and what the straight facets of tangent space make up near s3's antipode, where
// the corners of one small triangle lie in widely different directions. Included by part_guard.frag, and
// by part_exact.frag for native views of s3: EXACT takes the depth from the surface itself. Near the
// antipode all surfaces are seen at nearly the same distance, so that a facet's would decide where two of
// them meet by what it is off.

#include "logmap.glsl"
#include "frame.glsl"
#include "light.glsl"
#include "finish.glsl"
#include "coded.glsl"

layout(location = 0) flat in vec4 color;
layout(location = 1) in vec2 light;
layout(location = 2) in vec4 curved;
layout(location = 3) in vec3 tangent_m;
layout(location = 4) in vec3 eye_m; // native-of: over the radius of her space
layout(location = 5) flat in int image_of; // image + 2·way + 4·eye
layout(location = 6) in vec4 place;
layout(location = 7) in vec4 face;
layout(location = 8) flat in int draw;
layout(location = 0) out vec4 result;

#ifdef EXACT
#include "surface.glsl"
#endif

void main() {
#ifdef EXACT
    gl_FragDepth = gl_FragCoord.z;
#endif
    Draw d = draws[draw];
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
            int way = image_of >> 1 & 1;
            if (way == 0 ? far > PI : far < PI || far > 2.0 * PI)
                discard;
        }
        if (kappa > 0) {
            // The antipode by the curved coordinates: a facet's middle lies a little nearer to the
            // nose in tangent space than the surface does.
            if (curved.w < 0.0 && length(curved.xyz) < forbidden_sine * size)
                discard;
#ifdef EXACT
            vec4 on = on_surface(d, curved / size);
            // Elsewhere on the surface than the facet's own point by more than facets that hold the
            // bound are.
            if (distance(on, curved / size) > 0.25 * length(on.xyz))
                discard;
            bool behind = long_way > 0.0 && (image_of & 1) == 1;
            if (behind)
                gl_FragDepth = long_way * length(tangent_from_nose(1, 0, on));
            float ahead = eye_m.z + toward_eye(rho * tangent_from_nose(1, image_of & 1, on) - tangent_m);
            if (!behind && ahead < -near)
                gl_FragDepth = near / -ahead;
#else
            vec3 exact = rho * tangent_from_nose(kappa, image_of & 1, curved / size);
            if (length(exact - tangent_m) > 0.05 * length(tangent_m))
                discard;
#endif
        }
    }
    if (DRAWS != NOTHING)
        result = written(finished(surface_of(draw), place, face));
    else
        result = written(color.a > 0.5 ? min(color.rgb * light.x + light.y, vec3(1.0)) : color.rgb);
}
