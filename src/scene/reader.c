#include "src/scene/build.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/file.h"
#include "src/base/json.h"
#include "src/scene/honeycomb.h"

enum { MAX_OBJECTS = 100000, MAX_SIDES = 64 };

// A scene file being read.
struct reader {
    struct ap_scene_build build;
    const char *path;
    bool table, hands, cue; // each at most once
    struct ap_json_at objects;
    struct ap_honeycomb_plan plan; // where there is a honeycomb or a quotient
    bool has_plan;
};

static bool hex_color(const char *text, unsigned *rgb) {
    if (strlen(text) != 7 || text[0] != '#' || strspn(text + 1, "0123456789abcdefABCDEF") != 6)
        return false;
    *rgb = (unsigned)strtoul(text + 1, NULL, 16);
    return true;
}

static enum ap_status read_color(struct ap_error *err, const struct ap_json_at *object,
                                 const char *key, unsigned *rgb) {
    const char *text;
    if (!ap_json_has(object, key))
        return AP_OK;
    enum ap_status st = ap_json_string(err, object, key, &text);
    if (st)
        return st;
    struct ap_json_at at = ap_json_member(object, key);
    if (!hex_color(text, rgb))
        return ap_json_fail(err, &at, "expected a colour as \"#rrggbb\"");
    return AP_OK;
}

static enum ap_status read_length(struct ap_error *err, const struct ap_json_at *object,
                                  const char *key, double most_m, double *value_m) {
    double v;
    enum ap_status st = ap_json_number(err, object, key, &v);
    if (st)
        return st;
    struct ap_json_at at = ap_json_member(object, key);
    if (!(v > 0))
        return ap_json_fail(err, &at, "expected a length above 0, not %g", v);
    if (v > most_m)
        return ap_json_fail(err, &at, "%g m is too large: at most %g m", v, most_m);
    *value_m = v;
    return AP_OK;
}

// A tangent vector at the base point. In h3 coordinates grow like e^(d/rho).
static enum ap_status read_place(struct ap_error *err, const struct reader *r,
                                 const struct ap_json_at *object, const char *key, double most_rho,
                                 struct ap_vec3 *at_m) {
    double v[3];
    enum ap_status st = ap_json_numbers(err, object, key, 3, v);
    if (st)
        return st;
    struct ap_space space = r->build.scene->space;
    struct ap_vec3 p = {v[0], v[1], v[2]};
    double d = ap_vec3_length(p);
    struct ap_json_at at = ap_json_member(object, key);
    if (space.kappa > 0 && d > M_PI * space.rho_m)
        return ap_json_fail(err, &at,
                            "%.9g m from the base point: in s3 of radius %.9g m nothing is "
                            "farther than pi*radius = %.9g m",
                            d, space.rho_m, M_PI * space.rho_m);
    if (space.kappa < 0 && d > most_rho * space.rho_m)
        return ap_json_fail(err, &at, "%g m from the base point: at most %g times the radius of h3",
                            d, most_rho);
    if (!(d <= 1e9))
        return ap_json_fail(err, &at, "%g m from the base point: at most 1e9 m", d);
    *at_m = p;
    return AP_OK;
}

// `rotate`, if it is there, as pose logs have it: 0.9 < |q| < 1.1 is renormalised.
static enum ap_status read_turn(struct ap_error *err, const struct ap_json_at *object,
                                struct ap_quat *q) {
    double v[4];
    *q = AP_QUAT_IDENTITY;
    if (!ap_json_has(object, "rotate"))
        return AP_OK;
    enum ap_status st = ap_json_numbers(err, object, "rotate", 4, v);
    if (st)
        return st;
    double n = hypot(hypot(v[0], v[1]), hypot(v[2], v[3]));
    struct ap_json_at at = ap_json_member(object, "rotate");
    if (!(n > 0.9 && n < 1.1))
        return ap_json_fail(err, &at, "a quaternion (x, y, z, w) of length %g: expected 1", n);
    *q = ap_quat_normalize((struct ap_quat){v[0], v[1], v[2], v[3]});
    return AP_OK;
}

static enum ap_status read_look(struct ap_error *err, const struct ap_json_at *object,
                                unsigned *rgb, bool *lit) {
    enum ap_status st = read_color(err, object, "color", rgb);
    *lit = true;
    if (!st && ap_json_has(object, "lit"))
        st = ap_json_bool(err, object, "lit", lit);
    return st;
}

