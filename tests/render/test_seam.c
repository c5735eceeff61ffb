// Near s3's antipode everything is seen at nearly the same distance, so that what a facet is off in
// depth would decide where two surfaces meet. Two polygons that cross there, drawn and read back:
// at each pixel the nearer one along its line of sight shows, but for the seam's own pixels. And
// the long way round, where things a metre apart may be a full turn of 1e9 m away.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "src/view/exact.h"
#include "tests/render/stage.h"

static const double PI = 3.14159265358979323846;
enum { SIDE = 512 };

// 0 or 1: whose colour a pixel must have; −1: not both are there. *gap: how far one is before the
// other, over rho.
static int nearer(const struct ap_viewer *v, const struct ap_iso part_from_nose[2], int x, int y,
                  double *gap) {
    const struct ap_frustum *f = &v->eye[0].frustum;
    double rho = v->space.rho_m, d[2];
    struct ap_vec3 u =
        ap_vec3_normalize((struct ap_vec3){f->left + (x + 0.5) / SIDE * (f->right - f->left),
                                           f->up - (y + 0.5) / SIDE * (f->up - f->down), -1});
    for (int k = 0; k < 2; k++) {
        struct ap_vec3 at;
        if (!ap_exact_on_plane(v->space, &part_from_nose[k], u, PI * rho, &at))
            return -1;
        d[k] = ap_vec3_length(at);
        struct ap_vec4 q = {rho * sin(d[k] / rho) * u.x, rho * sin(d[k] / rho) * u.y,
                            rho * sin(d[k] / rho) * u.z, rho * cos(d[k] / rho)};
        q = ap_iso_apply(&part_from_nose[k], q);
        if (!(d[k] < PI * rho) || !(q.w > 0.8 * rho)) // well within the polygon
            return -1;
    }
    *gap = fabs(d[0] - d[1]) / rho;
    return d[0] < d[1] ? 0 : 1;
}

static int look(struct stage *stage, double off, double turn) {
    static int expected[SIDE][SIDE];
    struct ap_space space = {1, 1};
    struct ap_iso place =
        ap_iso_mul(ap_iso_translate(space, (struct ap_vec3){0, 0, -(PI - off)}),
                   ap_iso_rotate(ap_quat_from_axis_angle((struct ap_vec3){0, 0, 1}, turn)));
    struct ap_part parts[2] = {
        {.kind = AP_PART_POLYGON, .sides = 4, .edge_m = 1.2, .color_srgb = {1, 0, 0}},
        {.kind = AP_PART_POLYGON, .sides = 4, .edge_m = 1.2, .color_srgb = {0, 1, 0}}};
    struct ap_iso part_from_nose[2];
    for (int k = 0; k < 2; k++) {
        struct ap_quat tilt = ap_quat_from_axis_angle((struct ap_vec3){1, 0, 0}, 0.7 + 1.2 * k);
        parts[k].carrier_from_part = ap_iso_mul(place, ap_iso_rotate(tilt));
        part_from_nose[k] = ap_iso_inverse(space, parts[k].carrier_from_part);
    }
    struct ap_scene scene = stage_scene(space, parts, 2);
    struct ap_renderer_params how = {0};
    struct ap_renderer *renderer = stage_renderer(stage, &scene, &how);
    struct ap_frame_input input = stage_input(space, AP_VIEW_NATIVE, 0.7, 0);
    struct ap_frame_stats stats = stage_draw(stage, renderer, &input);
    const uint8_t *px = stage_eye(stage, 0);
    long seen[2] = {0, 0}, wrong = 0;
    double worst = 0;
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++) {
            double gap;
            expected[y][x] = nearer(&input.viewer, part_from_nose, x, y, &gap);
        }
    for (int y = 1; y < SIDE - 1; y++)
        for (int x = 1; x < SIDE - 1; x++) {
            double gap;
            int e = expected[y][x];
            bool seam = false;
            for (int j = 0; j < 9; j++)
                seam = seam || expected[y + j / 3 - 1][x + j % 3 - 1] != e;
            if (e < 0 || seam)
                continue;
            seen[e]++;
            const uint8_t *p = px + 4 * (y * SIDE + x);
            if (p[e] == 255 && p[1 - e] == 0)
                continue;
            wrong++;
            nearer(&input.viewer, part_from_nose, x, y, &gap);
            worst = fmax(worst, gap);
        }
    bool bad = wrong > 0 || seen[0] < 2000 || seen[1] < 2000;
    printf(
        "%.2f rho from the antipode: %ld of %ld and %ld pixels wrong (by up to %.5f rho of depth; "
        "none allowed), %llu triangles%s\n",
        off, wrong, seen[0], seen[1], worst, (unsigned long long)stats.eye[0].triangles,
        bad ? "  FAILED" : "");
    ap_renderer_destroy(renderer);
    return bad;
}

