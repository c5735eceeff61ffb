#include "src/render/place/place.h"

#include <math.h>

#include "src/geom/table.h"
#include "src/view/cull.h"

static const double PI = 3.14159265358979323846;
static const double NEAR_ANTIPODE = 0.3; // over rho
static const double H3_EDGE_MAX = 20;    // over rho: ap_edge_miss_h3 is asked up to there
enum { CORNERS_MAX = 64 };

// The distance whose S is this; in s3 the one up to a quarter turn.
static double arc(struct ap_space space, double s) {
    double t = space.kappa > 0 ? asin(fmin(s, 1)) : space.kappa < 0 ? asinh(s) : s;
    return t * space.rho_m;
}

double ap_clearance(struct ap_space space, const struct ap_part *part,
                    struct ap_vec4 nose_in_part) {
    double rho = space.rho_m;
    enum ap_form form = ap_part_form(part);
    if (form == AP_FORM_PLANE)
        return arc(space, fabs(nose_in_part.y) / rho);
    if (form == AP_FORM_TUBE)
        return fmax(0, arc(space, hypot(nose_in_part.y, nose_in_part.z) / rho) - part->radius_m);
    if (part->kind == AP_PART_STICK)
        return fmax(0, arc(space, hypot(nose_in_part.x, nose_in_part.y) / rho) -
                           fmax(part->radius_m, part->radius2_m));
    return 0;
}

// Points in whose hull, thickened by *radius_m, the part lies.
static int hull(struct ap_space space, const struct ap_part *part, double reach_m,
                struct ap_vec4 points[CORNERS_MAX], double *radius_m) {
    double rho = space.rho_m;
    points[0] = (struct ap_vec4){0, 0, 0, rho};
    *radius_m = reach_m;
    if (part->kind == AP_PART_STICK) {
        double t = part->length_m / 2 / rho;
        double s = rho * ap_space_sin(space, t), c = rho * ap_space_cos(space, t);
        points[0] = (struct ap_vec4){0, 0, -s, c};
        points[1] = (struct ap_vec4){0, 0, s, c};
        *radius_m = fmax(part->radius_m, part->radius2_m);
        return 2;
    }
    if (part->kind != AP_PART_POLYGON || part->sides > CORNERS_MAX)
        return 1;
    double s = rho * ap_space_sin(space, reach_m / rho),
           c = rho * ap_space_cos(space, reach_m / rho);
    for (int i = 0; i < part->sides; i++) {
        double a = PI / part->sides * (2 * i + 1);
        points[i] = (struct ap_vec4){-s * sin(a), 0, -s * cos(a), c};
    }
    *radius_m = 0;
    return part->sides;
}

struct ap_place ap_place_part(const struct ap_place_params *params, const struct ap_part *part,
                              double reach_m) {
    const struct ap_viewer *viewer = params->viewer;
    struct ap_space space = viewer->space;
    struct ap_place place = {.nose_from_part = ap_iso_mul(params->nose_from_carrier[part->carrier],
                                                          part->carrier_from_part),
                             .reach_m = reach_m};
    struct ap_vec4 base = {0, 0, 0, space.rho_m};
    struct ap_vec4 centre = ap_iso_apply(&place.nose_from_part, base);
    struct ap_iso part_from_nose = ap_iso_inverse(space, place.nose_from_part);
    double d = ap_vec3_length(ap_log_unchecked(space, centre, 0));
    double clear = ap_clearance(space, part, ap_iso_apply(&part_from_nose, base));
    place.near_m = fmax(fmax(d - reach_m, clear), 0);
    place.far_m = d + reach_m;
    if (space.kappa > 0)
        place.far_m = fmin(place.far_m, PI * space.rho_m - clear);

    // Farther away matrices leave float's range, and what there is is smaller than 1e-20 of a
    // pixel.
    if (space.kappa < 0 && !(place.near_m < 60 * space.rho_m))
        return place;
    struct ap_vec4 points[CORNERS_MAX];
    struct ap_bounds bounds = {.nose_points = points};
    bounds.count = hull(space, part, reach_m, points, &bounds.radius_m);
    for (int i = 0; i < bounds.count; i++)
        points[i] = ap_iso_apply(&place.nose_from_part, points[i]);
    for (int image = 0; image < (space.kappa > 0 ? 2 : 1); image++)
        place.eyes[image] = params->no_cull ? 3 : ap_visible_eyes(viewer, &bounds, image);
    for (int i = 0; place.eyes[1] && i < params->screen_count; i++)
        if (ap_screen_hides_back(viewer, &params->screens[i], points, bounds.count, bounds.radius_m,
                                 place.near_m, place.far_m)) {
            place.behind = place.eyes[1];
            place.eyes[1] = 0;
        }
    return place;
}

