#include "src/view/portal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// Slack for what is computed later in float32, as in cull.c.
#define SLACK 2e-6

enum { SIDES = 4 };

struct ap_sides ap_sides_of(const struct ap_viewer *viewer) {
    struct ap_sides s = {.tourist = viewer->mode == AP_VIEW_TOURIST};
    for (int e = 0; e < 2; e++) {
        const struct ap_view_eye *eye = &viewer->eye[e];
        const struct ap_frustum *f = &eye->frustum;
        struct ap_vec3 n[SIDES] = {
            {1, 0, f->left}, {-1, 0, -f->right}, {0, 1, f->down}, {0, -1, -f->up}};
        s.eye_m = fmax(s.eye_m, ap_vec3_length(eye->view_from_eye.p));
        if (s.tourist)
            s.eye_from_nose[e] = ap_eye_from_nose(viewer, e);
        for (int i = 0; i < SIDES; i++) {
            // Mirrored frusta have left and right exchanged: inward is where the middle is.
            struct ap_vec3 middle = {(f->left + f->right) / 2, (f->down + f->up) / 2, -1};
            struct ap_vec3 in = ap_vec3_normalize(n[i]);
            in = ap_vec3_dot(in, middle) < 0 ? ap_vec3_scale(-1, in) : in;
            if (!s.tourist) {
                in = ap_quat_rotate(eye->view_from_eye.q, in);
                s.offset_m[e][i] = ap_vec3_dot(in, eye->view_from_eye.p);
            }
            s.normal[e][i] = in;
        }
    }
    return s;
}

double ap_horizon_m(struct ap_space space, double radius_m, double half_angle_rad) {
    double rho = space.rho_m, sine = sin(fmin(half_angle_rad, M_PI / 2));
    if (space.kappa > 0 || !(sine > 0))
        return INFINITY;
    double s = ap_space_sin(space, radius_m / rho) / sine;
    return rho * (space.kappa < 0 ? asinh(s) : s);
}

// How far side i of eye e may lean: n·u >= this for the direction u of whatever it sees at a
// distance of d_m or more.
static double lean(const struct ap_sides *s, int e, int i, double d_m) {
    double h = s->offset_m[e][i];
    return (h < 0 ? fmax(h / d_m, -1) : 0) - SLACK;
}

// Whether a cap of half angle `spread` about the unit vector u is all below asin(least) from the
// plane of n: sin(angle of u) < sin(asin(least) − spread), where that is no full turn down.
static bool cap_below(double along, double least, double sin_spread, double cos_spread) {
    double rise = sqrt(1 - least * least);
    bool possible = -least * sin_spread < rise * cos_spread; // asin(least) − spread > −90°
    return possible && along < least * cos_spread - rise * sin_spread;
}

unsigned ap_sides_see_ball(const struct ap_sides *s, struct ap_space space, struct ap_vec4 centre,
                           double radius_m, int image) {
    double d = ap_base_distance(space, centre), rho = space.rho_m;
    double room = space.kappa > 0 ? fmin(d, M_PI * rho - d) : d;
    double near = image ? M_PI * rho : d - radius_m;
    if (room - radius_m < s->eye_m + 2 * AP_NEAR_M || radius_m > M_PI / 2 * rho)
        return 3;
    // S(d) is what is across, over rho.
    double across = sqrt(centre.x * centre.x + centre.y * centre.y + centre.z * centre.z);
    double q = rho * ap_space_sin(space, radius_m / rho) / across;
    double spread =
        asin(fmin(q, 1)) + (s->tourist ? 2 * asin(fmin(s->eye_m / (room - radius_m), 1)) : 0);
    if (!(spread < M_PI / 2))
        return 3;
    double sin_spread = s->tourist ? sin(spread) : q,
           cos_spread = sqrt(1 - sin_spread * sin_spread);
    double sign = image ? -1 : 1;
    unsigned seen = 3;
    for (int e = 0; e < 2; e++) {
        struct ap_vec4 p = s->tourist ? ap_iso_apply(&s->eye_from_nose[e], centre) : centre;
        struct ap_vec3 x = {p.x, p.y, p.z};
        double r = sqrt(ap_vec3_dot(x, x)), to = r > 0 ? sign / r : 0;
        for (int i = 0; i < SIDES; i++)
            if (cap_below(to * ap_vec3_dot(s->normal[e][i], x), lean(s, e, i, near), sin_spread,
                          cos_spread))
                seen &= ~(1u << e);
    }
    return seen;
}