// Whether the nose looks at well within (1) or well without (−1) a polygon of half a metre, the
// long way round. 0: at its edge.
static int well_within(const struct ap_viewer *v, const struct ap_iso *part_from_nose, int x,
                       int y) {
    const struct ap_frustum *f = &v->eye[0].frustum;
    double rho = v->space.rho_m;
    struct ap_vec3 at,
        back =
            ap_vec3_normalize((struct ap_vec3){-(f->left + (x + 0.5) / SIDE * (f->right - f->left)),
                                               -(f->up - (y + 0.5) / SIDE * (f->up - f->down)), 1});
    if (!ap_exact_on_plane(v->space, part_from_nose, back, PI * rho / 2, &at))
        return -1;
    struct ap_vec4 q = ap_iso_apply(part_from_nose, ap_exp(v->space, at));
    double out_m = rho * fmax(fabs(q.x), fabs(q.z)) / q.w;
    return out_m < 0.24 ? 1 : out_m > 0.27 * rho * tan(0.25 / rho) / 0.25 ? -1 : 0;
}

// Two polygons behind her, 1 and 1.5 m off: what she sees of them the long way round is a full turn
// away less that, so the farther one stands before the nearer, however long a turn is.
static int behind(struct stage *stage, double rho_m) {
    struct ap_space space = {1, rho_m};
    struct ap_part parts[2];
    struct ap_iso part_from_nose[2];
    for (int k = 0; k < 2; k++) {
        struct ap_vec3 at = {0.2 * k, 0.02, 1 + 0.5 * k};
        struct ap_quat upright = ap_quat_from_axis_angle((struct ap_vec3){1, 0, 0}, PI / 2);
        parts[k] = (struct ap_part){
            .kind = AP_PART_POLYGON,
            .sides = 4,
            .edge_m = 0.5,
            .color_srgb = {k == 0, k == 1, 0},
            .carrier_from_part = ap_iso_mul(ap_iso_translate(space, at), ap_iso_rotate(upright))};
        part_from_nose[k] = ap_iso_inverse(space, parts[k].carrier_from_part);
    }
    struct ap_scene scene = stage_scene(space, parts, 2);
    struct ap_renderer_params how = {0};
    struct ap_renderer *renderer = stage_renderer(stage, &scene, &how);
    struct ap_frame_input input = stage_input(space, AP_VIEW_NATIVE, 0.6, 0);
    stage_draw(stage, renderer, &input);
    const uint8_t *px = stage_eye(stage, 0);
    long seen[2] = {0, 0}, wrong = 0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        int first = well_within(&input.viewer, &part_from_nose[0], i % SIDE, i / SIDE),
            second = well_within(&input.viewer, &part_from_nose[1], i % SIDE, i / SIDE);
        int e = second == 1 ? 1 : second == -1 && first == 1 ? 0 : -1;
        if (e < 0)
            continue;
        seen[e]++;
        wrong += px[4 * i + e] != 255 || px[4 * i + 1 - e] != 0;
    }
    bool bad = wrong > 0 || seen[0] < 2000 || seen[1] < 2000;
    printf("the long way round, rho %g m: %ld of %ld and %ld pixels wrong (none allowed)%s\n",
           rho_m, wrong, seen[0], seen[1], bad ? "  FAILED" : "");
    ap_renderer_destroy(renderer);
    return bad;
}

