// Light in a part's own coordinates, where numbers are small; src/view/light.h is the same in double.
// Needs frame.glsl.

float inner(vec4 a, vec4 b) { return dot(a.xyz, b.xyz) + float(kappa) * a.w * b.w; }

// From p along the short geodesic to q: the unit tangent vector there, and S² of the distance.
vec4 toward(vec4 p, vec4 q, out float square) {
    vec4 v = q - p;
    if (kappa == 0)
        v.w = 0.0;
    else
        v = q - float(kappa) * inner(p, q) * p;
    square = max(inner(v, v), 1e-9);
    return v * inversesqrt(square);
}

const float AMBIENT = 0.17, FILL = 0.17, LAMP = 0.95, BRIGHTEST = 4.0;

// n: the surface's unit normal on the side that is seen. to_lamp, square: see toward. facing: the
// cosine towards the nose. open: of the surroundings what nothing hides; lit: of the lamp likewise.
// The lamp's light goes through geodesic spheres, whose area is as S²; it is 1 at the distance that
// lamp_light.x is S² of.
float strength_of(vec4 n, vec4 to_lamp, float square, float facing, float open, float lit) {
    float fall = min(lamp_light.x / square, BRIGHTEST);
    float direct = max(0.0, inner(n, to_lamp)) * fall * lit;
    return (AMBIENT + FILL * max(0.0, facing)) * open + LAMP * direct;
}

float gloss_of(vec4 n, vec4 to_lamp, vec4 to_nose) {
    vec4 between = to_lamp + to_nose;
    float gloss = max(0.0, inner(n, between) * inversesqrt(max(inner(between, between), 1e-6)));
    gloss *= gloss;
    gloss *= gloss;
    gloss *= gloss;
    gloss *= gloss;
    gloss *= gloss;
    return gloss;
}
