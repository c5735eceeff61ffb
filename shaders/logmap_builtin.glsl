// The log map by the language's own inverse functions, for measurements only: nothing that draws may
// include it (tests/render/test_shaders.c), since no driver gets these functions right.

vec3 tangent_by_builtin(int way, int kappa, int image, vec4 p) {
    if (kappa == 0)
        return p.xyz;
    float r = sqrt(dot(p.xyz, p.xyz)), theta, sine;
    if (way == 1 && kappa > 0) {
        theta = acos(clamp(p.w, -1.0, 1.0));
        sine = sin(theta);
    } else if (way == 1) {
        theta = acosh(max(p.w, 1.0));
        sine = sinh(theta);
    } else {
        theta = kappa > 0 ? atan(r, p.w) : asinh(r);
        sine = r;
    }
    if (image != 0)
        theta -= 2.0 * PI;
    return (sine < (way == 1 ? 1e-4 : 1e-30) ? 1.0 : theta / sine) * p.xyz;
}