bool ap_place_screen(const struct ap_place_params *params, const struct ap_part *part,
                     double reach_m, double slack_rad, struct ap_screen *screen) {
    if (params->no_cull || part->kind != AP_PART_POLYGON || part->sides > AP_SCREEN_SIDES)
        return false;
    struct ap_place place = ap_place_part(params, part, reach_m);
    struct ap_vec4 points[CORNERS_MAX];
    double radius_m;
    int count = hull(params->viewer->space, part, reach_m, points, &radius_m);
    for (int i = 0; i < count; i++)
        points[i] = ap_iso_apply(&place.nose_from_part, points[i]);
    return ap_screen_of(params->viewer, points, count, place.near_m, place.far_m, slack_rad,
                        screen);
}

struct ap_iso ap_plane_foot(struct ap_space space, const struct ap_iso *nose_from_part) {
    struct ap_iso part_from_nose = ap_iso_inverse(space, *nose_from_part);
    double x = part_from_nose.m[0][3], z = part_from_nose.m[2][3], w = part_from_nose.m[3][3];
    double far = hypot(x, z), along = far > 0 ? atan2(far, w) * space.rho_m / far : 0;
    return ap_iso_translate(space, (struct ap_vec3){along * x, 0, along * z});
}

bool ap_needs_guard(const struct ap_viewer *viewer, const struct ap_eyes *eyes,
                    const struct ap_place *place) {
    double rho = viewer->space.rho_m, eye = eyes->reach_m + 2 * AP_NEAR_M;
    if (place->near_m < eye)
        return true;
    return viewer->space.kappa > 0 && place->far_m > PI * rho - fmax(eye, NEAR_ANTIPODE * rho);
}

enum ap_form ap_part_form(const struct ap_part *part) {
    return part->kind == AP_PART_POLYGON       ? AP_FORM_PLANE
           : part->kind == AP_PART_SOLID       ? part->form
           : part->kind == AP_PART_BALL        ? AP_FORM_SPHERE
           : part->radius_m == part->radius2_m ? AP_FORM_STICK
                                               : AP_FORM_FACETS;
}

bool ap_is_stretched(const struct ap_viewer *viewer, const struct ap_place *place, int image) {
    return viewer->mode == AP_VIEW_NATIVE && viewer->space.kappa > 0 &&
           (image == 1 || place->far_m > (PI - NEAR_ANTIPODE) * viewer->space.rho_m);
}

bool ap_place_in_domain(const struct ap_place *place) {
    // 60 rho away in h3 entries are 6e25, and what is farther is culled.
    static const double MOST = 1e36;
    bool good = isfinite(place->near_m) && isfinite(place->far_m);
    for (int i = 0; i < 16; i++)
        good = good && fabs(place->nose_from_part.m[i / 4][i % 4]) < MOST;
    return good;
}

bool ap_clear_of_eyes(const struct ap_viewer *viewer, const struct ap_eyes *eyes,
                      const struct ap_place *place) {
    double eye = eyes->reach_m + 2 * AP_NEAR_M;
    return place->near_m >= eye &&
           (viewer->space.kappa <= 0 || place->far_m <= PI * viewer->space.rho_m - eye);
}

static struct ap_vec3 ahead_of(const struct ap_viewer *viewer, int e) {
    return ap_quat_rotate(viewer->eye[e].view_from_eye.q, (struct ap_vec3){0, 0, -1});
}