// The largest radius of a ball or stick; in h3 sinh of it must stay far from overflow.
static double most_radius(struct ap_space space) {
    return space.kappa > 0 ? M_PI / 2 * space.rho_m : space.kappa < 0 ? 100 * space.rho_m : 1e9;
}

static enum ap_status read_radius(struct ap_error *err, const struct reader *r,
                                  const struct ap_json_at *object, double *radius_m) {
    struct ap_space space = r->build.scene->space;
    enum ap_status st = read_length(err, object, "radius_m", INFINITY, radius_m);
    if (st)
        return st;
    double most = most_radius(space);
    struct ap_json_at at = ap_json_member(object, "radius_m");
    if (*radius_m >= most)
        return ap_json_fail(err, &at, "%.9g m: expected less than %.9g m%s", *radius_m, most,
                            space.kappa > 0 ? " (pi/2 times the radius of s3)" : "");
    return AP_OK;
}

// Names go into CSV files and pages.
static enum ap_status read_target(struct ap_error *err, const struct ap_json_at *object,
                                  struct ap_part *part) {
    const char *name;
    if (!ap_json_has(object, "target"))
        return AP_OK;
    enum ap_status st = ap_json_string(err, object, "target", &name);
    if (st)
        return st;
    struct ap_json_at at = ap_json_member(object, "target");
    size_t len = strlen(name);
    bool plain = len > 0 && len < sizeof part->name;
    for (size_t i = 0; i < len; i++)
        plain = plain && (unsigned char)name[i] >= ' ' && name[i] != 127 && name[i] != ',' &&
                name[i] != '"';
    if (!plain)
        return ap_json_fail(err, &at, "expected 1 to %zu bytes without commas, quotes and controls",
                            sizeof part->name - 1);
    if (part->lit)
        return ap_json_fail(err, &at, "a target is unlit: add \"lit\": false to this ball");
    memcpy(part->name, name, len + 1);
    part->target = true;
    return AP_OK;
}

static enum ap_status read_ball(struct ap_error *err, struct reader *r,
                                const struct ap_json_at *at) {
    static const char *const keys[] = {"at_m", "radius_m", "color", "lit", "target", NULL};
    struct ap_vec3 place;
    double radius = 0;
    unsigned rgb = 0xffffff;
    bool lit;
    enum ap_status st = ap_json_check_keys(err, at, keys);
    if (!st)
        st = read_place(err, r, at, "at_m", 300, &place);
    if (!st)
        st = read_radius(err, r, at, &radius);
    if (!st)
        st = read_look(err, at, &rgb, &lit);
    if (st)
        return st;
    struct ap_part part = ap_ball_part(ap_iso_translate(r->build.scene->space, place), radius, rgb);
    part.lit = lit;
    st = read_target(err, at, &part);
    if (!st)
        ap_build_part(&r->build, part);
    return st;
}

// From a to b: the middle of the geodesic, −z toward b.
static enum ap_status place_stick(struct ap_error *err, const struct reader *r,
                                  const struct ap_json_at *at, struct ap_vec3 a, struct ap_vec3 b,
                                  struct ap_iso *place, double *length_m) {
    struct ap_space space = r->build.scene->space;
    struct ap_iso world_from_a = ap_iso_translate(space, a);
    struct ap_iso a_from_world = ap_iso_inverse(space, world_from_a);
    struct ap_vec3 v = ap_log_unchecked(space, ap_iso_apply(&a_from_world, ap_exp(space, b)), 0);
    double length = ap_vec3_length(v);
    if (!(length > 0) || !isfinite(length))
        return ap_json_fail(err, at, "from_m and to_m are the same point, or opposite ones");
    if (space.kappa > 0 && length > (M_PI - 1e-6) * space.rho_m)
        return ap_json_fail(err, at,
                            "from_m and to_m are opposite points of s3: no way is shortest");
    struct ap_vec3 u = ap_vec3_scale(1 / length, v);
    struct ap_vec3 axis = ap_vec3_cross((struct ap_vec3){0, 0, -1}, u);
    double angle = atan2(ap_vec3_length(axis), -u.z);
    axis = ap_vec3_length(axis) > 0 ? ap_vec3_normalize(axis) : (struct ap_vec3){0, 1, 0};
    struct ap_iso turn = ap_iso_rotate(ap_quat_from_axis_angle(axis, angle));
    *place = ap_iso_mul(ap_iso_mul(world_from_a, turn), ap_shift(space, 0, 0, -length / 2));
    *length_m = length;
    return AP_OK;
}