void ap_portal_finish(struct ap_portal *portal) {
    free(portal->seen);
    for (int i = 0; i < 2; i++) {
        free(portal->stamp[i]);
        free(portal->place[i]);
    }
    *portal = (struct ap_portal){0};
}

// A way into a cell: the eyes that may look along it, and how far each sees to the sides.
struct way_in {
    unsigned eyes;
    struct ap_gaze gaze[2];
};

struct walk {
    struct ap_cells *cells;
    const struct ap_tiling *tiling;
    const struct ap_portal_params *params;
    struct ap_space space;
    struct ap_sides sides;
    struct way_in whole; // nothing stands before it
    struct ap_iso nose_from_base;
    bool mirrored;                   // nose_from_base is
    struct ap_iso look_from_nose[2]; // to each eye's axes; native: about the nose
    double eye_m[2];                 // each eye's distance from the nose
    struct ap_portal *portal;
    struct ap_portal_stats stats;
    uint32_t seen, refused, hidden; // stamps of this frame
};

static bool grow_stamps(struct ap_portal *p, size_t count) {
    if (count <= p->stamp_room)
        return true;
    size_t room = p->stamp_room ? p->stamp_room : 1024;
    while (room < count)
        room *= 2;
    for (int i = 0; i < 2; i++) {
        uint32_t *more = realloc(p->stamp[i], room * sizeof *more);
        if (!more)
            return false;
        memset(more + p->stamp_room, 0, (room - p->stamp_room) * sizeof *more);
        p->stamp[i] = more;
        more = realloc(p->place[i], room * sizeof *more);
        if (!more)
            return false;
        p->place[i] = more;
    }
    p->stamp_room = room;
    return true;
}

static bool grow_seen(struct ap_portal *p) {
    if (p->count < p->room)
        return true;
    size_t room = p->room ? 2 * p->room : 256;
    struct ap_seen_cell *more = realloc(p->seen, room * sizeof *more);
    if (!more)
        return false;
    p->seen = more;
    p->room = room;
    return true;
}

// A cell that is there already can be seen by another way too: whether there is more of it.
static void widen(const struct walk *w, struct ap_seen_cell *s, const struct way_in *way) {
    enum { MOST = 12 }; // then it is seen as if nothing stood before it
    for (int e = 0; e < 2; e++) {
        if (!(way->eyes >> e & 1))
            continue;
        bool is_new = !(s->eyes >> e & 1);
        bool grew = is_new || ap_gaze_add(&s->gaze[e], &way->gaze[e]);
        if (is_new)
            s->gaze[e] = way->gaze[e];
        s->eyes |= 1u << e;
        if (!grew)
            continue;
        if (!s->again && ++s->growths >= MOST)
            s->gaze[e] = ap_gaze_all(&w->params->viewer->eye[e].frustum);
        s->again = true;
    }
}

