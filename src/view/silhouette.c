#include "src/view/silhouette.h"

// The outline of a ball is where its surface turns away from the eye. Native view: the surface in
// tangent space is the log of a sphere about the ball's centre; along each of OUTLINE meridians
// that run from the point towards the eye to the point away from it, (Q − e)·grad F changes sign
// once, F being the cosine of the distance to the centre. The outline is then a smooth closed
// curve, sampled evenly in the meridian's angle, so derivatives and integrals over it are
// trigonometric sums that converge faster than any power of OUTLINE.
enum { OUTLINE = 128 };

struct ball_view {
    struct ap_space space; // rho_m = 1; what follows is over rho
    int image;
    struct ap_vec3 eye;    // in tangent space
    struct ap_vec3 centre; // tangent image of the centre: u·d
    struct ap_vec3 u;      // unit
    double d, radius;
    struct ap_iso nose_from_ball; // −z of the ball's frame points roughly at the eye
    const struct ap_viewer *viewer;
    int eye_index;
};

static const double limit_cos = 0.17364817766693035; // cos 80°

// exp of a tangent vector, on either image.
static struct ap_vec4 exp_of(struct ap_space space, struct ap_vec3 v) {
    double r = ap_vec3_length(v);
    struct ap_vec3 p = ap_vec3_scale(ap_space_sin(space, r), ap_vec3_normalize(v));
    return (struct ap_vec4){p.x, p.y, p.z, ap_space_cos(space, r)};
}

static struct ap_quat turn_from_to(struct ap_vec3 a, struct ap_vec3 b) {
    struct ap_vec3 n = ap_vec3_cross(a, b);
    double s = ap_vec3_length(n), c = ap_vec3_dot(a, b);
    if (s < 1e-12) {
        if (c > 0)
            return AP_QUAT_IDENTITY;
        struct ap_vec3 any =
            fabs(a.x) < 0.7 ? (struct ap_vec3){1, 0, 0} : (struct ap_vec3){0, 1, 0};
        return ap_quat_from_axis_angle(ap_vec3_normalize(ap_vec3_cross(a, any)), M_PI);
    }
    return ap_quat_from_axis_angle(ap_vec3_scale(1 / s, n), atan2(s, c));
}

// The direction at the ball's centre, in the frame of translate(centre), that is seen as `t` in
// tangent space: across the line of sight tangent space is stretched by d/S(d).
static struct ap_vec3 pull_back(const struct ball_view *v, struct ap_vec3 t) {
    double along = ap_vec3_dot(t, v->u);
    struct ap_vec3 across = ap_vec3_sub(t, ap_vec3_scale(along, v->u));
    double shrink = v->d > 0 ? ap_space_sin(v->space, v->d) / v->d : 1;
    return ap_vec3_normalize(
        ap_vec3_add(ap_vec3_scale(along, v->u), ap_vec3_scale(shrink, across)));
}

static bool ball_view_init(struct ball_view *v, const struct ap_viewer *viewer, int eye,
                           struct ap_vec4 world_centre, double radius_m, int image) {
    double rho = viewer->space.rho_m;
    struct ap_nose_point nose = ap_nose_from_world(viewer, world_centre);
    v->space = (struct ap_space){viewer->space.kappa, 1};
    v->viewer = viewer;
    v->eye_index = eye;
    v->image = image;
    v->radius = radius_m / rho;
    v->eye = ap_vec3_scale(1 / rho, viewer->eye[eye].view_from_eye.p);
    v->centre = ap_vec3_scale(1 / rho, ap_tangent_from_nose(viewer->space, nose, image).x);
    v->d = ap_vec3_length(v->centre);
    v->u = ap_vec3_normalize(v->centre);
    // A ball that holds the nose or its antipode has no outline in tangent space.
    double far = v->space.kappa > 0 ? fmin(fabs(v->d - M_PI), 2 * M_PI - v->d) : v->d;
    if (v->d <= v->radius || far <= v->radius)
        return false;
    struct ap_vec3 to_eye = pull_back(v, ap_vec3_sub(v->eye, v->centre));
    struct ap_iso place = ap_iso_translate(v->space, v->centre);
    struct ap_quat face = turn_from_to((struct ap_vec3){0, 0, -1}, to_eye);
    v->nose_from_ball = ap_iso_mul(place, ap_iso_rotate(face));
    return true;
}

