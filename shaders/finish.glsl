// What a surface is made of, fragment by fragment, and its light: cloth with the shadows of balls and
// the mouths of pockets, wood, billiard balls with stripe and number. Needs frame.glsl, light.glsl.

layout(set = 0, binding = 2) uniform sampler2DArray decals; // coverage; a layer a text

// On surfaces that take them: a ball that casts a shadow, or a pocket's mouth. at: its centre in the
// coordinates of the part that takes it. shape: S of its radius, 1 for a mouth.
struct Mark {
    vec4 at, shape;
};
layout(std430, set = 0, binding = 3) readonly buffer Marks {
    Mark marks[];
};

float hash(ivec3 v) {
    uint n = uint(v.x) * 1597334677u ^ uint(v.y) * 3812015801u ^ uint(v.z) * 2798796415u;
    n = (n ^ (n >> 15)) * 2246822519u;
    n ^= n >> 13;
    return float(n & 0xffffffu) / 16777215.0;
}

// Smooth, −1…1, of a mean near 0.
float noise(vec2 x, int layer) {
    vec2 f = fract(x), s = f * f * (3.0 - 2.0 * f);
    ivec3 i = ivec3(ivec2(floor(x)), layer);
    float low = mix(hash(i), hash(i + ivec3(1, 0, 0)), s.x);
    float high = mix(hash(i + ivec3(0, 1, 0)), hash(i + ivec3(1, 1, 0)), s.x);
    return 2.0 * mix(low, high, s.y) - 1.0;
}

// How much of a pattern is left whose waves are `wave` long, where a pixel is `pixel` wide.
float left_of(float wave, float pixel) { return clamp(1.5 - 2.0 * pixel / wave, 0.0, 1.0); }

// m: metres on the cloth.
vec3 cloth(vec3 color, vec2 m, float pixel) {
    float nap = noise(m * 700.0, 1) * 0.11 * left_of(0.0014, pixel);
    float wear = noise(m * 19.0, 2) * 0.05 * left_of(0.05, pixel);
    return color * (1.0 + nap + wear);
}

// Grain along z. m: metres.
vec3 wood(vec3 color, vec3 m, float pixel) {
    float bend = noise(vec2(m.z * 6.0, 0.0), 3);
    float rings = noise(vec2(m.x * 190.0 + 3.0 * bend, m.y * 190.0 + m.z * 5.0), 4);
    float fibre = noise(vec2(m.x * 900.0 + m.y * 1100.0, m.z * 30.0), 5);
    return color * (1.0 + 0.42 * rings * left_of(0.004, pixel) + 0.2 * fibre * left_of(0.0015, pixel));
}

const vec3 IVORY = vec3(0.91, 0.87, 0.77), INK = vec3(0.012);
const float BAND_SINE = 0.479, DISC_SINE = 0.42, NUMBER_SINE = 0.36;

// u: the direction from the middle; pixel: how far a pixel reaches in it.
vec3 ball_color(vec3 color, vec3 u, float pixel, bool striped, float decal) {
    float soft = max(pixel, 1e-4);
    vec3 base = color;
    if (striped)
        base = mix(color, IVORY, smoothstep(-soft, soft, abs(u.x) - BAND_SINE));
    if (decal < 0.0)
        return base;
    float disc = smoothstep(-soft, soft, DISC_SINE - length(u.xy));
    vec2 at = vec2(u.z < 0.0 ? -u.x : u.x, -u.y) / (2.0 * NUMBER_SINE) + 0.5;
    float level = log2(max(soft / (2.0 * NUMBER_SINE) * float(textureSize(decals, 0).x), 1.0));
    float ink = textureLod(decals, vec3(at, decal), level).r;
    if (any(lessThan(at, vec2(0.0))) || any(greaterThan(at, vec2(1.0))))
        ink = 0.0;
    return mix(base, mix(IVORY, INK, ink), disc);
}

