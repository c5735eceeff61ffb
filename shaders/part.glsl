// The vertex shader: part → nose space → Euclidean tangent space → eye → projection (native), or
// part → eye's curved space → projection (tourist), or tangent space → exp in the space she was born
// in → eye → projection (native-of). Included by part.vert and its variants: SINGLE
// draws one eye a pass, GUARD hands on what part_guard.frag needs to drop fragments.
#ifndef SINGLE
#extension GL_EXT_multiview : require
#endif

#include "logmap.glsl"
#include "frame.glsl"

layout(push_constant) uniform Push {
    int first_eye;
};

layout(location = 0) in vec4 position;
layout(location = 1) in vec4 normal;

layout(location = 0) flat out vec4 color;
layout(location = 1) out vec2 light; // diffuse, gloss
#ifdef GUARD
layout(location = 2) out vec4 curved; // nose space (native) or the eye's (tourist)
layout(location = 3) out vec3 tangent_m;
layout(location = 4) out vec3 eye_m;
layout(location = 5) flat out int image_of;
#endif

float inner(vec4 a, vec4 b) { return dot(a.xyz, b.xyz) + float(kappa) * a.w * b.w; }

// The unit tangent vector at p along the short geodesic to q.
vec4 toward(vec4 p, vec4 q) {
    if (kappa == 0)
        return vec4(normalize(q.xyz - p.xyz + vec3(0.0, 1e-9, 0.0)), 0.0);
    float c = float(kappa) * inner(p, q);
    vec4 v = q - c * p;
    return v * inversesqrt(max(float(kappa) * (1.0 - c * c), 1e-9));
}

// Light in the part's own coordinates, where numbers are small: a lamp whose light wraps a little
// round the limb, a fill from where she stands, and enough of both everywhere.
vec2 shade(Draw d, vec4 p, vec4 n) {
    vec4 lamp = toward(p, d.lamp), nose = toward(p, d.nose);
    if ((int(d.shape.w) & 1) == 1)
        nose = -nose; // seen the long way round
    float facing = inner(n, nose);
    if (d.shape.z == SHEET && facing < 0.0) {
        n = -n;
        facing = -facing;
    }
    float diffuse = max(0.0, (inner(n, lamp) + 0.25) * 0.8);
    float strength = min(1.0, 0.22 + 0.6 * diffuse + 0.25 * max(0.0, facing));
    if (d.shape.z != BALL)
        return vec2(strength, 0.0);
    vec4 between = lamp + nose;
    float gloss = max(0.0, inner(n, between) * inversesqrt(max(inner(between, between), 1e-6)));
    gloss *= gloss;
    gloss *= gloss;
    gloss *= gloss;
    gloss *= gloss;
    gloss *= gloss;
    return vec2(strength, 0.35 * gloss);
}

void main() {
#ifdef SINGLE
    int eye = first_eye;
#else
    int eye = first_eye + int(gl_ViewIndex);
#endif
    Draw d = draws[gl_InstanceIndex];
    View v = view[eye];
    int image = int(d.shape.w) & 1, way = int(d.shape.w) >> 1;
    bool ball = d.shape.z == BALL;
    vec4 p = ball ? vec4(d.shape.x * position.xyz, d.shape.y) : position;
    vec4 q = d.to[eye] * p, clip;
    vec3 t = vec3(0.0), e;
    if (mode == TOURIST) {
        // From the eye's antipode, where image 1 is seen from, all four coordinates change sign.
        vec4 s = image == 0 ? q : -q;
        e = s.xyz;
        clip.z = s.w * depth[image].x - e.z * depth[image].y;
    } else if (mode == BORN) {
        t = rho * tangent_from_nose(kappa, image, q);
        vec4 s = v.eye_from_tangent * born_from_tangent(born_kappa, t / born_rho);
        s = way == 0 ? s : -s;
        clip.z = s.w * depth[way].x - s.z * depth[way].y;
        e = s.xyz;
    } else {
        t = rho * tangent_from_nose(kappa, image, q);
        e = (v.eye_from_tangent * vec4(t, 1.0)).xyz;
        clip.z = near;
    }
    clip.xy = e.xy * v.projection.xy + e.z * v.projection.zw;
    clip.w = -e.z;
    gl_Position = clip;
    color = d.color;
    light = vec2(1.0, 0.0);
    if (d.color.a > 0.5) {
        vec4 n = ball ? vec4(d.shape.y * position.xyz, -float(kappa) * d.shape.x) : normal;
        light = shade(d, p, n);
    }
#ifdef GUARD
    curved = q;
    tangent_m = t;
    eye_m = e;
    image_of = image + 2 * way;
#endif
}