// The surface point at polar angle chi from the pole that faces the eye, azimuth (co, so); and how
// much it is turned away from the eye there (> 0: away).
static struct ap_vec3 surface_point(const struct ball_view *v, double chi, double co, double so) {
    double s = ap_space_sin(v->space, v->radius);
    struct ap_vec4 p = {s * sin(chi) * co, s * sin(chi) * so, -s * cos(chi),
                        ap_space_cos(v->space, v->radius)};
    return ap_log_unchecked(v->space, ap_iso_apply(&v->nose_from_ball, p), v->image);
}

static double turned_away(const struct ball_view *v, struct ap_vec3 q) {
    double r = ap_vec3_length(q);
    struct ap_vec3 h = ap_vec3_scale(1 / r, q);
    double chord = ap_vec3_length(ap_vec3_sub(h, v->u)) / 2, half2 = chord * chord;
    double sd = ap_space_sin(v->space, v->d), sr = ap_space_sin(v->space, r);
    double cr = ap_space_cos(v->space, r);
    double radial = ap_space_sin(v->space, r - v->d) + 2 * sd * cr * half2;
    struct ap_vec3 across =
        ap_vec3_sub(ap_vec3_sub(h, v->u), ap_vec3_scale(2 * half2, h)); // cos(gamma)·h − u
    struct ap_vec3 grad = ap_vec3_add(ap_vec3_scale(radial, h), ap_vec3_scale(sd * sr / r, across));
    return ap_vec3_dot(ap_vec3_sub(q, v->eye), grad);
}

// Where the eye sees a point of tangent space; NaN where it cannot.
static struct ap_vec3 line_to(const struct ball_view *v, struct ap_vec3 q) {
    struct ap_vec3 line = {NAN, NAN, NAN};
    struct ap_tangent_point p = {ap_vec3_scale(v->viewer->space.rho_m, q)};
    ap_sight_line_of_tangent(v->viewer, v->eye_index, p, &line);
    return ap_vec3_normalize(line);
}

// Somebody born in a curved space: her lines of sight are curved in tangent space. The surface
// turns away where its picture folds over: where the map from it to directions changes orientation.
// By central differences, whose error does not matter: at a fold the picture stands still.
static double folded(const struct ball_view *v, double chi, double azimuth) {
    static const double h = 1e-5;
    double ca = cos(azimuth), sa = sin(azimuth);
    struct ap_vec3 at = line_to(v, surface_point(v, chi, ca, sa));
    struct ap_vec3 down = ap_vec3_sub(line_to(v, surface_point(v, chi + h, ca, sa)),
                                      line_to(v, surface_point(v, chi - h, ca, sa)));
    struct ap_vec3 round =
        ap_vec3_sub(line_to(v, surface_point(v, chi, cos(azimuth + h), sin(azimuth + h))),
                    line_to(v, surface_point(v, chi, cos(azimuth - h), sin(azimuth - h))));
    return -ap_vec3_dot(at, ap_vec3_cross(down, round)) / (4 * h * h * sin(chi));
}

static double away(const struct ball_view *v, double chi, double azimuth, struct ap_vec3 q) {
    return v->viewer->mode == AP_VIEW_BORN ? folded(v, chi, azimuth) : turned_away(v, q);
}

