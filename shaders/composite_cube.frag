#version 450
// A cube map around the eye, infinitely far: sampled along the ray.

layout(constant_id = 1) const uint ALPHA = 0u; // as in composite.frag

layout(location = 0) in vec3 ray;
layout(location = 0) out vec4 color;

layout(set = 0, binding = 0) uniform samplerCube layer;

void main() {
    vec4 c = textureLod(layer, ray, 0.0);
    if (ALPHA >= 2u)
        c.rgb *= c.a;
    if (ALPHA == 0u || ALPHA == 3u)
        c.a = 1.0;
    color = c;
}