static enum ap_status read_stick(struct ap_error *err, struct reader *r,
                                 const struct ap_json_at *at) {
    static const char *const keys[] = {"from_m", "to_m", "radius_m", "color", "lit", NULL};
    struct ap_vec3 a, b;
    struct ap_iso place;
    double radius = 0, length = 0;
    unsigned rgb = 0xd0b080;
    bool lit;
    enum ap_status st = ap_json_check_keys(err, at, keys);
    if (!st)
        st = read_place(err, r, at, "from_m", 12, &a);
    if (!st)
        st = read_place(err, r, at, "to_m", 12, &b);
    if (!st)
        st = read_radius(err, r, at, &radius);
    if (!st)
        st = read_look(err, at, &rgb, &lit);
    if (!st)
        st = place_stick(err, r, at, a, b, &place, &length);
    if (st)
        return st;
    struct ap_part part = ap_stick_part(place, length, radius, rgb);
    part.lit = lit;
    ap_build_part(&r->build, part);
    return AP_OK;
}

static enum ap_status read_posed(struct ap_error *err, const struct reader *r,
                                 const struct ap_json_at *at, struct ap_iso *place) {
    struct ap_vec3 p;
    struct ap_quat q;
    enum ap_status st = read_place(err, r, at, "at_m", 300, &p);
    if (!st)
        st = read_turn(err, at, &q);
    if (!st)
        *place = ap_iso_mul(ap_iso_translate(r->build.scene->space, p), ap_iso_rotate(q));
    return st;
}

static enum ap_status read_polygon(struct ap_error *err, struct reader *r,
                                   const struct ap_json_at *at) {
    static const char *const keys[] = {"at_m", "rotate", "sides", "edge_m", "color", "lit", NULL};
    struct ap_space space = r->build.scene->space;
    struct ap_iso place;
    double sides = 0, edge = 0, circum, in;
    unsigned rgb = 0x80a080;
    bool lit;
    enum ap_status st = ap_json_check_keys(err, at, keys);
    if (!st)
        st = read_posed(err, r, at, &place);
    if (!st)
        st = ap_json_number(err, at, "sides", &sides);
    struct ap_json_at sides_at = ap_json_member(at, "sides");
    if (!st && (!(sides >= 3 && sides <= MAX_SIDES) || sides != floor(sides)))
        st = ap_json_fail(err, &sides_at, "expected a whole number from 3 to %d", MAX_SIDES);
    if (!st)
        st = read_length(err, at, "edge_m", space.kappa < 0 ? 40 * space.rho_m : 1e9, &edge);
    if (!st)
        st = read_look(err, at, &rgb, &lit);
    if (st)
        return st;
    struct ap_error why = {""};
    struct ap_json_at edge_at = ap_json_member(at, "edge_m");
    if (ap_regular_polygon(&why, space, (int)sides, edge, &circum, &in))
        return ap_json_fail(err, &edge_at, "%s", why.text);
    struct ap_part part = ap_polygon_part(place, (int)sides, edge, rgb);
    part.lit = lit;
    ap_build_part(&r->build, part);
    return AP_OK;
}

// `file` is relative to the folder of the scene file.
static char *beside(const char *scene_path, const char *file) {
    const char *slash = strrchr(scene_path, '/');
    if (file[0] == '/' || !slash)
        return strdup(file);
    char *dir = strndup(scene_path, (size_t)(slash - scene_path + (slash == scene_path)));
    char *path = dir ? ap_path_join(dir, file) : NULL;
    free(dir);
    return path;
}

// All models have the same share of half of the budget.
static size_t model_budget(const struct reader *r) {
    size_t models = 0;
    for (size_t i = 0; i < json_array_size(r->objects.value); i++)
        models += json_object_get(json_array_get(r->objects.value, i), "model") != NULL;
    return ap_scene_budget(r->build.scene) / 2 / models;
}