// The balls that stand on a surface, seen from its point p: each hides of the surroundings the cosine
// of its direction times sin² of its angular radius (exact for a ball wholly above the plane), and of
// the lamp, a disc of light, what lies within that radius. All angles are of geodesics at p.
void shadows(Draw d, vec4 p, vec4 n, vec4 to_lamp, float square, inout float open, inout float lit) {
    float lamp_sine = lamp_light.y * inversesqrt(square);
    for (int i = 0; i < int(d.finish.w); i++) {
        Mark mark = marks[int(d.finish.z) + i];
        if (mark.shape.y > 0.5)
            continue;
        float far;
        vec4 to_ball = toward(p, mark.at, far);
        float s = min(mark.shape.x * inversesqrt(far), 1.0), c = sqrt(1.0 - s * s);
        open -= max(0.0, inner(n, to_ball)) * s * s;
        float along = clamp(inner(to_ball, to_lamp), -1.0, 1.0);
        float beyond = sqrt(1.0 - along * along) * c - along * s; // sine of the angle past its rim
        lit *= smoothstep(-lamp_sine, lamp_sine, beyond);
    }
    open = max(open, 0.0);
}

// The mouths of pockets: leather to the rim, black inside.
vec3 pockets(Draw d, vec3 color, vec4 p, float pixel) {
    for (int i = 0; i < int(d.finish.w); i++) {
        Mark mark = marks[int(d.finish.z) + i];
        if (mark.shape.y < 0.5 || (kappa > 0 && inner(p, mark.at) < 0.0))
            continue;
        float far;
        toward(p, mark.at, far);
        float r = sqrt(far) * rho, rim = mark.shape.x * rho, soft = max(pixel, 1e-4);
        color = mix(color, vec3(0.10, 0.055, 0.03), smoothstep(-soft, soft, rim - r));
        color = mix(color, vec3(0.004), smoothstep(-soft, soft, 0.92 * rim - r));
    }
    return color;
}

// p, n: place and normal in the part's coordinates, as they were interpolated.
vec3 finished(Draw d, vec4 p, vec4 n) {
    int finish = int(d.finish.x);
    bool ball = d.shape.z == BALL;
    vec3 u = p.xyz * inversesqrt(max(dot(p.xyz, p.xyz), 1e-12));
    if (ball) {
        p = vec4(d.shape.x * u, d.shape.y);
        n = vec4(d.shape.y * u, -float(kappa) * d.shape.x);
    } else if (kappa != 0) {
        p *= inversesqrt(abs(inner(p, p)));
    }
    n *= inversesqrt(max(inner(n, n), 1e-12));
    float square, nose_square, open = 1.0, lit = 1.0;
    vec4 to_lamp = toward(p, d.lamp, square), to_nose = toward(p, d.nose, nose_square);
    if ((int(d.shape.w) & 1) == 1)
        to_nose = -to_nose; // seen the long way round
    float facing = inner(n, to_nose);
    if (d.shape.z == SHEET && facing < 0.0) {
        n = -n;
        facing = -facing;
    }
    // How far a pixel reaches on the surface, over rho. Not by differences between neighbours: a ball's
    // triangles may be smaller than a pixel, and between two of them these jump.
    float pixel = lamp_light.z * sqrt(nose_square) / max(facing, 0.2);
    vec3 color = d.color.rgb;
    float shine = ball ? 0.42 : finish == WOOD ? 0.14 : 0.0;
    if (ball)
        color = ball_color(color, u, pixel / d.shape.x, finish == STRIPED, d.finish.y);
    else if (finish == CLOTH)
        color = cloth(color, rho * p.xz, rho * pixel);
    else if (finish == WOOD)
        color = wood(color, rho * p.xyz, rho * pixel);
    if (d.finish.w > 0.5) {
        shadows(d, p, n, to_lamp, square, open, lit);
        color = pockets(d, color, p, rho * pixel);
    }
    float gloss = shine > 0.0 ? shine * gloss_of(n, to_lamp, to_nose) : 0.0;
    return min(color * strength_of(n, to_lamp, square, facing, open, lit) + gloss, vec3(1.0));
}