// The largest angle between where each eye looks to and anything of the part as the nose sees it;
// PI where nothing better is known.
static void off_axes(const struct ap_viewer *viewer, const struct ap_part *part,
                     const struct ap_place *place, int image, double off_rad[2]) {
    const struct ap_space space = viewer->space;
    const struct ap_vec3 ahead[2] = {ahead_of(viewer, 0), ahead_of(viewer, 1)};
    struct ap_vec4 points[CORNERS_MAX] = {{0, 0, 0, space.rho_m}};
    double radius_m = place->reach_m, rho = space.rho_m, worst[2] = {0};
    // Corners that lie in a circle narrower than a hemisphere have all that is between them in it.
    bool cornered = !place->anywhere && (part->kind == AP_PART_STICK ||
                                         (part->kind == AP_PART_POLYGON && part->sides <= 8));
    int count = cornered ? hull(space, part, place->reach_m, points, &radius_m) : 1;
    double lo = INFINITY, hi = 0;
    for (int i = 0; i < count; i++) {
        struct ap_vec4 p = ap_iso_apply(&place->nose_from_part, points[i]);
        struct ap_vec3 u = ap_vec3_normalize((struct ap_vec3){p.x, p.y, p.z});
        double d = ap_base_distance(space, p) / rho;
        for (int e = 0; e < 2; e++) {
            double off = acos(fmin(fmax(ap_vec3_dot(u, ahead[e]), -1), 1));
            worst[e] = fmax(worst[e], image ? PI - off : off);
        }
        lo = fmin(lo, d);
        hi = fmax(hi, d);
    }
    // The axis of a stick comes nearer than its ends do.
    double r = radius_m / rho;
    off_rad[0] = off_rad[1] = PI;
    if (count > 1)
        lo = fmin(lo, place->near_m / rho + r);
    if (count > 1 && space.kappa > 0)
        hi = fmax(hi, place->far_m / rho - r);
    if (!(r < lo) || (space.kappa > 0 && !(r + hi < PI)))
        return;
    double away = ap_space_sin(space, lo);
    if (space.kappa > 0)
        away = fmin(away, sin(hi));
    double wide = asin(fmin(ap_space_sin(space, r) / away, 1));
    for (int e = 0; e < 2; e++)
        off_rad[e] = worst[e] + wide;
}

// The least S, over rho, by which lengths across the line of sight are divided to be angles, for
// what lies near_m…far_m from the nose and is seen from beside it.
static double least_sine(const struct ap_viewer *viewer, const struct ap_eyes *eyes, double near_m,
                         double far_m) {
    struct ap_space space = viewer->space;
    double rho = space.rho_m, reach = eyes->reach_m;
    double s = ap_space_sin(space, fmax(near_m - reach, 0) / rho);
    if (space.kappa <= 0)
        return s;
    s = fmin(s, ap_space_sin(space, (far_m + reach) / rho));
    // Native: tangent space widens what is there, and the eye is so much nearer to it.
    double widened = fmin(ap_space_sin(space, near_m / rho), ap_space_sin(space, far_m / rho));
    return fmin(s, widened * (1 - fmin(reach / near_m, 1)));
}

// Pixels a radian, at most, at these angles from where each eye looks to, seen from the nose, of
// what is near_m…far_m away: off the axis angles are stretched.
static double pixels_at(const struct ap_viewer *viewer, const struct ap_eyes *eyes,
                        const double off_rad[2], double near_m, double far_m, int image) {
    double rho = viewer->space.rho_m, most = 0;
    double d = image ? 2 * PI * rho - far_m : near_m;
    // How far an eye's direction differs from the nose's.
    double aside = eyes->reach_m < d ? asin(eyes->reach_m / d) : PI;
    if (viewer->mode == AP_VIEW_TOURIST) {
        double s = least_sine(viewer, eyes, near_m, far_m);
        double beside = ap_space_sin(viewer->space, eyes->reach_m / rho);
        aside = beside < s ? asin(beside / s) : PI;
    }
    for (int e = 0; e < 2; e++) {
        double off = off_rad[e] + aside, corner = eyes->corner_rad[e];
        double slope = tan(!(off < corner) ? corner : off);
        most = fmax(most, eyes->pixels[e] * (1 + slope * slope));
    }
    return most;
}

// A round outline of radius r_m whose middle or axis is near_m…far_m away: what does not depend on
// how fine its facets are.
struct outline {
    double s, sine, whole, angle; // sine of the radius; its tangent; as it is seen
    bool known;
};