// Appends a cell unless it is there, too far or too much.
static void visit(struct walk *w, int32_t cell, int image, const struct way_in *way) {
    struct ap_portal *p = w->portal;
    if (!grow_stamps(p, (size_t)cell + 1)) {
        w->stats.budget++;
        return;
    }
    uint32_t *stamp = &p->stamp[image][cell];
    if (*stamp == w->seen) {
        uint32_t at = p->place[image][cell];
        if (at < p->count)
            widen(w, &p->seen[at], way);
        return;
    }
    w->stats.walls -= *stamp == w->hidden;
    p->place[image][cell] = UINT32_MAX;
    bool counted = *stamp == w->refused;
    *stamp = w->seen;
    w->stats.cone -= counted;
    const struct ap_cell *c = &w->cells->cells[cell];
    struct ap_seen_cell s = {.cell = cell, .image = image, .eyes = way->eyes, .again = true};
    memcpy(s.gaze, way->gaze, sizeof s.gaze);
    s.nose_from_cell = ap_iso_mul(w->nose_from_base, c->base_from_cell);
    s.reverses = c->reverses != w->mirrored;
    struct ap_vec4 centre = {s.nose_from_cell.m[0][3], s.nose_from_cell.m[1][3],
                             s.nose_from_cell.m[2][3], s.nose_from_cell.m[3][3]};
    double rho = w->space.rho_m, reach = w->tiling->circumradius_m;
    s.distance_m = rho * ap_base_distance((struct ap_space){w->space.kappa, 1}, centre);
    if (!(s.distance_m <= w->params->horizon_m)) {
        w->stats.size++;
        return;
    }
    if ((w->params->most_cells && p->count >= w->params->most_cells) || !grow_seen(p)) {
        w->stats.budget++;
        return;
    }
    s.near_m = fmax(s.distance_m - reach, 0);
    s.far_m = s.distance_m + reach;
    if (w->space.kappa > 0)
        s.far_m = fmin(s.far_m, M_PI * rho);
    p->place[image][cell] = (uint32_t)p->count;
    p->seen[p->count++] = s;
}

// Of a cell's corners: which sides of each eye's pyramid each is behind (a bit each).
static void outcodes(const struct walk *w, const struct ap_seen_cell *s, double d_m,
                     unsigned char code[2][AP_CELL_VERTICES]) {
    const struct ap_tiling *t = w->tiling;
    double sign = s->image ? -1 : 1;
    for (int e = 0; e < 2; e++) {
        struct ap_iso to = s->nose_from_cell;
        double least[SIDES];
        if (w->sides.tourist)
            to = ap_iso_mul(w->sides.eye_from_nose[e], to);
        for (int i = 0; i < SIDES; i++)
            least[i] = lean(&w->sides, e, i, d_m);
        for (int v = 0; v < t->vertex_count; v++) {
            struct ap_vec4 p = ap_iso_apply(&to, t->vertex_m[v]);
            struct ap_vec3 x = ap_vec3_scale(sign, (struct ap_vec3){p.x, p.y, p.z});
            double r = sqrt(ap_vec3_dot(x, x));
            unsigned behind = 0;
            for (int i = 0; i < SIDES; i++)
                behind |= (unsigned)(ap_vec3_dot(w->sides.normal[e][i], x) < least[i] * r) << i;
            code[e][v] = (unsigned char)behind;
        }
    }
}

// Bit f: eye e may see some of face f; false: nothing can be told, and all are. within: eyes that
// have all corners in front of all sides.
static bool faces_in_view(const struct walk *w, const struct ap_seen_cell *s, unsigned seen[2],
                          unsigned *within) {
    const struct ap_tiling *t = w->tiling;
    const unsigned all = (1u << t->face_count) - 1;
    double rho = w->space.rho_m, d = s->image ? M_PI * rho : s->near_m;
    double to_antipode = w->space.kappa > 0 ? M_PI * rho - s->far_m : INFINITY;
    *within = 0;
    seen[0] = seen[1] = all;
    // Where an eye may be in the cell, or lines of sight meet again, all directions are possible.
    if (w->params->no_cull || w->params->viewer->mode == AP_VIEW_BORN ||
        fmin(s->near_m, to_antipode) < w->sides.eye_m + 2 * AP_NEAR_M)
        return false;
    unsigned char code[2][AP_CELL_VERTICES];
    outcodes(w, s, d, code);
    for (int e = 0; e < 2; e++) {
        unsigned any = 0;
        seen[e] = 0;
        for (int v = 0; v < t->vertex_count; v++)
            any |= code[e][v];
        // Leaned sides say "maybe", never "surely".
        *within |= any == 0 && w->sides.eye_m < 0.01 * d ? 1u << e : 0;
        for (int f = 0; f < t->face_count; f++) {
            unsigned behind = 15;
            for (int k = 0; k < t->symbol.p; k++)
                behind &= code[e][t->face_vertex[f][k]];
            seen[e] |= behind == 0 ? 1u << f : 0;
        }
    }
    return true;
}

