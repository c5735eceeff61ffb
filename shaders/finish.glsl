// What a surface is made of, fragment by fragment, and its light: cloth with the shadows of balls and
// the mouths of pockets, wood, billiard balls with stripe and number. Needs frame.glsl, light.glsl.

layout(set = 0, binding = 2) uniform sampler2DArray decals; // coverage; a layer a text

// On the surface that takes them: balls that cast a shadow, and the mouths of pockets; their middles
// in its coordinates, and S of their radii, 0 where there is none, and 1/S² of the mouths'. In a
// uniform buffer, and looked at by loops whose length is fixed when a pipeline is made: what every
// pixel needs is then read once for many. MARKS: so many of each as the scene has, 256·mouths.
const int SHADOWS_MAX = 16, MOUTHS_MAX = 8;
layout(constant_id = 5) const int MARKS = SHADOWS_MAX + 256 * MOUTHS_MAX;
const int SHADOWS = MARKS & 255, MOUTHS = MARKS >> 8;
layout(std140, set = 0, binding = 3) uniform Marks {
    vec4 mark_at[SHADOWS_MAX + MOUTHS_MAX];
    vec4 mark_sine[(SHADOWS_MAX + MOUTHS_MAX) / 4];
    vec4 mouth_inverse[MOUTHS_MAX / 4];
};

float hashed(uint n) {
    n = (n ^ (n >> 15)) * 2246822519u;
    n ^= n >> 13;
    return float(n & 0xffffffu) / 16777215.0;
}

// Smooth, −1…1, of a mean near 0. A corner's number is its coordinates' products with large primes,
// of which the next one's are a sum away: products of integers are the dearest here.
float noise(vec2 x, int layer) {
    const uint ACROSS = 1597334677u, UP = 3812015801u;
    vec2 f = fract(x), s = f * f * (3.0 - 2.0 * f);
    ivec2 i = ivec2(floor(x));
    uint a = uint(i.x) * ACROSS, b = uint(i.y) * UP, c = uint(layer) * 2798796415u;
    float low = mix(hashed(a ^ b ^ c), hashed((a + ACROSS) ^ b ^ c), s.x);
    float high = mix(hashed(a ^ (b + UP) ^ c), hashed((a + ACROSS) ^ (b + UP) ^ c), s.x);
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
    float sharp = 0.5 * sqrt(square) / lamp_light.y; // of the lamp's sine, half the inverse
    for (int i = 0; i < SHADOWS; i++) {
        // n and to_lamp are tangent at p, so their products with the ball's middle are those with the
        // direction to it, times S of its distance.
        vec4 to_ball = kappa == 0 ? mark_at[i] - p : mark_at[i];
        float c = inner(p, mark_at[i]);
        float far = kappa == 0 ? dot(to_ball.xyz, to_ball.xyz) : float(kappa) * (1.0 - c * c);
        float near = inversesqrt(max(far, 1e-9));
        float s = min(mark_sine[i / 4][i % 4] * near, 1.0);
        open -= max(0.0, inner(n, to_ball) * near) * s * s;
        float along = clamp(inner(to_ball, to_lamp) * near, -1.0, 1.0);
        // The sine of the angle past its rim.
        float beyond = sqrt((1.0 - along * along) * (1.0 - s * s)) - along * s;
        float share = clamp(beyond * sharp + 0.5, 0.0, 1.0);
        lit *= s > 0.0 ? share * share * (3.0 - 2.0 * share) : 1.0;
    }
    open = max(open, 0.0);
}

// The mouths of pockets: leather to the rim, black inside.
vec3 pockets(vec3 color, vec4 p, float pixel) {
    // Of all mouths the one that is nearest in terms of its radius.
    float soft = max(pixel, 1e-4), nearest = 1e9, rim = 0.0;
    for (int k = 0; k < MOUTHS; k++) {
        int i = SHADOWS_MAX + k;
        vec4 way = mark_at[i] - p;
        float c = inner(p, mark_at[i]);
        float far = kappa == 0 ? dot(way.xyz, way.xyz) : float(kappa) * (1.0 - c * c);
        float sine = mark_sine[i / 4][i % 4];
        float ratio = max(far, 0.0) * mouth_inverse[k / 4][k % 4];
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