static struct outline outline_of(const struct ap_viewer *viewer, const struct ap_eyes *eyes,
                                 double r_m, double near_m, double far_m) {
    struct ap_space space = viewer->space;
    double r = r_m / space.rho_m;
    struct outline o = {.s = least_sine(viewer, eyes, near_m, far_m),
                        .sine = ap_space_sin(space, r)};
    o.known = o.s > 0 && o.sine / o.s < 0.95;
    if (!o.known)
        return o;
    o.whole = o.sine / ap_space_cos(space, r);
    o.angle = asin(o.sine / o.s);
    return o;
}

// How far inside it its facets fall, radians: the middle of a facet lies at the distance m from the
// axis with tan m = tan r · cos grain (tanh in h3).
static double outline_error(struct ap_space space, const struct outline *o, double grain,
                            double step_m) {
    if (!o->known)
        return INFINITY;
    // Along a tube a facet's edge is a geodesic: in h3 its middle is nearer to the axis than the
    // tube is (tanh by cosh of half the step), in s3 farther (tan by cos).
    double half = step_m / 2 / space.rho_m, whole = o->whole;
    double low = whole * (grain > 0 ? cos(grain) : 1) / (space.kappa < 0 ? cosh(half) : 1);
    double high = space.kappa > 0 ? whole / cos(fmin(half, 1.5)) : whole;
    double sunk = o->angle - asin(low / sqrt(1 + space.kappa * low * low) / o->s);
    if (space.kappa <= 0)
        return sunk;
    double raised = high / sqrt(1 + space.kappa * high * high) / o->s;
    return raised < 1 ? fmax(sunk, asin(raised) - o->angle) : INFINITY;
}

double ap_edge_miss_h3(double length, double d) {
    double near = cosh(d), end = near * cosh(length / 2), root = sqrt(end * end - 1);
    double tanh_near = sqrt(near * near - 1) / near, tanh_end = root / end;
    return 1.65 * (1 / d - tanh_end / (log(end + root) * tanh_near));
}

double ap_edge_miss_long_way(double length, double near, double far) {
    double s = fmin(sin(near), sin(far)), wide = length / s;
    return s > 0 ? wide * wide / (5.8 * (2 * PI - far)) : INFINITY;
}

// The straight edge in tangent space against the geodesic, seen from an eye beside the nose;
// radians. Checked on 539,000 random triangles: worst measured over bound 0.93.
static double edge_error(const struct ap_viewer *viewer, const struct ap_eyes *eyes,
                         const struct ap_place *place, int image, double edge_m, bool seams) {
    struct ap_space space = viewer->space;
    double e = eyes->reach_m, d = place->near_m;
    bool born = viewer->mode == AP_VIEW_BORN && viewer->born.kappa != 0;
    if ((space.kappa == 0 && !born) || viewer->mode == AP_VIEW_TOURIST)
        return 0; // geodesic triangles are drawn exactly
    if (!(d > 3 * e) || !(edge_m < d))
        return INFINITY;
    double square = edge_m * edge_m, rho = space.kappa ? space.rho_m : INFINITY;
    if (born) // both maps bend lines: at worst their curvatures add up
        rho = 1 / hypot(1 / rho, 1 / viewer->born.rho_m);
    double miss = square / (9 * d * rho * rho);
    if (space.kappa < 0 && !born && d > rho && d < H3_EDGE_MAX * rho)
        miss = fmin(miss, ap_edge_miss_h3(edge_m / rho, d / rho) / rho);
    double angle = e * miss / (1 - e / d);
    // How far a sheet's facets are off in depth: it shows where it meets others at a small angle.
    double sagitta = seams ? square / (8 * rho) : 0;
    if (space.kappa > 0) {
        double t = place->far_m / space.rho_m, stretch = t / sin(t);
        if (!(t < PI - 0.05))
            return INFINITY;
        angle *= t > PI / 2 ? stretch * stretch : 1;
        if (image == 1)
            angle = fmax(angle, e / rho * ap_edge_miss_long_way(edge_m / rho, d / rho, t));
        sagitta *= t > PI / 2 ? stretch : 1;
    }
    return angle + sagitta / d / 4;
}

