#version 450
#extension GL_GOOGLE_include_directive : require

// What is matte, closed and no ball: the same light as finish.glsl's with less arithmetic. DRAWS is
// PLANES where a part is the plane y = 0 of its own coordinates, which has one normal.

#include "frame.glsl"
#include "light.glsl"
#include "coded.glsl"

layout(location = 0) flat in vec4 color;
layout(location = 6) in vec4 place;
layout(location = 7) in vec4 face;
layout(location = 9) flat in vec4 lamp;
layout(location = 10) flat in vec4 nose;
layout(location = 11) flat in vec4 shape;
layout(location = 12) flat in vec4 root; // and the lamp's reach, as lamp_light.x
layout(location = 0) out vec4 result;

// n times the geodesic's direction from p to q, but for the factor S of its length, whose square comes
// of the chord: nothing cancels where q is near. across: n·q; aslant: n·p, next to nothing.
float along(vec4 p, vec4 q, float across, float aslant, out float square) {
    vec4 v = q - p;
    float chord = inner(v, v);
    square = max(chord - 0.25 * float(kappa) * chord * chord, 1e-9);
    return across - (1.0 - 0.5 * float(kappa) * chord) * aslant;
}

void main() {
    vec4 p = place;
    if (kappa != 0)
        p *= inversesqrt(abs(inner(p, p)));
    float square, nose_square, direct, facing, shorter = 1.0;
    if (DRAWS == PLANES) {
        direct = along(p, lamp, lamp.y, 0.0, square);
        facing = along(p, nose, nose.y, 0.0, nose_square);
    } else {
        float aslant = inner(face, p);
        direct = along(p, lamp, inner(face, lamp), aslant, square);
        facing = along(p, nose, inner(face, nose), aslant, nose_square);
        shorter = max(inner(face, face), 1e-12);
    }
    if (kappa > 0 && (int(shape.w) & 1) == 1)
        facing = -facing; // seen the long way round
    float near = inversesqrt(square), unit = DRAWS == PLANES ? 1.0 : inversesqrt(shorter);
    float fall = min(root.w * near * near, BRIGHTEST);
    float strength = AMBIENT + FILL * max(0.0, facing) * inversesqrt(nose_square * shorter) +
                     LAMP * max(0.0, direct) * near * unit * fall;
    result = written_lit(color.rgb, root.rgb, strength);
}