// How far the nose is from the plane of a face, at least.
static double distance_to_plane(const struct walk *w, const struct ap_iso *cell_from_nose, int f) {
    const struct ap_space space = w->space;
    struct ap_vec4 base = {0, 0, 0, space.rho_m};
    double s = fabs(ap_tiling_beyond(w->tiling, ap_iso_apply(cell_from_nose, base), f));
    return space.rho_m * (space.kappa < 0 ? asinh(s) : space.kappa > 0 ? asin(fmin(s, 1)) : s);
}

// A cell as its windows are looked through: nothing stands in its faces without `windows`.
struct outlook {
    bool windows;
    struct ap_iso cell_from_nose;
    struct ap_iso eye_from_cell[2]; // the eye's axes about the nose (native) or itself (tourist)
};

static struct outlook outlook_of(const struct walk *w, const struct ap_seen_cell *s) {
    struct outlook out = {.windows = true};
    out.cell_from_nose = ap_iso_inverse(w->space, s->nose_from_cell);
    for (int e = 0; e < 2; e++)
        out.eye_from_cell[e] = ap_iso_mul(w->look_from_nose[e], s->nose_from_cell);
    return out;
}

// What eye e may see beyond the window in a face. False: nothing.
static bool look_through(const struct walk *w, const struct ap_seen_cell *s,
                         const struct outlook *out, int f, int e, struct ap_gaze *beyond) {
    struct ap_vec3 corner[5];
    double leaning = w->params->slack_rad + SLACK;
    if (!w->sides.tourist) {
        double d = fmax(s->near_m, distance_to_plane(w, &out->cell_from_nose, f));
        double lean = w->eye_m[e] / d;
        if (!(lean < 0.5)) {
            *beyond = s->gaze[e];
            return true;
        }
        leaning += lean; // at least the sine of the sum of both angles
    }
    for (int k = 0; k < w->tiling->symbol.p; k++) {
        struct ap_vec4 p = ap_iso_apply(&out->eye_from_cell[e], w->params->window[f].corner_m[k]);
        corner[k] = (struct ap_vec3){p.x, p.y, p.z};
    }
    return ap_gaze_through(&s->gaze[e], corner, w->tiling->symbol.p, leaning, beyond);
}

// The way on through a face that these eyes have in view.
static struct way_in way_through(const struct walk *w, const struct ap_seen_cell *s,
                                 const struct outlook *out, int f, unsigned eyes) {
    struct way_in way = {.eyes = eyes};
    memcpy(way.gaze, s->gaze, sizeof way.gaze);
    for (int e = 0; out->windows && e < 2; e++)
        if (eyes >> e & 1 && !look_through(w, s, out, f, e, &way.gaze[e]))
            way.eyes &= ~(1u << e);
    return way;
}

// A cell that is not gone on to: why, unless it is known by another way.
static void refuse(struct walk *w, uint32_t *stamp, bool in_view) {
    if (*stamp == w->seen || *stamp == w->hidden || (*stamp == w->refused && !in_view))
        return;
    w->stats.cone -= *stamp == w->refused;
    *stamp = in_view ? w->hidden : w->refused;
    if (in_view)
        w->stats.walls++;
    else
        w->stats.cone++;
}

static void go_on(struct walk *w, size_t at) {
    struct ap_seen_cell s = w->portal->seen[at];
    unsigned within, seen[2];
    bool told = faces_in_view(w, &s, seen, &within);
    struct outlook out = {.windows = false};
    if (told && w->params->window && s.image == 0) // image 1 is entered as a whole
        out = outlook_of(w, &s);
    w->portal->seen[at].within = within;
    w->portal->seen[at].again = false;
    for (int f = 0; f < w->tiling->face_count; f++) {
        int32_t next = ap_cells_across(w->cells, s.cell, f);
        unsigned in_view = (seen[0] >> f & 1) | (seen[1] >> f & 1) << 1;
        unsigned eyes = told ? in_view & s.eyes : 3; // an eye may be in another cell than the nose
        if (next < 0 || !grow_stamps(w->portal, (size_t)next + 1)) {
            w->stats.budget += eyes != 0;
            continue;
        }
        struct way_in way = told ? way_through(w, &s, &out, f, eyes) : w->whole;
        if (way.eyes)
            visit(w, next, s.image, &way);
        else
            refuse(w, &w->portal->stamp[s.image][next], in_view != 0);
    }
}