static enum ap_status read_model(struct ap_error *err, struct reader *r,
                                 const struct ap_json_at *at) {
    static const char *const keys[] = {"at_m", "rotate", "file", "scale", "color", "lit", NULL};
    struct ap_model_request request = {.scale = 1, .rgb = -1};
    const char *file;
    unsigned rgb = 0;
    enum ap_status st = ap_json_check_keys(err, at, keys);
    if (!st)
        st = read_posed(err, r, at, &request.place);
    if (!st)
        st = ap_json_string(err, at, "file", &file);
    if (!st && ap_json_has(at, "scale"))
        st = read_length(err, at, "scale", 1e6, &request.scale);
    if (!st)
        st = read_look(err, at, &rgb, &request.lit);
    if (st)
        return st;
    if (ap_json_has(at, "color"))
        request.rgb = (long)rgb;
    char *path = beside(r->path, file);
    if (!path)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory for a path");
    request.path = path;
    request.most_bytes = model_budget(r);
    struct ap_error why = {""};
    st = ap_build_model(&why, &r->build, &request);
    free(path);
    struct ap_json_at file_at = ap_json_member(at, "file");
    if (st == AP_INPUT)
        return ap_json_fail(err, &file_at, "%s", why.text);
    return st ? ap_fail(err, st, "%s", why.text) : AP_OK;
}

// The three that have no members and stand in a scene at most once.
static enum ap_status read_single(struct ap_error *err, struct reader *r,
                                  const struct ap_json_at *at, bool *seen,
                                  void (*furnish)(struct ap_scene_build *)) {
    static const char *const none[] = {NULL};
    enum ap_status st = ap_json_check_keys(err, at, none);
    if (st)
        return st;
    if (*seen)
        return ap_json_fail(err, at, "a scene has only one %s", at->key);
    *seen = true;
    furnish(&r->build);
    return AP_OK;
}

static enum ap_status read_object(struct ap_error *err, struct reader *r,
                                  const struct ap_json_at *at) {
    static const char *const kinds[] = {"ball",  "stick", "polygon",   "model",    "table",
                                        "hands", "cue",   "honeycomb", "quotient", NULL};
    enum ap_status st = ap_json_check_keys(err, at, kinds);
    if (st)
        return st;
    if (json_object_size(at->value) != 1)
        return ap_json_fail(err, at,
                            "expected one of ball, stick, polygon, model, table, hands, "
                            "cue, honeycomb, quotient in each object");
    const char *kind = json_object_iter_key(json_object_iter((json_t *)at->value));
    struct ap_json_at thing = ap_json_member(at, kind);
    if (strcmp(kind, "ball") == 0)
        return read_ball(err, r, &thing);
    if (strcmp(kind, "stick") == 0)
        return read_stick(err, r, &thing);
    if (strcmp(kind, "polygon") == 0)
        return read_polygon(err, r, &thing);
    if (strcmp(kind, "model") == 0)
        return read_model(err, r, &thing);
    if (strcmp(kind, "table") == 0)
        return read_single(err, r, &thing, &r->table, ap_furnish_table);
    if (strcmp(kind, "hands") == 0)
        return read_single(err, r, &thing, &r->hands, ap_furnish_hands);
    if (strcmp(kind, "cue") == 0)
        return read_single(err, r, &thing, &r->cue, ap_furnish_cue);
    return ap_furnish_honeycomb(err, &thing, &r->plan, &r->build);
}

static int by_name(const void *a, const void *b) {
    const struct ap_part *p = *(struct ap_part *const *)a, *q = *(struct ap_part *const *)b;
    return strcmp(p->name, q->name);
}

static enum ap_status target_fails(struct ap_error *err, const struct reader *r,
                                   const struct ap_part *part, const char *why) {
    struct ap_json_at object = ap_json_element(&r->objects, (size_t)part->object);
    struct ap_json_at ball = ap_json_member(&object, "ball");
    struct ap_json_at at = ap_json_member(&ball, "target");
    return ap_json_fail(err, &at, "target '%s': %s", part->name, why);
}

static enum ap_status check_names(struct ap_error *err, const struct reader *r) {
    struct ap_scene *s = r->build.scene;
    struct ap_part **named = malloc((s->part_count + 1) * sizeof *named);
    if (!named)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory for %zu targets", s->part_count);
    size_t count = 0;
    for (size_t i = 0; i < s->part_count; i++)
        if (s->parts[i].target)
            named[count++] = &s->parts[i];
    qsort(named, count, sizeof *named, by_name);
    enum ap_status st = AP_OK;
    for (size_t i = 1; i < count && !st; i++)
        if (strcmp(named[i - 1]->name, named[i]->name) == 0)
            st = target_fails(err, r, named[i], "another target has this name");
    free(named);
    return st;
}