// A polygon that cuts an unlit ball in two, seen along its normal: the ball stands out of it within
// a circle of known radius.
static int cut_ball(struct stage *stage, int kappa, enum ap_view_mode mode) {
    static const double BALL_M = 0.3, FAR_M = 1, PLANE_M = 0.8, ALLOWED_PX = 0.3;
    struct ap_space space = {kappa, 1};
    struct ap_quat upright = ap_quat_from_axis_angle((struct ap_vec3){1, 0, 0}, PI / 2);
    struct ap_part parts[2] = {
        {.kind = AP_PART_BALL,
         .radius_m = BALL_M,
         .color_srgb = {1, 0, 0},
         .carrier_from_part = ap_iso_translate(space, (struct ap_vec3){0, 0, -FAR_M})},
        {.kind = AP_PART_POLYGON,
         .sides = 4,
         .edge_m = 0.7,
         .color_srgb = {0, 1, 0},
         .carrier_from_part = ap_iso_mul(ap_iso_translate(space, (struct ap_vec3){0, 0, -PLANE_M}),
                                         ap_iso_rotate(upright))}};
    // Right-angled triangles: C(ball) = C(far − plane)·C(h), tan(angle) = T(h)/S(plane).
    double gap = FAR_M - PLANE_M, h;
    if (kappa)
        h = kappa > 0 ? acos(cos(BALL_M) / cos(gap)) : acosh(cosh(BALL_M) / cosh(gap));
    else
        h = sqrt(BALL_M * BALL_M - gap * gap);
    double tangent = (kappa > 0 ? tan(h) : kappa < 0 ? tanh(h) : h) / ap_space_sin(space, PLANE_M);
    struct ap_scene scene = stage_scene(space, parts, 2);
    struct ap_renderer_params how = {0};
    struct ap_renderer *renderer = stage_renderer(stage, &scene, &how);
    struct ap_frame_input input = stage_input(space, mode, 0.7, 0);
    stage_draw(stage, renderer, &input);
    const struct ap_frustum *f = &input.viewer.eye[0].frustum;
    const uint8_t *px = stage_eye(stage, 0);
    double px_per_tangent = SIDE / (f->right - f->left), worst_px = 0;
    long seen = 0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        double a = f->left + (i % SIDE + 0.5) / px_per_tangent,
               b = f->up - (i / SIDE + 0.5) / px_per_tangent, off_px = hypot(a, b) - tangent;
        off_px *= px_per_tangent;
        bool ball = px[4 * i] == 255 && px[4 * i + 1] == 0,
             sheet = px[4 * i] == 0 && px[4 * i + 1] == 255;
        seen += ball;
        if ((ball && off_px > 0) || (sheet && off_px < 0))
            worst_px = fmax(worst_px, fabs(off_px));
    }
    double area = PI * tangent * tangent * px_per_tangent * px_per_tangent;
    bool bad = worst_px > ALLOWED_PX || fabs((double)seen - area) > 0.03 * area;
    printf("a ball cut by a plane, %s, %s: off by %.3f px (allowed %.3f), %ld of %.0f pixels%s\n",
           ap_space_name(space), mode == AP_VIEW_NATIVE ? "native" : "tourist", worst_px,
           ALLOWED_PX, seen, area, bad ? "  FAILED" : "");
    ap_renderer_destroy(renderer);
    return bad;
}

// How far a point of part coordinates, over rho, is from a stick's surface (s3).
static double from_stick(const struct ap_part *stick, struct ap_vec4 q) {
    double half = stick->length_m / 2, t = fmin(fmax(atan2(q.z, q.w), -half), half);
    double x = q.x, y = q.y, z = q.z - sin(t), w = q.w - cos(t);
    return 2 * asin(fmin(sqrt(x * x + y * y + z * z + w * w) / 2, 1)) - stick->radius_m;
}

// Where a line of sight first meets it, rho; INFINITY: it does not.
static double meets_stick(const struct ap_part *stick, const struct ap_iso *part_from_nose,
                          struct ap_vec3 u) {
    for (double t = 0, gap; t < PI; t += fmax(gap, 1e-4)) {
        gap = from_stick(stick,
                         ap_iso_apply(part_from_nose, (struct ap_vec4){sin(t) * u.x, sin(t) * u.y,
                                                                       sin(t) * u.z, cos(t)}));
        if (gap < 1e-6)
            return t;
    }
    return INFINITY;
}