// Near the antipode tangent space is so stretched that facets must be small against the distance
// that is left. Metres.
static double longest_facet(const struct ap_viewer *viewer, const struct ap_place *place) {
    double rho = viewer->space.rho_m;
    if (viewer->space.kappa <= 0 || viewer->mode == AP_VIEW_TOURIST)
        return INFINITY;
    return 0.3 * fmax(PI * rho - place->far_m, 0);
}

// A solid's facets: those of its round side, within `o`, turn by grain_rad.
static double solid_error(const struct ap_viewer *viewer, const struct ap_eyes *eyes,
                          const struct ap_place *place, int image, double radius_m,
                          const struct outline *o, double grain_rad, double step_m, bool tube) {
    double round = radius_m > 0 ? outline_error(viewer->space, o, grain_rad, tube ? step_m : 0) : 0;
    return round + edge_error(viewer, eyes, place, image, step_m, false);
}

static struct outline solid_outline(const struct ap_viewer *viewer, const struct ap_eyes *eyes,
                                    const struct ap_place *place, double radius_m) {
    if (!(radius_m > 0))
        return (struct outline){.known = false};
    return outline_of(viewer, eyes, radius_m, place->near_m + radius_m, place->far_m - radius_m);
}

// What ap_refine_part would cut for its length alone is not left to it: the rest of its part could
// not come near it.
static bool short_enough(const struct ap_viewer *viewer, const struct ap_line *line, int image,
                         double grain_rad, double step_m) {
    double rho = viewer->space.rho_m, near = line->near_m / rho, far = line->far_m / rho;
    bool straight = line->radius_m == 0 && viewer->space.kappa == 0;
    if (viewer->mode == AP_VIEW_TOURIST || straight)
        return true;
    if (viewer->space.kappa <= 0)
        return step_m < 0.7 * line->near_m;
    // Tangent space is so much wider there than what it shows.
    double stretch = far > PI / 2 ? far / sin(far) : 1, d = line->near_m;
    if (image == 1) {
        stretch = (2 * PI - near) / fmin(sin(near), sin(far));
        d = 2 * PI * rho - line->far_m;
    }
    double wide = step_m * stretch, round = line->radius_m * grain_rad * grain_rad / 2 * stretch;
    return wide < 0.7 * d && wide * wide / (8 * d) + round < 0.015 * d;
}

// Of the bound: what a line that pieces share may use up. Facets that end at it are off as far as
// it is, and a little more between its corners.
static const double SEAM_SHARE = 0.95;

int ap_line_depth(const struct ap_viewer *viewer, const struct ap_eyes *eyes,
                  const struct ap_line *line, int image, double max_error_px, int most) {
    const struct ap_place place = {.near_m = line->near_m, .far_m = line->far_m};
    if (viewer->mode == AP_VIEW_BORN)
        return -1;
    double off[2] = {PI, PI}; // in s3 what is between the ends may be farther off than they are
    for (int e = 0; e < 2 && viewer->space.kappa <= 0; e++) {
        struct ap_vec3 ahead = ahead_of(viewer, e);
        double least =
            fmin(ap_vec3_dot(ahead, line->toward[0]), ap_vec3_dot(ahead, line->toward[1]));
        off[e] = acos(fmin(fmax(least, -1), 1));
    }
    double pixels = pixels_at(viewer, eyes, off, line->near_m, line->far_m, image),
           longest = longest_facet(viewer, &place);
    const struct outline o = solid_outline(viewer, eyes, &place, line->radius_m);
    for (int depth = 0; depth <= most; depth++) {
        double grain = ldexp(line->bend_rad, -depth), step = ldexp(line->length_m, -depth);
        if (step < longest && short_enough(viewer, line, image, grain, step) &&
            solid_error(viewer, eyes, &place, image, line->radius_m, &o, grain, step, grain == 0) *
                    pixels <
                SEAM_SHARE * max_error_px)
            return depth;
    }
    return -1;
}

enum { LIT_LEVEL = 2 }; // a polygon's from which on light at the corners always does

// The outline that a part's facets are judged by.
static struct outline part_outline(const struct ap_viewer *viewer, const struct ap_eyes *eyes,
                                   const struct ap_part *part, const struct ap_place *place) {
    double centre = (place->near_m + place->far_m) / 2;
    if (part->kind == AP_PART_BALL)
        return outline_of(viewer, eyes, part->radius_m, centre, centre);
    return solid_outline(viewer, eyes, place, fmax(part->radius_m, part->radius2_m));
}

