#version 450
// A projection layer as a display's eye sees it: the pixel's direction, turned into the layer's
// view, picks the texel. Only the rotation counts; nothing is known of depths.

layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 color; // linear light, premultiplied; the target encodes it

layout(set = 0, binding = 0) uniform sampler2D layer;

layout(push_constant) uniform Push {
    vec4 turn[3];     // rows of the rotation layer_from_eye
    vec4 eye_tan;     // tangents of the eye's fov: left, right, up, down
    vec4 layer_tan;   // of the layer's
    vec4 rect;        // the layer's part of the image: x, y, width, height in texels
    vec2 size;        // the whole image
    uint alpha;       // 0: opaque, 1: premultiplied, 2: unpremultiplied
} push;

void main() {
    vec3 eye = vec3(mix(push.eye_tan.x, push.eye_tan.y, uv.x),
                    mix(push.eye_tan.z, push.eye_tan.w, uv.y), -1.0);
    vec3 d = vec3(dot(push.turn[0].xyz, eye), dot(push.turn[1].xyz, eye),
                  dot(push.turn[2].xyz, eye));
    if (!(d.z < 0.0))
        discard;
    vec2 at = vec2((d.x / -d.z - push.layer_tan.x) / (push.layer_tan.y - push.layer_tan.x),
                   (push.layer_tan.z - d.y / -d.z) / (push.layer_tan.z - push.layer_tan.w));
    if (!(all(greaterThanEqual(at, vec2(0.0))) && all(lessThanEqual(at, vec2(1.0)))))
        discard;
    // Half a texel inside the rectangle, so that nothing beside it is mixed in.
    vec2 texel = clamp(push.rect.xy + at * push.rect.zw, push.rect.xy + 0.5,
                       push.rect.xy + push.rect.zw - 0.5);
    vec4 c = textureLod(layer, texel / push.size, 0.0);
    float a = push.alpha == 0u ? 1.0 : c.a;
    color = vec4(push.alpha == 2u ? c.rgb * a : c.rgb, a);
}