// The chi where the meridian leaves the eye's sight: regula falsi (Illinois) within (0, pi).
static bool outline_point(const struct ball_view *v, double azimuth, struct ap_vec3 *q) {
    double margin = v->viewer->mode == AP_VIEW_BORN ? 1e-3 : 1e-9;
    double co = cos(azimuth), so = sin(azimuth), lo = margin, hi = M_PI - margin;
    double flo = away(v, lo, azimuth, surface_point(v, lo, co, so));
    double fhi = away(v, hi, azimuth, surface_point(v, hi, co, so));
    if (!(flo < 0 && fhi > 0))
        return false;
    int side = 0;
    double before = lo;
    for (int i = 0; i < 100; i++) {
        double mid = (flo * hi - fhi * lo) / (flo - fhi);
        *q = surface_point(v, mid, co, so);
        double f = away(v, mid, azimuth, *q);
        if (f == 0 || fabs(mid - before) < 1e-13)
            return true;
        before = mid;
        if (f > 0) {
            hi = mid, fhi = f;
            flo *= side > 0 ? 0.5 : 1;
            side = 1;
        } else {
            lo = mid, flo = f;
            fhi *= side < 0 ? 0.5 : 1;
            side = -1;
        }
    }
    return true;
}

// Weights of d/dt of the trigonometric interpolant through samples at t = 2·pi·k/OUTLINE: the
// derivative at k is the sum of weight[j]·x[k − j].
static void slope_weights(double weight[OUTLINE]) {
    weight[0] = 0;
    for (int j = 1; j < OUTLINE; j++)
        weight[j] = 0.5 * (j % 2 ? -1 : 1) / tan(M_PI * j / OUTLINE);
}

static double slope(const double weight[OUTLINE], const double *x, int k) {
    double sum = 0;
    for (int j = 1; j < OUTLINE; j++)
        sum += weight[j] * x[(k - j + OUTLINE) % OUTLINE];
    return sum;
}

// The largest value of the curve near its largest sample: the parabola through three samples.
static double peak(const double *x, double sign) {
    int best = 0;
    for (int k = 1; k < OUTLINE; k++)
        best = sign * x[k] > sign * x[best] ? k : best;
    double l = x[(best + OUTLINE - 1) % OUTLINE], m = x[best], r = x[(best + 1) % OUTLINE];
    double bend = l - 2 * m + r;
    return bend == 0 ? m : m - (l - r) * (l - r) / (8 * bend);
}

static void measure(const double *a, const double *b, struct ap_silhouette *out) {
    double area = 0, ma = 0, mb = 0, weight[OUTLINE];
    slope_weights(weight);
    for (int k = 0; k < OUTLINE; k++) {
        // Relative to the first point, so that small distant balls do not cancel.
        double x = a[k] - a[0], y = b[k] - b[0];
        double cross = x * slope(weight, b, k) - y * slope(weight, a, k);
        area += cross / 2;
        ma += x * cross / 3;
        mb += y * cross / 3;
    }
    out->centroid_a = a[0] + ma / area;
    out->centroid_b = b[0] + mb / area;
    out->area = fabs(area) * 2 * M_PI / OUTLINE;
    out->min_a = peak(a, -1);
    out->max_a = peak(a, 1);
    out->min_b = peak(b, -1);
    out->max_b = peak(b, 1);
}

// Whether all of the ball is on one side of her s3's antipode, which is a sphere in tangent space.
static bool one_way_round(const struct ball_view *v) {
    struct ap_space born = ap_viewer_born(v->viewer);
    double stretch = v->space.kappa > 0 ? v->d / fabs(sin(v->d)) : 1;
    double half = M_PI * born.rho_m / v->viewer->space.rho_m;
    return born.kappa <= 0 || fabs(v->d - half) > v->radius * fmax(1, stretch);
}

static bool surface_outline(const struct ball_view *v, struct ap_silhouette *out) {
    double a[OUTLINE], b[OUTLINE];
    for (int k = 0; k < OUTLINE; k++) {
        struct ap_vec3 q;
        if (!outline_point(v, 2 * M_PI * k / OUTLINE, &q))
            return false;
        struct ap_vec3 p = line_to(v, q);
        if (!(-p.z > limit_cos))
            return false;
        a[k] = p.x / -p.z;
        b[k] = p.y / -p.z;
    }
    measure(a, b, out);
    return true;
}