static bool fine_enough(const struct ap_viewer *viewer, const struct ap_eyes *eyes,
                        const struct ap_part *part, const struct ap_shape *shape,
                        const struct ap_place *place, const struct outline *o, int image,
                        double max_rad, int level) {
    double longest = longest_facet(viewer, place);
    double radius = fmax(part->radius_m, part->radius2_m);
    double grain = shape->grain[level], step = shape->step_m[level];
    switch (part->kind) {
    case AP_PART_BALL:
        return outline_error(viewer->space, o, grain, 0) < max_rad &&
               2 * part->radius_m * grain < longest;
    case AP_PART_STICK:
        return solid_error(viewer, eyes, place, image, radius, o, grain, step, true) < max_rad &&
               fmax(step, 2 * radius * grain) < longest;
    case AP_PART_POLYGON:
        // Plain ones have their light at their corners, which may not be far apart.
        if (part->lit && level < LIT_LEVEL && !(grain < 0.35 * place->near_m))
            return false;
        return edge_error(viewer, eyes, place, image, grain, !part->apart) < max_rad &&
               grain < longest;
    case AP_PART_SOLID:
        if (shape->levels < 2 || (grain == 0 && step == 0)) // it is what its mesh says
            return true;
        return solid_error(viewer, eyes, place, image, radius, o, grain, step,
                           part->form == AP_FORM_TUBE) < max_rad &&
               step < longest;
    }
    return true;
}

// Whether no seam need be cut, by what ap_line_depth would say at the worst: its bounds grow
// with the range of distances, the length of a step and the angle from the axis.
static bool seams_hold(const struct ap_viewer *viewer, const struct ap_eyes *eyes,
                       const struct ap_part *part, const struct ap_shape *shape,
                       const struct ap_place *place, const double off_rad[2], int image,
                       double max_error_px) {
    const double almost = 1 - 1e-9, anywhere[2] = {PI, PI};
    const struct ap_seam *worst = &shape->worst_seam;
    const struct ap_line line = {.near_m = place->near_m - worst->bulge_m,
                                 .far_m = place->far_m + worst->bulge_m,
                                 .radius_m = part->form == AP_FORM_PLANE ? 0 : part->radius_m};
    const struct ap_place within = {.near_m = line.near_m, .far_m = line.far_m};
    const struct outline o = solid_outline(viewer, eyes, &within, line.radius_m);
    bool grows = viewer->space.kappa >= 0 || line.far_m < H3_EDGE_MAX * viewer->space.rho_m;
    if (!grows || !(line.near_m > 0) || !(worst->length_m < longest_facet(viewer, &within)) ||
        !short_enough(viewer, &line, image, worst->bend_rad, worst->length_m))
        return false;
    double miss = solid_error(viewer, eyes, &within, image, line.radius_m, &o, worst->bend_rad,
                              worst->length_m, part->form == AP_FORM_TUBE);
    const double *off = viewer->space.kappa > 0 ? anywhere : off_rad;
    return miss * pixels_at(viewer, eyes, off, line.near_m, line.far_m, image) <
           almost * SEAM_SHARE * max_error_px;
}

bool ap_choose_level(const struct ap_viewer *viewer, const struct ap_eyes *eyes,
                     const struct ap_part *part, const struct ap_shape *shape,
                     const struct ap_place *place, int image, double max_error_px,
                     struct ap_level *level) {
    double off[2];
    off_axes(viewer, part, place, image, off);
    double max_rad =
        max_error_px / pixels_at(viewer, eyes, off, place->near_m, place->far_m, image);
    *level = (struct ap_level){.level = shape->levels - 1};
    if (viewer->mode == AP_VIEW_BORN)
        return false; // these bounds are not made for her space
    const struct outline o = part_outline(viewer, eyes, part, place);
    int k = 0;
    while (k < shape->levels &&
           !fine_enough(viewer, eyes, part, shape, place, &o, image, max_rad, k))
        k++;
    if (k == shape->levels)
        return false;
    level->level = k;
    level->whole_seams = shape->seam_count > 0 &&
                         seams_hold(viewer, eyes, part, shape, place, off, image, max_error_px);
    return true;
}