// A target is an unlit ball with a colour used once. One without a name is called by its place in
// the file.
static enum ap_status find_targets(struct ap_error *err, struct reader *r) {
    struct ap_scene *s = r->build.scene;
    unsigned char *used = calloc(1 << 24, 1); // how often a colour is used: 0, 1, more
    if (!used)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory for a table of colours");
    used[ap_color_rgb(s->background_srgb)] = 1;
    for (size_t i = 0; i < s->part_count; i++) {
        unsigned char *n = &used[ap_color_rgb(s->parts[i].color_srgb)];
        *n += *n < 2;
    }
    enum ap_status st = AP_OK;
    for (size_t i = 0; i < s->part_count && !st; i++) {
        struct ap_part *p = &s->parts[i];
        bool once = used[ap_color_rgb(p->color_srgb)] == 1;
        if (p->target && !once)
            st = target_fails(err, r, p,
                              "its colour is used more than once; a target needs its own");
        if (p->kind == AP_PART_BALL && !p->lit && once && !p->target) {
            p->target = true;
            snprintf(p->name, sizeof p->name, "object-%d", p->object);
        }
    }
    free(used);
    return st ? st : check_names(err, r);
}

// The file's space, and whether it has a table: both are needed before anything can be placed.
static enum ap_status read_space(struct ap_error *err, const struct ap_json_at *root,
                                 struct ap_space_request *request) {
    static const char *const keys[] = {"geometry", "radius_m", NULL};
    if (!ap_json_has(root, "space"))
        return AP_OK;
    struct ap_json_at at = ap_json_member(root, "space");
    enum ap_status st = ap_json_check_keys(err, &at, keys);
    if (!st && ap_json_has(&at, "geometry"))
        st = ap_json_string(err, &at, "geometry", &request->file_space_name);
    struct ap_space space;
    struct ap_json_at name_at = ap_json_member(&at, "geometry");
    if (!st && request->file_space_name &&
        ap_space_from_name(NULL, request->file_space_name, 1, &space))
        st = ap_json_fail(err, &name_at, "expected \"s3\", \"e3\" or \"h3\"");
    if (!st && ap_json_has(&at, "radius_m"))
        st = read_length(err, &at, "radius_m", 1e9, &request->file_radius_m);
    return st;
}

static enum ap_status check_objects(struct ap_error *err, const struct ap_json_at *objects,
                                    bool *has_table) {
    if (!json_is_array(objects->value))
        return ap_json_fail(err, objects, "expected an array of objects");
    size_t count = json_array_size(objects->value);
    if (count > MAX_OBJECTS)
        return ap_json_fail(err, objects, "%zu objects: at most %d", count, MAX_OBJECTS);
    *has_table = false;
    for (size_t i = 0; i < count; i++)
        *has_table |= json_object_get(json_array_get(objects->value, i), "table") != NULL;
    return AP_OK;
}

// The tiling, if there is one, has a say in what the space is.
static enum ap_status read_plan(struct ap_error *err, struct reader *r,
                                struct ap_space_request *request) {
    static const char *const kinds[] = {"honeycomb", "quotient"};
    size_t count = json_array_size(r->objects.value);
    enum ap_status st = AP_OK;
    for (size_t i = 0; i < 2 * count && !st; i++) {
        struct ap_json_at object = ap_json_element(&r->objects, i / 2);
        struct ap_json_at at = ap_json_member(&object, kinds[i % 2]);
        if (!at.value)
            continue;
        if (r->has_plan)
            return ap_json_fail(err, &at, "a scene has only one honeycomb or quotient");
        if (request->has_table)
            return ap_json_fail(err, &at, "a scene of cells has no table");
        r->has_plan = true;
        st = ap_honeycomb_plan_read(err, &at, &r->plan);
        struct ap_space space;
        // Where the command line names a space, it is that which is wrong.
        if (!st && request->file_space_name && !request->space_name &&
            !ap_space_from_name(NULL, request->file_space_name, 1, &space) &&
            space.kappa != r->plan.kappa)
            st = ap_json_fail(err, &at, "{%d,%d,%d} belongs to %s, not to %s", r->plan.symbol.p,
                              r->plan.symbol.q, r->plan.symbol.r,
                              ap_space_name((struct ap_space){r->plan.kappa, 1}),
                              request->file_space_name);
    }
    if (st || !r->has_plan)
        return st;
    if (!request->file_space_name)
        request->file_space_name = ap_space_name((struct ap_space){r->plan.kappa, 1});
    if (!(request->file_radius_m > 0))
        request->file_radius_m = ap_honeycomb_radius(&r->plan);
    return AP_OK;
}