// The eye stands at exp of its offset in the space she was born in, and log brings it back: the
// same tangent point in every view.
static bool eye_inside(const struct ball_view *v) {
    if (v->image)
        return false; // the eye stands on image 0's side of the antipode
    struct ap_iso ball_from_nose = ap_iso_inverse(v->space, v->nose_from_ball);
    struct ap_vec4 p = ap_iso_apply(&ball_from_nose, exp_of(v->space, v->eye));
    return ap_vec3_length(ap_log_unchecked(v->space, p, 0)) <= v->radius;
}

// A cone about the unit vector u (u.z < 0) of half-angle alpha, cut by the plane z = −1: an
// ellipse whose long axis lies along (u.x, u.y).
static bool cone_outline(struct ap_vec3 u, double sin_alpha, struct ap_silhouette *out) {
    double across = hypot(u.x, u.y), cos_alpha = sqrt(1 - sin_alpha * sin_alpha);
    if (!(-u.z * cos_alpha - across * sin_alpha > limit_cos) || u.z >= 0)
        return false;
    double det = u.z * u.z - sin_alpha * sin_alpha;
    double along = sin_alpha * cos_alpha / det, aside = sin_alpha / sqrt(det);
    double ex = across > 0 ? u.x / across : 1, ey = across > 0 ? u.y / across : 0;
    double ha = hypot(along * ex, aside * ey), hb = hypot(along * ey, aside * ex);
    out->centroid_a = u.x * -u.z / det;
    out->centroid_b = u.y * -u.z / det;
    out->area = M_PI * along * aside;
    out->min_a = out->centroid_a - ha;
    out->max_a = out->centroid_a + ha;
    out->min_b = out->centroid_b - hb;
    out->max_b = out->centroid_b + hb;
    return true;
}

static bool tourist_outline(const struct ap_viewer *viewer, int eye, struct ap_vec4 world_centre,
                            double radius_m, int image, struct ap_silhouette *out) {
    struct ap_space unit = {viewer->space.kappa, 1};
    double rho = viewer->space.rho_m;
    struct ap_iso eye_from_nose = ap_eye_from_nose(viewer, eye);
    struct ap_vec4 p = ap_iso_apply(&eye_from_nose, ap_nose_from_world(viewer, world_centre).x);
    struct ap_vec3 v = ap_vec3_scale(1 / rho, (struct ap_vec3){p.x, p.y, p.z});
    double sin_d = ap_vec3_length(v), s = radius_m / rho;
    // In s3 sin d also tells that the eye's antipode is outside of the ball.
    if (sin_d <= ap_space_sin(unit, s) || (unit.kappa > 0 && s >= M_PI / 2))
        return false;
    struct ap_vec3 u = ap_vec3_scale((image ? -1 : 1) / sin_d, v);
    return cone_outline(u, ap_space_sin(unit, s) / sin_d, out);
}

bool ap_ball_silhouette(const struct ap_viewer *viewer, int eye, struct ap_vec4 world_centre,
                        double radius_m, int image, struct ap_silhouette *out) {
    struct ap_silhouette found;
    if (!(radius_m > 0) ||
        !ap_direction(viewer, eye, world_centre, image, &found.centre_a, &found.centre_b))
        return false;
    bool seen;
    if (viewer->mode == AP_VIEW_TOURIST) {
        seen = tourist_outline(viewer, eye, world_centre, radius_m, image, &found);
    } else {
        struct ball_view v;
        seen = ball_view_init(&v, viewer, eye, world_centre, radius_m, image) && !eye_inside(&v) &&
               one_way_round(&v) && surface_outline(&v, &found);
    }
    if (seen)
        *out = found;
    return seen;
}

