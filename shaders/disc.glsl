// The vertex shader of unlit balls whose rims are computed (src/render/refine/disc.h). Included by disc.vert
// and disc_single.vert, which draws one eye a pass.
#ifndef SINGLE
#extension GL_EXT_multiview : require
#endif

#include "frame.glsl"

layout(push_constant) uniform Push {
    int first_eye;
};

layout(location = 0) in vec4 place; // a, b, how far ahead; w, or the angle from the nose
layout(location = 1) in vec4 edge;  // pixels inside the rim, its normal, the eye

layout(location = 0) flat out vec4 color;
layout(location = 1) noperspective out vec3 rim;

void main() {
#ifdef SINGLE
    int eye = first_eye;
#else
    int eye = first_eye + int(gl_ViewIndex);
#endif
    Draw d = draws[gl_InstanceIndex];
    View v = view[eye];
    int image = int(d.shape.w) & 1, way = int(d.shape.w) >> 1;
    vec3 e = vec3(place.xy, -1.0) * place.z;
    vec4 clip;
    clip.xy = e.xy * v.projection.xy + e.z * v.projection.zw;
    int range = mode == BORN ? way : image;
    clip.w = -e.z;
    clip.z = mode != NATIVE                   ? place.w * depth[range].x - e.z * depth[range].y
             : long_way > 0.0 && image == 1 ? long_way * place.w * clip.w
                                            : near;
    // The other eye's disc is a single point to this one.
    gl_Position = int(edge.w) == eye ? clip : vec4(0.0, 0.0, 0.0, 1.0);
    color = d.color;
    rim = edge.xyz;
}
