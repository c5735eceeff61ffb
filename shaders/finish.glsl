// What a surface is made of, fragment by fragment, and its light: cloth with the shadows of balls and
// the mouths of pockets, wood, billiard balls with stripe and number. Needs frame.glsl, light.glsl.

layout(set = 0, binding = 2) uniform sampler2DArray decals; // coverage; a layer a text

// On the surface that takes them: balls that cast a shadow, and the mouths of pockets; their middles
// in its coordinates, and S of their radii, 0 where there is none. In a uniform buffer, and looked at
// by loops of a fixed length: what every pixel needs is then read once for many.
const int SHADOWS = 16, MOUTHS = 8;
layout(std140, set = 0, binding = 3) uniform Marks {
    vec4 mark_at[SHADOWS + MOUTHS];
    vec4 mark_sine[(SHADOWS + MOUTHS) / 4];
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
void shadows(vec4 p, vec4 n, vec4 to_lamp, float square, inout float open, inout float lit) {
    float lamp_sine = lamp_light.y * inversesqrt(square);
    for (int i = 0; i < SHADOWS; i++) {
        // n and to_lamp are tangent at p, so their products with the ball's middle are those with the
        // direction to it, times S of its distance.
        vec4 to_ball = kappa == 0 ? mark_at[i] - p : mark_at[i];
        float c = inner(p, mark_at[i]);
        float far = kappa == 0 ? dot(to_ball.xyz, to_ball.xyz) : float(kappa) * (1.0 - c * c);
        float near = inversesqrt(max(far, 1e-9));
        float s = min(mark_sine[i / 4][i % 4] * near, 1.0), cosine = sqrt(1.0 - s * s);
        open -= max(0.0, inner(n, to_ball) * near) * s * s;
        float along = clamp(inner(to_ball, to_lamp) * near, -1.0, 1.0);
        float beyond = sqrt(1.0 - along * along) * cosine - along * s; // sine of the angle past its rim
        lit *= s > 0.0 ? smoothstep(-lamp_sine, lamp_sine, beyond) : 1.0;
    }
    open = max(open, 0.0);
}

// The mouths of pockets: leather to the rim, black inside.
vec3 pockets(vec3 color, vec4 p, float pixel) {
    // Of all mouths the one that is nearest in terms of its radius.
    float soft = max(pixel, 1e-4), nearest = 1e9, rim = 0.0;
    for (int i = SHADOWS; i < SHADOWS + MOUTHS; i++) {
        vec4 way = mark_at[i] - p;
        float c = inner(p, mark_at[i]);
        float far = kappa == 0 ? dot(way.xyz, way.xyz) : float(kappa) * (1.0 - c * c);
        float sine = mark_sine[i / 4][i % 4], ratio = max(far, 0.0) / max(sine * sine, 1e-12);
        bool there = sine > 0.0 && (kappa <= 0 || c > 0.0) && ratio < nearest;
        nearest = there ? ratio : nearest;
        rim = there ? sine * rho : rim;
    }
    float r = sqrt(nearest) * rim;
    color = mix(color, vec3(0.10, 0.055, 0.03), rim > 0.0 ? smoothstep(-soft, soft, rim - r) : 0.0);
    color = mix(color, vec3(0.004), rim > 0.0 ? smoothstep(-soft, soft, 0.92 * rim - r) : 0.0);
    return color;
}

// What a fragment needs of its Draw.
struct Surface {
    vec4 lamp, nose, color, shape, finish;
};

Surface surface_of(int draw) {
    Draw d = draws[draw];
    return Surface(d.lamp, d.nose, d.color, d.shape, d.finish);
}

// p, n: place and normal in the part's coordinates, as they were interpolated.
vec3 finished(Surface d, vec4 p, vec4 n) {
    int finish = int(d.finish.x);
    bool ball = DRAWS == BALLS || (DRAWS == MATTE_ONLY && d.shape.z == BALL);
    bool sheet = DRAWS == SHEETS, stick = DRAWS == STICKS;
    vec3 u = p.xyz * inversesqrt(max(dot(p.xyz, p.xyz), 1e-12));
    if (ball) {
        p = vec4(d.shape.x * u, d.shape.y);
        n = vec4(d.shape.y * u, -float(kappa) * d.shape.x);
    } else if (kappa != 0) {
        p *= inversesqrt(abs(inner(p, p)));
    } else {
        p /= p.w;
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
    float shine = ball ? 0.42 : DRAWS != MATTE_ONLY && finish == WOOD ? 0.14 : 0.0;
    if (DRAWS != MATTE_ONLY && ball && finish >= POOL)
        color = ball_color(color, u, pixel / d.shape.x, finish == STRIPED, d.finish.y);
    else if (sheet && finish == CLOTH)
        color = cloth(color, rho * p.xz, rho * pixel);
    else if (stick && finish == WOOD)
        color = wood(color, rho * p.xyz, rho * pixel);
    if (sheet && d.finish.w > 0.5) {
        shadows(p, n, to_lamp, square, open, lit);
        color = pockets(color, p, rho * pixel);
    }
    float gloss = shine > 0.0 ? shine * gloss_of(n, to_lamp, to_nose) : 0.0;
    return min(color * strength_of(n, to_lamp, square, facing, open, lit) + gloss, vec3(1.0));
}
