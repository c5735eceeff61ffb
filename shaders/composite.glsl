// What the composition shaders share: see sim_hmd/compose/shape.h and pass.h.

const uint FUSED = 4u; // layers that one draw may lay over one another

struct Layer {
    // Rows: the pixel's ray in the layer's space, of (u, v, 1) in the eye's picture. A plane's are
    // homogeneous coordinates on its image instead: no ray needs to be met.
    vec4 from_uv[3];
    vec4 origin; // curved layers: the eye in the layer's space, in radii; w: its square less 1
    vec4 shape;  // curved layers: the place on the image = angles · xz + yw
    // Of the image, of the whole: left, top, right, bottom of the part, half a texel inside of its
    // edges, so that nothing beside it is mixed in.
    vec4 limit;
};
layout(std140, set = 0, binding = 4) uniform Layers {
    Layer layers[FUSED];
};

// How many layers, and how each is drawn: bits of enum sim_way.
layout(constant_id = 0) const uint COUNT = 1u;
layout(constant_id = 1) const uint WAY_0 = 0u;
layout(constant_id = 2) const uint WAY_1 = 0u;
layout(constant_id = 3) const uint WAY_2 = 0u;
layout(constant_id = 4) const uint WAY_3 = 0u;
layout(constant_id = 5) const bool FIRST = false; // nothing but black below

const uint CYLINDER = 1u; // the two lowest bits; 0: a plane
const uint SPHERE = 2u;
const uint BLENDED = 4u;         // by the image's alpha
const uint UNPREMULTIPLIED = 8u; // colour is multiplied by alpha first
const uint EDGES = 16u;          // some pixel of the scissor may miss the layer
const uint CENTRED = 32u;        // a curved layer's middle is the eye, or it is infinitely far
const uint BRIGHT = 64u;         // the image's values may lie beyond 0…1
const uint MIPS = 512u;          // the image has smaller versions of itself
const uint PART = 256u;          // of an image: what is beside it must not be mixed in

// The layer's premultiplied colour, of what its image holds there.
vec4 layer_colour(uint way, vec4 c) {
    if ((way & UNPREMULTIPLIED) != 0u)
        c.rgb *= c.a;
    if ((way & BLENDED) == 0u)
        c.a = 1.0;
    return (way & BRIGHT) != 0u ? clamp(c, 0.0, 1.0) : c;
}
