// Where the line of sight of the nose meets the geodesic surface that a facet stands for, in s3. Needs
// frame.glsl, logmap.glsl and part_guard.glsl's inputs.

// (S, C) of the distances at which a·S + b·C = c: the one of two that is nearer to `at`.
vec2 on_line(float a, float b, float c, vec2 at) {
    float square = a * a + b * b;
    vec2 middle = c * vec2(a, b), aside = sqrt(max(square - c * c, 0.0)) * vec2(b, -a);
    vec2 p = (middle + aside) / square, q = (middle - aside) / square;
    return dot(p, at) > dot(q, at) ? p : q;
}

// The same where a·S² + 2·b·S·C + c·C² = 0.
vec2 on_conic(float a, float b, float c, vec2 at) {
    float root = sqrt(max(b * b - a * c, 0.0));
    vec2 p = abs(a) > abs(c) ? vec2(-b + root, a) : vec2(c, -b + root);
    vec2 q = abs(a) > abs(c) ? vec2(-b - root, a) : vec2(c, -b - root);
    p = normalize(p);
    q = normalize(q);
    float near = dot(p, at), far = dot(q, at);
    p = near < 0.0 ? -p : p;
    q = far < 0.0 ? -q : q;
    return abs(near) > abs(far) ? p : q;
}

// A point of the surface over rho. flat_at: the facet's, which is near.
vec4 on_surface(Draw d, vec4 flat_at) {
    int form = int(d.finish.z);
    vec3 u = normalize(tangent_m);
    // The way to image 1 is longer than half a turn, so its S is negative.
    vec2 at = vec2(dot(flat_at.xyz, u), flat_at.w), on;
    mat4 m = d.to[0]; // its columns are the part's axes and its place
    if (form == SPHERE) {
        on = on_line(dot(m[3].xyz, u), m[3].w, d.shape.y, at);
    } else if (form == TUBE) {
        vec2 a = vec2(dot(m[1].xyz, u), dot(m[2].xyz, u)), b = vec2(m[1].w, m[2].w);
        float s = d.shape.x * d.shape.x;
        on = on_conic(dot(a, a) - s, dot(a, b), dot(b, b) - s, at);
    } else {
        on = on_line(dot(m[1].xyz, u), m[1].w, 0.0, at);
    }
    return vec4(on.x * u, on.y);
}

// How far along the eye's z a step in tangent space leads.
float toward_eye(vec3 step_m) {
    mat4 e = view[image_of >> 2].eye_from_tangent;
    return e[0].z * step_m.x + e[1].z * step_m.y + e[2].z * step_m.z;
}