static bool tourist_points(const struct ap_viewer *viewer, int eye, struct ap_vec4 world_centre,
                           double radius_m, int image, int count, struct ap_outline_point *points) {
    struct ap_silhouette whole;
    if (!tourist_outline(viewer, eye, world_centre, radius_m, image, &whole))
        return false;
    struct ap_iso eye_from_nose = ap_eye_from_nose(viewer, eye);
    struct ap_vec4 p = ap_iso_apply(&eye_from_nose, ap_nose_from_world(viewer, world_centre).x);
    struct ap_vec3 v = {p.x, p.y, p.z};
    struct ap_vec3 u = ap_vec3_scale(image ? -1 : 1, ap_vec3_normalize(v));
    double rho = viewer->space.rho_m;
    double sine = ap_space_sin(viewer->space, radius_m / rho) / (ap_vec3_length(v) / rho);
    double cosine = sqrt(1 - sine * sine);
    struct ap_vec3 any = fabs(u.x) < 0.7 ? (struct ap_vec3){1, 0, 0} : (struct ap_vec3){0, 1, 0};
    struct ap_vec3 e1 = ap_vec3_normalize(ap_vec3_cross(u, any)), e2 = ap_vec3_cross(u, e1);
    for (int k = 0; k < count; k++) {
        double turn = 2 * M_PI * k / count;
        struct ap_vec3 aside =
            ap_vec3_add(ap_vec3_scale(cos(turn), e1), ap_vec3_scale(sin(turn), e2));
        points[k].line = ap_vec3_add(ap_vec3_scale(cosine, u), ap_vec3_scale(sine, aside));
    }
    return true;
}

bool ap_ball_outline(const struct ap_viewer *viewer, int eye, struct ap_vec4 world_centre,
                     double radius_m, int image, int count, struct ap_outline_point *points,
                     struct ap_outline_point *nearest) {
    double a, b;
    if (!(radius_m > 0) || !ap_direction(viewer, eye, world_centre, image, &a, &b))
        return false;
    if (viewer->mode == AP_VIEW_TOURIST)
        return tourist_points(viewer, eye, world_centre, radius_m, image, count, points);
    struct ball_view v;
    if (!ball_view_init(&v, viewer, eye, world_centre, radius_m, image) || eye_inside(&v) ||
        !one_way_round(&v))
        return false;
    double rho = viewer->space.rho_m;
    for (int k = 0; k < count; k++) {
        struct ap_vec3 q;
        if (!outline_point(&v, 2 * M_PI * k / count, &q))
            return false;
        points[k] = (struct ap_outline_point){line_to(&v, q), ap_vec3_scale(rho, q)};
        if (!(-points[k].line.z > limit_cos))
            return false;
    }
    struct ap_vec3 pole = surface_point(&v, 1e-9, 1, 0);
    *nearest = (struct ap_outline_point){line_to(&v, pole), ap_vec3_scale(rho, pole)};
    return true;
}

double ap_vergence_of(struct ap_vec3 dir_left, struct ap_vec3 dir_right) {
    return atan2(dir_left.x, -dir_left.z) - atan2(dir_right.x, -dir_right.z);
}

double ap_vergence_distance(struct ap_vec3 eye_left, struct ap_vec3 dir_left,
                            struct ap_vec3 eye_right, struct ap_vec3 dir_right) {
    if (!(ap_vergence_of(dir_left, dir_right) > 0))
        return INFINITY;
    // Both lines leave their eyes: eye + t·dir. The shortest segment between them stands across
    // both; with unit directions its ends solve a 2×2 system whose determinant is sin² of the
    // angle.
    struct ap_vec3 l = ap_vec3_normalize(dir_left), r = ap_vec3_normalize(dir_right);
    struct ap_vec3 base = ap_vec3_sub(eye_right, eye_left), n = ap_vec3_cross(l, r);
    double det = ap_vec3_dot(n, n);
    if (!(det > 0))
        return INFINITY;
    double tl = ap_vec3_dot(ap_vec3_cross(base, r), n) / det;
    double tr = ap_vec3_dot(ap_vec3_cross(base, l), n) / det;
    struct ap_vec3 a = ap_vec3_add(eye_left, ap_vec3_scale(tl, l));
    struct ap_vec3 b = ap_vec3_add(eye_right, ap_vec3_scale(tr, r));
    return ap_vec3_length(ap_vec3_scale(0.5, ap_vec3_add(a, b)));
}