// Which of the two is seen, 0 or 1; −1: not both are there, or they are all but equally far.
static int stick_or_sheet(const struct ap_viewer *v, const struct ap_part parts[2],
                          const struct ap_iso part_from_nose[2], int x, int y) {
    static const double LEAST = 2e-3; // of what is left to the antipode
    const struct ap_frustum *f = &v->eye[0].frustum;
    struct ap_vec3 at,
        u = ap_vec3_normalize((struct ap_vec3){f->left + (x + 0.5) / SIDE * (f->right - f->left),
                                               f->up - (y + 0.5) / SIDE * (f->up - f->down), -1});
    double stick = meets_stick(&parts[0], &part_from_nose[0], u);
    if (!isfinite(stick) || !ap_exact_on_plane(v->space, &part_from_nose[1], u, PI, &at))
        return -1;
    double sheet = ap_vec3_length(at);
    if (ap_iso_apply(&part_from_nose[1], ap_exp(v->space, at)).w < 0.85) // well within the polygon
        return -1;
    if (sheet > PI || fabs(sheet - stick) < LEAST * (PI - stick))
        return -1;
    return sheet < stick;
}

// A stick that ends near the antipode, and a polygon that cuts it there.
static int stick_end(struct stage *stage, double off) {
    struct ap_space space = {1, 1};
    struct ap_iso place =
        ap_iso_mul(ap_iso_translate(space, (struct ap_vec3){0, 0, -(PI - off)}),
                   ap_iso_rotate(ap_quat_from_axis_angle((struct ap_vec3){1, 0, 0}, 0.4)));
    struct ap_part parts[2] = {
        {.kind = AP_PART_STICK,
         .radius_m = off / 3,
         .radius2_m = off / 3,
         .length_m = 0.4,
         .color_srgb = {1, 0, 0},
         .carrier_from_part =
             ap_iso_mul(place, ap_iso_translate(space, (struct ap_vec3){0, 0, 0.2}))},
        {.kind = AP_PART_POLYGON,
         .sides = 4,
         .edge_m = 1.2,
         .color_srgb = {0, 1, 0},
         .carrier_from_part = ap_iso_mul(
             place, ap_iso_rotate(ap_quat_from_axis_angle((struct ap_vec3){0, 0, 1}, 0.3)))}};
    struct ap_iso part_from_nose[2];
    for (int k = 0; k < 2; k++)
        part_from_nose[k] = ap_iso_inverse(space, parts[k].carrier_from_part);
    struct ap_scene scene = stage_scene(space, parts, 2);
    struct ap_renderer_params how = {0};
    struct ap_renderer *renderer = stage_renderer(stage, &scene, &how);
    struct ap_frame_input input = stage_input(space, AP_VIEW_NATIVE, 0.7, 0);
    stage_draw(stage, renderer, &input);
    const uint8_t *px = stage_eye(stage, 0);
    long seen[2] = {0, 0}, wrong = 0;
    for (int y = 4; y < SIDE; y += 8)
        for (int x = 4; x < SIDE; x += 8) {
            int e = stick_or_sheet(&input.viewer, parts, part_from_nose, x, y);
            for (int k = 0; e >= 0 && k < 4; k++)
                if (stick_or_sheet(&input.viewer, parts, part_from_nose, x + (k & 1 ? 1 : -1),
                                   y + (k & 2 ? 1 : -1)) != e)
                    e = -1;
            if (e < 0)
                continue;
            const uint8_t *p = px + 4 * (y * SIDE + x);
            seen[e]++;
            wrong += p[e] != 255 || p[1 - e] != 0;
        }
    bool bad = wrong > 0 || seen[0] < 100 || seen[1] < 50;
    printf("a stick's end %.2f rho from the antipode: %ld of %ld and %ld pixels wrong (none "
           "allowed)%s\n",
           off, wrong, seen[0], seen[1], bad ? "  FAILED" : "");
    ap_renderer_destroy(renderer);
    return bad;
}

int main(void) {
    struct stage stage;
    if (!stage_open(&stage, SIDE, SIDE, true))
        return 77;
    int failures = 0;
    for (int k = 0; k < 4; k++)
        failures += look(&stage, 0.03 * (1 << k), 0.3 * k);
    for (int k = 0; k < 3; k++)
        failures += stick_end(&stage, 0.02 * (1 << k));
    for (double rho_m = 1; rho_m < 2e9; rho_m *= 1000)
        failures += behind(&stage, rho_m);
    failures += behind(&stage, 10);
    for (int kappa = -1; kappa <= 1; kappa++)
        failures +=
            cut_ball(&stage, kappa, AP_VIEW_NATIVE) + cut_ball(&stage, kappa, AP_VIEW_TOURIST);
    failures += stage.validation_errors;
    stage_close(&stage);
    return failures;
}