// Until no cell is seen by more than what has been gone on from.
static size_t go_on_from(struct walk *w, size_t first) {
    struct ap_portal *p = w->portal;
    bool more = true;
    while (more) {
        more = false;
        for (size_t at = first; at < p->count; at++)
            if (p->seen[at].again) {
                more = true;
                go_on(w, at);
            }
    }
    return p->count;
}

static double determinant(const struct ap_iso *a) {
    double det = 0;
    for (int i = 0; i < 4; i++) {
        double m[3][3];
        for (int r = 0, k = 0; r < 4; r++) {
            if (r == i)
                continue;
            for (int c = 0; c < 3; c++)
                m[k][c] = a->m[r][c + 1];
            k++;
        }
        double minor = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                       m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                       m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
        det += (i % 2 ? -1 : 1) * a->m[i][0] * minor;
    }
    return det;
}

// The cells in which lines of sight meet at the nose's antipode are where the long way round is
// entered; without one that is seen there is nothing behind.
static void enter_back(struct walk *w, size_t front_count) {
    double margin = w->sides.eye_m + 2 * AP_NEAR_M;
    for (size_t i = 0; i < front_count; i++) {
        const struct ap_seen_cell s = w->portal->seen[i];
        if (w->params->no_cull ||
            s.distance_m + w->tiling->circumradius_m > M_PI * w->space.rho_m - margin)
            visit(w, s.cell, 1, &w->whole);
    }
}

enum ap_status ap_portal_walk(struct ap_error *err, struct ap_cells *cells,
                              const struct ap_portal_params *params, struct ap_portal *portal,
                              struct ap_portal_stats *stats) {
    struct ap_space space = params->viewer->space;
    struct walk w = {.cells = cells,
                     .tiling = cells->tiling,
                     .params = params,
                     .space = space,
                     .sides = ap_sides_of(params->viewer),
                     .portal = portal};
    w.nose_from_base = ap_iso_inverse(space, params->viewer->world_from_nose);
    w.mirrored = determinant(&w.nose_from_base) < 0;
    portal->count = 0;
    if (portal->frame > UINT32_MAX - 6) {
        for (int i = 0; i < 2; i++)
            memset(portal->stamp[i], 0, portal->stamp_room * sizeof *portal->stamp[i]);
        portal->frame = 0;
    }
    portal->frame += 3;
    w.seen = portal->frame;
    w.refused = portal->frame + 1;
    w.hidden = portal->frame + 2;
    if (!grow_stamps(portal, 1) || !grow_seen(portal))
        return ap_fail(err, AP_ENVIRONMENT, "out of memory for the cells that are seen");
    w.whole.eyes = 3;
    for (int e = 0; e < 2; e++) {
        const struct ap_view_eye *eye = &params->viewer->eye[e];
        w.whole.gaze[e] = ap_gaze_all(&eye->frustum);
        w.look_from_nose[e] = w.sides.tourist ? w.sides.eye_from_nose[e]
                                              : ap_iso_rotate(ap_quat_conj(eye->view_from_eye.q));
        w.eye_m[e] = ap_vec3_length(eye->view_from_eye.p);
    }
    visit(&w, 0, 0, &w.whole);
    size_t front_count = go_on_from(&w, 0);
    if (space.kappa > 0) {
        enter_back(&w, front_count);
        go_on_from(&w, front_count);
    }
    w.stats.visited = (uint32_t)portal->count;
    *stats = w.stats;
    return AP_OK;
}
