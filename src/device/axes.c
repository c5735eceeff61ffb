#include "src/device/axes.h"

static bool parse_letter(const char **at, const char *end, unsigned char *source,
                         signed char *sign) {
    *sign = 1;
    if (*at < end && (**at == '-' || **at == '+'))
        *sign = *(*at)++ == '-' ? -1 : 1;
    if (*at == end || **at < 'x' || **at > 'z')
        return false;
    *source = (unsigned char)(*(*at)++ - 'x');
    return true;
}

bool ap_axes_parse(const char *text, size_t len, struct ap_axes *axes) {
    struct ap_axes a = {.given = true};
    const char *at = text, *end = text + len;
    for (int i = 0; i < 3; i++)
        if (!parse_letter(&at, end, &a.source[i], &a.sign[i]))
            return false;
    unsigned char x = a.source[0], y = a.source[1], z = a.source[2];
    if (at != end || x == y || y == z || z == x)
        return false;
    bool cyclic = (x + 1) % 3 == y;
    a.determinant = (signed char)(a.sign[0] * a.sign[1] * a.sign[2] * (cyclic ? 1 : -1));
    *axes = a;
    return true;
}

struct ap_vec3 ap_axes_vec3(const struct ap_axes *axes, struct ap_vec3 v) {
    if (!axes->given)
        return v;
    const double from[3] = {v.x, v.y, v.z};
    return (struct ap_vec3){axes->sign[0] * from[axes->source[0]],
                            axes->sign[1] * from[axes->source[1]],
                            axes->sign[2] * from[axes->source[2]]};
}

// In a mirror what turns to the left turns to the right.
struct ap_vec3 ap_axes_rate(const struct ap_axes *axes, struct ap_vec3 w) {
    return axes->given ? ap_vec3_scale(axes->determinant, ap_axes_vec3(axes, w)) : w;
}

struct ap_quat ap_axes_quat(const struct ap_axes *axes, struct ap_quat q) {
    struct ap_vec3 v = ap_axes_rate(axes, (struct ap_vec3){q.x, q.y, q.z});
    return (struct ap_quat){v.x, v.y, v.z, q.w};
}
