// What the composition shaders share: see sim_hmd/compositor_shape.h.

layout(push_constant) uniform Push {
    vec4 from_uv[3]; // rows: the pixel's ray in the layer's space, of (u, v, 1) in the eye's picture
    vec4 origin;     // curved layers: the eye in the layer's space, in radii; w: its square less 1
    vec4 shape;      // curved layers: at = angles · xz + yw
    vec4 place;      // the layer's part of the image: x, y, width, height, of the whole
    vec4 limit;      // half a texel inside of it, so that nothing beside it is mixed in
} push;
