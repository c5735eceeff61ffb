// Where the line of sight of the nose meets the geodesic surface that a facet stands for, in s3. Needs
// frame.glsl, logmap.glsl and part_guard.glsl's inputs.

// The one of two that is nearer to `at`; where both are, a small S is told apart by itself.
vec2 nearer(vec2 p, vec2 q, vec2 at) {
    return distance(p, at) < distance(q, at) ? p : q;
}

// (S, C) of the distances along u at which a plane is met, or a sphere whose centre is (m, b) and whose
// radius has the sine s and the cosine c: a·S + b·C = c with a = m·u. The root by what lies beside
// the line, since a small sphere's cosine has no digits left.
vec2 on_line(vec3 m, float b, float s, float c, vec3 u, vec2 at) {
    float a = dot(m, u), square = a * a + b * b;
    vec3 beside = m - a * u;
    float root = c == 0.0 ? sqrt(square) : sqrt(max(s * s - dot(beside, beside), 0.0));
    vec2 middle = c * vec2(a, b), aside = root * vec2(b, -a);
    return nearer((middle + aside) / square, (middle - aside) / square, at);
}

// The same where |S·m + C·n| = s, for a tube: m and n are what lies across its axis. The root without
// products that cancel, which at its limb would leave no digits.
vec2 on_tube(vec2 m, vec2 n, float s, vec2 at) {
    float mm = dot(m, m), nn = dot(n, n), a = mm - s * s, b = dot(m, n), c = nn - s * s;
    float turn = m.x * n.y - m.y * n.x;
    float root = sqrt(max(s * s * (mm + nn - s * s) - turn * turn, 0.0));
    vec2 p = abs(a) > abs(c) ? vec2(-b + root, a) : vec2(c, -b + root);
    vec2 q = abs(a) > abs(c) ? vec2(-b - root, a) : vec2(c, -b - root);
    p = normalize(p);
    q = normalize(q);
    return nearer(dot(p, at) < 0.0 ? -p : p, dot(q, at) < 0.0 ? -q : q, at);
}

// A point of the surface over rho. flat_at: the facet's, which is near.
vec4 on_surface(Draw d, vec4 flat_at) {
    int form = int(d.finish.z);
    if (form == FACETS)
        return flat_at;
    vec3 u = normalize(tangent_m);
    // The way to image 1 is longer than half a turn, so its S is negative.
    vec2 at = vec2(dot(flat_at.xyz, u), flat_at.w), on;
    mat4 m = d.to[0]; // its columns are the part's axes and its place
    vec4 centre = m[3];
    if (form == STICK) {
        // Its round caps begin beside the ends of its axis.
        float c = cos(d.root.w), s = sin(d.root.w), past = abs(dot(m[2], flat_at)) * c;
        if (past > dot(m[3], flat_at) * s) {
            form = SPHERE;
            centre = c * m[3] + (dot(m[2], flat_at) < 0.0 ? -s : s) * m[2];
        }
    }
    if (form == SPHERE) {
        on = on_line(centre.xyz, centre.w, d.shape.x, d.shape.y, u, at);
    } else if (form == TUBE || form == STICK) {
        int first = form == TUBE ? 1 : 0;
        vec4 across = m[first], up = m[first + 1];
        vec2 a = vec2(dot(across.xyz, u), dot(up.xyz, u)), b = vec2(across.w, up.w);
        on = on_tube(a, b, d.shape.x, at);
    } else {
        on = on_line(m[1].xyz, m[1].w, 1.0, 0.0, u, at);
    }
    return vec4(on.x * u, on.y);
}

// How far along the eye's z a step in tangent space leads.
float toward_eye(vec3 step_m) {
    mat4 e = view[image_of >> 2].eye_from_tangent;
    return e[0].z * step_m.x + e[1].z * step_m.y + e[2].z * step_m.z;
}
