#version 450

// How much of the pixel's square the rim leaves inside: exact where the rim is straight, as it is to
// 1/(8 r) of a pixel on a disc of r pixels.

layout(location = 0) flat in vec4 color;
layout(location = 1) noperspective in vec3 rim;
layout(location = 0) out vec4 result;

void main() {
    vec2 n = abs(normalize(rim.yz));
    float most = max(n.x, n.y), least = min(n.x, n.y);
    float u = abs(rim.x), whole = 0.5 * (most + least), corner = whole - u;
    float share = u < 0.5 * (most - least) ? 0.5 + u / most
                  : corner > 0.0           ? 1.0 - 0.5 * corner * corner / (most * least)
                                           : 1.0;
    if (rim.x < 0.0)
        share = 1.0 - share;
    if (!(share > 0.0))
        discard;
    // Unlit colours go out exactly as they came.
    result = vec4(color.rgb, share);
}
