// The vertex shader: part → nose space → Euclidean tangent space → eye → projection (native), or
// part → eye's curved space → projection (tourist), or tangent space → exp in the space she was born
// in → eye → projection (native-of). Included by part.vert and its variants: SINGLE
// draws one eye a pass, FINISH hands on what part_finish.frag needs of the surface, GUARD that and what
// part_guard.frag needs to drop fragments.
#ifndef SINGLE
#extension GL_EXT_multiview : require
#endif

#include "logmap.glsl"
#include "frame.glsl"
#include "light.glsl"

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
#if defined(FINISH) || defined(GUARD)
// In the part's coordinates, times what log made of the nose-space point: then what lies between a
// facet's corners is the surface's point that the nose sees in the drawn one's direction, at any level of
// detail.
layout(location = 6) out vec4 place;
layout(location = 7) out vec4 face;
layout(location = 8) flat out int draw;
// What a matte fragment needs of its draw: a software device reads a buffer once for each fragment, but
// what is flat once for a triangle. Others compute so much that it is not worth a vertex's while.
layout(location = 9) flat out vec4 lamp_of;
layout(location = 10) flat out vec4 nose_of;
layout(location = 11) flat out vec4 shape_of;
layout(location = 12) flat out vec4 root_of;
#endif

// A vertex's light: diffuse, gloss.
vec2 shade(Draw d, vec4 p, vec4 n) {
    float square, nose_square;
    vec4 lamp = toward(p, d.lamp, square), nose = toward(p, d.nose, nose_square);
    if ((int(d.shape.w) & 1) == 1)
        nose = -nose; // seen the long way round
    float facing = inner(n, nose);
    if (d.shape.z == SHEET && facing < 0.0) {
        n = -n;
        facing = -facing;
    }
    float gloss = d.shape.z == BALL ? 0.35 * gloss_of(n, lamp, nose) : 0.0;
    return vec2(strength_of(n, lamp, square, facing, 1.0, 1.0), gloss);
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
    float times = 1.0;
    if (mode == TOURIST) {
        // From the eye's antipode, where image 1 is seen from, all four coordinates change sign.
        vec4 s = image == 0 ? q : -q;
        e = s.xyz;
        clip.z = s.w * depth[image].x - e.z * depth[image].y;
    } else if (mode == BORN) {
        times = factor_of(kappa, image, q);
        t = rho * times * q.xyz;
        vec4 born = born_from_tangent(born_kappa, t / born_rho), s = v.eye_from_tangent * born;
        if (dot(q.xyz, q.xyz) > 0.0)
            times = length(born.xyz) * inversesqrt(dot(q.xyz, q.xyz));
        s = way == 0 ? s : -s;
        clip.z = s.w * depth[way].x - s.z * depth[way].y;
        e = s.xyz;
    } else {
        times = factor_of(kappa, image, q);
        t = rho * times * q.xyz;
        e = (v.eye_from_tangent * vec4(t, 1.0)).xyz;
        clip.z = near;
    }
    clip.xy = e.xy * v.projection.xy + e.z * v.projection.zw;
    clip.w = -e.z;
    gl_Position = clip;
    color = d.color;
    vec4 n = ball ? vec4(d.shape.y * position.xyz, -float(kappa) * d.shape.x) : normal;
    light = vec2(1.0, 0.0);
#ifdef GUARD
    if (d.color.a > 0.5 && d.finish.x < 0.5)
        light = shade(d, p, n);
#elif !defined(FINISH)
    if (d.color.a > 0.5)
        light = shade(d, p, n);
#endif
#if defined(FINISH) || defined(GUARD)
    times = min(abs(times), 1e6); // it has no end at the nose seen the long way round
    place = times * p;
    face = times * n;
    draw = gl_InstanceIndex;
    if (DRAWS >= MATTE_ONLY) {
        lamp_of = d.lamp;
        nose_of = d.nose;
        shape_of = d.shape;
        root_of = vec4(d.root.rgb, lamp_light.x);
    }
#endif
#ifdef GUARD
    curved = q;
    tangent_m = t;
    eye_m = e;
    image_of = image + 2 * way + 4 * eye;
#endif
}