// What stands in a world of cells stands in each of them, and must be inside of it: a cell is seen
// through its faces.
static enum ap_status into_cells(struct ap_error *err, struct reader *r) {
    struct ap_scene *s = r->build.scene;
    struct ap_vec4 base = {0, 0, 0, s->space.rho_m};
    for (size_t i = 0; i < s->part_count; i++) {
        struct ap_part *p = &s->parts[i];
        if (p->carrier != AP_CARRIER_WORLD)
            continue;
        p->carrier = AP_CARRIER_CELL;
        double reach = ap_part_reach(s, p);
        double most = ap_space_sin(s->space, reach / s->space.rho_m);
        for (int f = 0; f < s->honeycomb->tiling.face_count; f++) {
            double beyond = ap_tiling_beyond(&s->honeycomb->tiling,
                                             ap_iso_apply(&p->carrier_from_part, base), f);
            struct ap_json_at object = ap_json_element(&r->objects, (size_t)p->object);
            if (beyond > -most)
                return ap_json_fail(err, &object,
                                    "reaches out of the cell through face %d: everything in a "
                                    "world of cells is in each cell, and inside of it",
                                    f);
        }
    }
    return AP_OK;
}

static enum ap_status read_objects(struct ap_error *err, struct reader *r,
                                   const struct ap_json_at *root) {
    unsigned background = 0x000000;
    enum ap_status st = read_color(err, root, "background", &background);
    for (int i = 0; i < 3; i++)
        r->build.scene->background_srgb[i] = (double)(background >> (16 - 8 * i) & 255) / 255;
    size_t count = json_array_size(r->objects.value);
    for (size_t i = 0; i < count && !st; i++) {
        struct ap_json_at object = ap_json_element(&r->objects, i);
        r->build.object = (int)i;
        st = read_object(err, r, &object);
    }
    if (!st && r->has_plan)
        st = into_cells(err, r);
    return st ? st : find_targets(err, r);
}

static enum ap_status read_root(struct ap_error *err, const char *path, const json_t *document,
                                const struct ap_scene_params *params, struct ap_scene **scene) {
    static const char *const keys[] = {"space", "background", "objects", NULL};
    struct ap_json_at root = ap_json_root(document, path);
    struct ap_space_request request = {.space_name = params->space_name,
                                       .radius_m = params->radius_m,
                                       .table_edge_m = params->table_edge_m,
                                       .table_height_m = params->table_height_m,
                                       .budget_bytes = params->budget_bytes};
    struct reader r = {.path = path, .objects = ap_json_member(&root, "objects")};
    enum ap_status st = ap_json_check_keys(err, &root, keys);
    if (!st)
        st = check_objects(err, &r.objects, &request.has_table);
    if (!st)
        st = read_space(err, &root, &request);
    if (!st)
        st = read_plan(err, &r, &request);
    if (!st)
        st = ap_build_init(err, &request, &r.build);
    if (st)
        return st;
    st = read_objects(err, &r, &root);
    if (st)
        ap_build_abort(&r.build);
    return st ? st : ap_build_finish(err, &r.build, scene);
}

enum ap_status ap_scene_from_json(struct ap_error *err, const char *name, const json_t *document,
                                  const struct ap_scene_params *params, struct ap_scene **scene) {
    return read_root(err, name, document, params, scene);
}

enum ap_status ap_scene_read(struct ap_error *err, const char *path,
                             const struct ap_scene_params *params, struct ap_scene **scene) {
    json_t *document;
    enum ap_status st = ap_json_read(err, path, &document);
    if (st)
        return st;
    st = read_root(err, path, document, params, scene);
    json_decref(document);
    return st;
}
