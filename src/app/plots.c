#include "src/app/plots.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/app/html.h"

static const char AMBER[] = "#f0b45b", TEAL[] = "#5bc0be", VIOLET[] = "#b39cf5", GREY[] = "#717b89";

// --- a chart

struct chart {
    FILE *f;
    double left, top, width, height; // of the plot's area, in the units of the drawing
    double x0, x1, y0, y1;           // what it shows
};

static double chart_x(const struct chart *c, double x) {
    return (x - c->x0) / (c->x1 - c->x0) * c->width;
}

static double chart_y(const struct chart *c, double y) {
    return (c->y1 - y) / (c->y1 - c->y0) * c->height;
}

// 1, 2 or 5 times a power of ten, so that about four steps fill the span.
static double tick_step(double span) {
    double power = pow(10, floor(log10(span / 4))), rest = span / 4 / power;
    return (rest > 5 ? 10 : rest > 2 ? 5 : rest > 1 ? 2 : 1) * power;
}

static void svg_begin(FILE *f, double width, double height, const char *label) {
    fprintf(f, "<svg viewBox=\"0 0 %g %g\" role=\"img\" aria-label=\"%s\">\n", width, height,
            label);
}

static void chart_grid(const struct chart *c) {
    double sx = tick_step(c->x1 - c->x0), sy = tick_step(c->y1 - c->y0);
    for (double k = ceil(c->x0 / sx - 1e-9); k * sx <= c->x1 + 1e-9 * sx; k++) {
        double x = c->left + chart_x(c, k * sx);
        fprintf(c->f, "<path d=\"M%.1f %.1fv%.1f\" stroke=\"#272d37\"/>", x, c->top, c->height);
        fprintf(c->f, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%g</text>\n", x,
                c->top + c->height + 18, k == 0 ? 0 : k * sx);
    }
    for (double k = ceil(c->y0 / sy - 1e-9); k * sy <= c->y1 + 1e-9 * sy; k++) {
        double y = c->top + chart_y(c, k * sy);
        fprintf(c->f, "<path d=\"M%.1f %.1fh%.1f\" stroke=\"#272d37\"/>", c->left, y, c->width);
        fprintf(c->f, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">%g</text>\n", c->left - 8,
                y + 4, k == 0 ? 0 : k * sy);
    }
}

// Grid, labels, and an inner <svg> that cuts off what is drawn until chart_end.
static void chart_begin(const struct chart *c, const char *title, const char *x_label) {
    chart_grid(c);
    fprintf(c->f, "<text class=\"t\" x=\"%.1f\" y=\"%.1f\">%s</text>\n", c->left, c->top - 12,
            title);
    fprintf(c->f, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">%s</text>\n", c->left + c->width,
            c->top + c->height + 36, x_label);
    fprintf(c->f, "<svg x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\">\n", c->left, c->top,
            c->width, c->height);
}

static void chart_end(const struct chart *c) {
    fputs("</svg>\n", c->f);
}

// A line through the points; broken where one is not finite.
static void chart_line(const struct chart *c, const double *x, const double *y, size_t n,
                       const char *color, const char *style) {
    fprintf(c->f,
            "<path fill=\"none\" stroke=\"%s\" stroke-width=\"2\" stroke-linejoin=\"round\" "
            "%s d=\"",
            color, style);
    bool pen = false;
    for (size_t i = 0; i < n; i++) {
        bool here = isfinite(x[i]) && isfinite(y[i]);
        if (here) {
            // Far outside is as good as outside, and keeps the numbers short.
            double v = fmin(fmax(chart_y(c, y[i]), -1e4), 1e4);
            fprintf(c->f, "%c%.1f %.1f", pen ? 'L' : 'M', chart_x(c, x[i]), v);
        }
        pen = here;
    }
    fputs("\"/>\n", c->f);
}

static void chart_dot(const struct chart *c, double x, double y, const char *color) {
    if (isfinite(x) && isfinite(y) && fabs(chart_y(c, y)) < 1e4)
        fprintf(c->f, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"3\" fill=\"%s\" stroke=\"#0e1116\"/>\n",
                chart_x(c, x), chart_y(c, y), color);
}

static void legend(FILE *f, double x, double y, const char *color, const char *text) {
    fprintf(f,
            "<path d=\"M%.1f %.1fh18\" stroke=\"%s\" stroke-width=\"3\"/>"
            "<text x=\"%.1f\" y=\"%.1f\">%s</text>\n",
            x, y - 4, color, x + 24, y, text);
}

// --- the walk from above

struct panel {
    FILE *f;
    double cx, cy, scale; // drawing units, and of them a metre
};

// z points to the viewer, down on the page.
static void panel_point(const struct panel *p, char command, double x_m, double z_m) {
    fprintf(p->f, "%c%.1f %.1f", command, p->cx + p->scale * x_m, p->cy + p->scale * z_m);
}

enum { PATH_POINTS = 600 };

static struct ap_vec3 step_place(const struct ap_capture *c, const struct ap_capture_step *s,
                                 bool virtual_world) {
    return virtual_world ? ap_log_unchecked(c->space, s->world_p, 0) : s->table_p_m;
}

static void draw_device(const struct panel *p, const struct ap_capture *c, int device,
                        bool virtual_world) {
    static const char *const colors[] = {"#5bc0be", "#b39cf5", "#7fb069", "#d98cb3"};
    size_t n = 0, k = 0;
    for (size_t i = 0; i < c->step_count; i++)
        n += c->steps[i].device == device;
    size_t every = n / PATH_POINTS + 1;
    bool head = strcmp(c->devices[device], "head") == 0;
    fprintf(p->f,
            "<path fill=\"none\" stroke=\"%s\" stroke-width=\"%s\" stroke-linejoin=\"round\" "
            "opacity=\"%s\" d=\"",
            head ? AMBER : colors[device % 4], head ? "2.2" : "1.3", head ? "1" : ".75");
    for (size_t i = 0; i < c->step_count; i++) {
        if (c->steps[i].device != device)
            continue;
        if (k % every == 0 || k + 1 == n) {
            struct ap_vec3 v = step_place(c, &c->steps[i], virtual_world);
            panel_point(p, k ? 'L' : 'M', v.x, v.z);
        }
        k++;
    }
    fputs("\"/>\n", p->f);
}

// Where the captured pictures were taken, and which way the nose pointed.
static void draw_heads(const struct panel *p, const struct ap_capture *c, bool virtual_world) {
    const double ahead_m = 0.09;
    const struct ap_vec4 tip = ap_exp(c->space, (struct ap_vec3){0, 0, -ahead_m});
    size_t every = c->frame_count / 60 + 1;
    for (size_t i = 0; i < c->frame_count; i += every) {
        const struct ap_capture_frame *f = &c->frames[i];
        struct ap_vec3 a = f->table_from_head.p,
                       b = ap_pose_apply(f->table_from_head, (struct ap_vec3){0, 0, -ahead_m});
        if (virtual_world) {
            const struct ap_vec4 nose = {0, 0, 0, c->space.rho_m};
            a = ap_log_unchecked(c->space, ap_iso_apply(&f->world_from_head, nose), 0);
            b = ap_log_unchecked(c->space, ap_iso_apply(&f->world_from_head, tip), 0);
        }
        fputs("<path stroke=\"#f7dcae\" stroke-width=\"1.6\" d=\"", p->f);
        panel_point(p, 'M', a.x, a.z);
        panel_point(p, 'L', b.x, b.z);
        fprintf(p->f, "\"/><circle cx=\"%.1f\" cy=\"%.1f\" r=\"2.6\" fill=\"#f7dcae\"/>\n",
                p->cx + p->scale * a.x, p->cy + p->scale * a.z);
    }
}

static double reach(const struct ap_capture *c, bool virtual_world) {
    double most = c->has_table ? 0.75 * c->table_edge_m : 0.5;
    for (size_t i = 0; i < c->step_count; i++) {
        struct ap_vec3 v = step_place(c, &c->steps[i], virtual_world);
        if (isfinite(v.x) && isfinite(v.z))
            most = fmax(most, fmax(fabs(v.x), fabs(v.z)));
    }
    return 1.08 * most;
}

static const char TABLE_STYLE[] =
    "fill=\"#1d3b31\" stroke=\"#6fae91\" stroke-width=\"2\" stroke-linejoin=\"round\"";

static void draw_virtual_table(const struct panel *p, const struct ap_capture *c) {
    enum { EDGE_POINTS = 24 };
    struct ap_table_shape table =
        ap_table_from_edge(c->space.kappa, c->table_edge_m, c->space.rho_m);
    fprintf(p->f, "<path %s d=\"", TABLE_STYLE);
    for (int i = 0; i < table.sides * EDGE_POINTS; i++) {
        struct ap_iso edge = ap_table_edge_frame(&table, i / EDGE_POINTS);
        double s = ((double)(i % EDGE_POINTS) / EDGE_POINTS - 0.5) * table.edge_m;
        struct ap_vec4 at = ap_iso_apply(&edge, ap_exp(table.space, (struct ap_vec3){-s, 0, 0}));
        struct ap_vec3 v = ap_log_unchecked(table.space, at, 0);
        panel_point(p, i ? 'L' : 'M', v.x, v.z);
    }
    fputs("Z\"/>\n", p->f);
}

static void draw_real_table(const struct panel *p, const struct ap_capture *c) {
    double side = c->table_edge_m * p->scale;
    fprintf(p->f, "<path %s d=\"M%.1f %.1fh%.1fv%.1fh%.1fz\"/>\n", TABLE_STYLE, p->cx - side / 2,
            p->cy - side / 2, side, side, -side);
}

static void draw_panel(FILE *f, const struct ap_capture *c, double left, double size,
                       bool virtual_world) {
    struct panel p = {.f = f, .cx = size / 2, .cy = size / 2};
    p.scale = size / 2 / reach(c, virtual_world);
    fprintf(f, "<text class=\"t\" x=\"%.1f\" y=\"20\">%s</text>\n", left,
            virtual_world ? "the virtual table, and the walk in the curved world"
                          : "the real table, and the walk in the room");
    fprintf(f,
            "<svg x=\"%.1f\" y=\"34\" width=\"%.1f\" height=\"%.1f\">\n"
            "<rect width=\"100%%\" height=\"100%%\" rx=\"10\" fill=\"#0a0c10\"/>\n",
            left, size, size);
    // Circles of equal distance from the table's centre.
    double step = tick_step(2 * size / 2 / p.scale);
    for (int k = 1; k * step * p.scale < 0.75 * size; k++)
        fprintf(f,
                "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%.1f\" fill=\"none\" stroke=\"#222831\"/>"
                "<text x=\"%.1f\" y=\"%.1f\" style=\"fill:#59626f\">%g m</text>\n",
                p.cx, p.cy, k * step * p.scale, p.cx + 4, p.cy - k * step * p.scale - 4, k * step);
    if (c->has_table && virtual_world)
        draw_virtual_table(&p, c);
    else if (c->has_table)
        draw_real_table(&p, c);
    for (int d = c->device_count - 1; d >= 0; d--)
        draw_device(&p, c, d, virtual_world);
    draw_heads(&p, c, virtual_world);
    fputs("</svg>\n", f);
}

void ap_svg_walk(FILE *f, const struct ap_capture *capture) {
    svg_begin(f, 1060, 560, "the walk seen from above");
    draw_panel(f, capture, 0, 520, false);
    draw_panel(f, capture, 540, 520, true);
    fputs("</svg>\n", f);
}

// --- vergence

enum { CURVE_POINTS = 160 };

static const char *set_color(const struct ap_measured *m, size_t sets, int target, char text[8]) {
    if (sets > 1)
        return m->capture->space.kappa > 0 ? TEAL : m->capture->space.kappa ? AMBER : VIOLET;
    const uint8_t *c = m->capture->targets[target].color;
    snprintf(text, 8, "#%02x%02x%02x", c[0], c[1], c[2]);
    return text;
}

static void vergence_curve(const struct chart *c, struct ap_space space, enum ap_view_mode mode,
                           double ipd_m, const char *color, const char *style) {
    double x[CURVE_POINTS], y[CURVE_POINTS];
    for (int i = 0; i < CURVE_POINTS; i++) {
        double rad;
        x[i] = c->x1 * (i + 1) / CURVE_POINTS;
        y[i] =
            ap_vergence_ahead(NULL, space, mode, ipd_m, x[i], &rad) ? NAN : rad * 180 * 60 / M_PI;
    }
    chart_line(c, x, y, CURVE_POINTS, color, style);
}

static void vergence_dots(const struct chart *c, const struct ap_measured *sets, size_t count,
                          bool inferred) {
    char text[8];
    for (size_t k = 0; k < count; k++)
        for (size_t i = 0; i < sets[k].count; i++) {
            const struct ap_vergence_row *r = &sets[k].rows[i];
            chart_dot(c, r->true_m, inferred ? r->inferred_m : r->measured_arcmin,
                      set_color(&sets[k], count, r->target, text));
        }
}

struct span {
    double most_m, most_arcmin, least_arcmin;
};

static struct span measured_span(const struct ap_measured *sets, size_t count) {
    struct span s = {0, 0, 0};
    for (size_t k = 0; k < count; k++)
        for (size_t i = 0; i < sets[k].count; i++) {
            const struct ap_vergence_row *r = &sets[k].rows[i];
            if (isnan(r->measured_arcmin))
                continue;
            s.most_m = fmax(s.most_m, r->true_m);
            s.most_arcmin = fmax(s.most_arcmin, r->measured_arcmin);
            s.least_arcmin = fmin(s.least_arcmin, r->measured_arcmin);
        }
    if (!(s.most_m > 0))
        s = (struct span){2, 400, 0};
    return s;
}

static void vergence_legend(FILE *f, const struct ap_measured *sets, size_t count, double x) {
    if (count == 1) {
        legend(f, x, 304, AMBER, "native eyes, straight ahead");
        legend(f, x, 324, TEAL, "tourist eyes, straight ahead");
        return;
    }
    double y = 324 - 20 * (double)(count - 1);
    for (size_t k = 0; k < count; k++, y += 20)
        legend(f, x, y, set_color(&sets[k], count, 0, NULL),
               ap_html_space_title(sets[k].capture->space));
}

void ap_svg_vergence(FILE *f, const struct ap_measured *sets, size_t count) {
    struct span s = measured_span(sets, count);
    struct chart c = {.f = f,
                      .left = 56,
                      .top = 40,
                      .width = 460,
                      .height = 300,
                      .x1 = 1.06 * s.most_m,
                      .y0 = 1.2 * s.least_arcmin,
                      .y1 = 1.2 * s.most_arcmin};
    svg_begin(f, 1060, 390, "vergence and inferred distance against true distance");
    chart_begin(&c, "angle between the lines of sight (arc minutes)", "true distance (m)");
    for (size_t k = 0; k < count; k++) {
        const struct ap_capture *cap = sets[k].capture;
        char text[8];
        bool one = count == 1;
        const char *color = one ? AMBER : set_color(&sets[k], count, 0, text);
        vergence_curve(&c, cap->space, AP_VIEW_NATIVE, cap->headset.ipd_m, color, "");
        vergence_curve(&c, cap->space, AP_VIEW_TOURIST, cap->headset.ipd_m, one ? TEAL : color,
                       "stroke-dasharray=\"5 5\" opacity=\".8\"");
    }
    vergence_dots(&c, sets, count, false);
    chart_end(&c);
    vergence_legend(f, sets, count, c.left + 14);
    c.left = 590;
    c.width = 460;
    c.y0 = 0;
    c.y1 = 1.5 * c.x1;
    chart_begin(&c, "distance that the eyes infer from it (m)", "true distance (m)");
    double ends[2] = {0, c.x1};
    chart_line(&c, ends, ends, 2, GREY, "stroke-dasharray=\"4 5\"");
    vergence_dots(&c, sets, count, true);
    chart_end(&c);
    fputs("</svg>\n", f);
}

// --- three trackers

// Where the head is on its way round, table's frame, metres.
static struct ap_vec3 loop_place(double edge_m, double height_m, int step) {
    const double a = AP_LOOP_SIDE_M;
    int side = step * 4 / AP_LOOP_STEPS;
    double part = (double)(step * 4 - side * AP_LOOP_STEPS) / AP_LOOP_STEPS;
    static const double x[] = {0.5, 0.5, -0.5, -0.5, 0.5}, z[] = {0.5, -0.5, -0.5, 0.5, 0.5};
    int next = side < 4 ? side + 1 : 4;
    return (struct ap_vec3){a * (x[side] + part * (x[next] - x[side])), height_m + 0.8,
                            edge_m / 2 + 0.3 + a * (z[side] + part * (z[next] - z[side]))};
}

// Where the base point goes, seen from the base point.
static struct ap_vec3 place_of(struct ap_space space, struct ap_iso m) {
    struct ap_vec4 at = ap_iso_apply(&m, (struct ap_vec4){0, 0, 0, space.rho_m});
    return ap_log_unchecked(space, at, 0);
}

// The angle of the rotation in m = translate(v)·rotate(q).
static double turn_of(struct ap_space space, struct ap_iso m) {
    struct ap_vec3 v = place_of(space, m);
    struct ap_iso r = ap_iso_mul(ap_iso_translate(space, ap_vec3_scale(-1, v)), m);
    double s = hypot(hypot(r.m[2][1] - r.m[1][2], r.m[0][2] - r.m[2][0]), r.m[1][0] - r.m[0][1]);
    return atan2(s, r.m[0][0] + r.m[1][1] + r.m[2][2] - 1);
}

static double difference(struct ap_iso a, struct ap_iso b) {
    double most = 0;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            most = fmax(most, fabs(a.m[i][j] - b.m[i][j]));
    return most;
}

static struct ap_iso loop_holonomy(struct ap_space space) {
    const double a = AP_LOOP_SIDE_M;
    const struct ap_vec3 way[] = {{0, 0, -a}, {-a, 0, 0}, {0, 0, a}, {a, 0, 0}};
    struct ap_iso h = AP_ISO_IDENTITY;
    for (int i = 0; i < 4; i++)
        h = ap_iso_mul(h, ap_iso_translate(space, way[i]));
    return h;
}

// One step of both devices; the head first.
static enum ap_status loop_feed(struct ap_error *err, struct ap_tracker *tracker,
                                struct ap_space space, const struct ap_pose pose[2],
                                struct ap_iso *d) {
    struct ap_iso world[2];
    for (int i = 0; i < 2; i++) {
        bool row = false;
        enum ap_status st =
            ap_tracker_feed(err, tracker, i ? "right" : "head", pose[i], &row, &world[i]);
        if (st)
            return st;
        if (!row)
            return ap_fail(err, AP_ENVIRONMENT, "the tracker gave no pose");
    }
    *d = ap_iso_mul(ap_iso_inverse(space, world[0]), world[1]);
    return AP_OK;
}

enum ap_status ap_coherence_walk(struct ap_error *err, struct ap_space space,
                                 enum ap_tracker_kind kind, struct ap_coherence *out) {
    const double height_m = 0.75;
    double edge_m = space.kappa ? ap_table_edge_of_radius(space) : 0.9;
    struct ap_tracker_params params = {
        .kind = kind, .space = space, .table_height_m = height_m, .table_edge_m = edge_m};
    struct ap_tracker *tracker = NULL;
    enum ap_status st = ap_tracker_create(err, &params, &tracker);
    if (st)
        return st;
    struct ap_coherence made = {.kind = kind, .space = space};
    struct ap_iso first = AP_ISO_IDENTITY, last = AP_ISO_IDENTITY, m0_inverse = AP_ISO_IDENTITY;
    struct ap_vec3 e0 = {0, 0, 0};
    struct ap_pose pose[2] = {
        AP_POSE_IDENTITY,
        {{AP_LOOP_SIDE_M / 2 + 0.15, height_m + 0.3, edge_m / 2 + 0.1}, AP_QUAT_IDENTITY}};
    for (int k = 0; k <= AP_LOOP_STEPS; k++) {
        pose[0].p = loop_place(edge_m, height_m, k);
        st = loop_feed(err, tracker, space, pose, &last);
        if (st)
            goto out;
        struct ap_pose arm = ap_pose_mul(ap_pose_inverse(pose[0]), pose[1]);
        struct ap_iso felt = ap_iso_from_pose(space, arm);
        struct ap_vec3 e = ap_vec3_sub(place_of(space, last), arm.p);
        struct ap_iso m = ap_iso_mul(last, ap_iso_inverse(space, felt));
        if (k == 0) {
            first = last;
            e0 = e;
            m0_inverse = ap_iso_inverse(space, m);
        }
        made.offset_mm[k] = 1000 * ap_vec3_length(ap_vec3_sub(e, e0));
        made.turn_deg[k] = turn_of(space, ap_iso_mul(m, m0_inverse)) * 180 / M_PI;
    }
    struct ap_iso expected =
        kind == AP_TRACKER_NAIVE ? ap_iso_inverse(space, loop_holonomy(space)) : AP_ISO_IDENTITY;
    made.defect = difference(ap_iso_mul(last, ap_iso_inverse(space, first)), expected);
    if (made.defect < 1e-6)
        *out = made;
    else
        st = ap_fail(err, AP_INPUT, "the room is too many radii of %g m large for doubles",
                     space.rho_m);
out:
    ap_tracker_destroy(tracker);
    return st;
}

static const char *const TRACKER_COLORS[] = {"#e06c75", "#5bc0be", "#f0b45b"};

static void coherence_chart(FILE *f, const struct ap_coherence *walks, double left, bool turn) {
    double x[AP_LOOP_STEPS + 1], most = 0;
    for (int t = 0; t < 3; t++)
        for (int k = 0; k <= AP_LOOP_STEPS; k++) {
            x[k] = 4 * AP_LOOP_SIDE_M * k / AP_LOOP_STEPS;
            most = fmax(most, turn ? walks[t].turn_deg[k] : walks[t].offset_mm[k]);
        }
    struct chart c = {.f = f,
                      .left = left,
                      .top = 40,
                      .width = 460,
                      .height = 220,
                      .x1 = 4 * AP_LOOP_SIDE_M,
                      .y1 = most > 1e-6 ? 1.15 * most : 1};
    c.y0 = -0.03 * c.y1;
    chart_begin(&c, turn ? "turn of the seen hand (degrees)" : "offset of the seen hand (mm)",
                "way of the head round the square (m)");
    for (int t = 0; t < 3; t++)
        chart_line(&c, x, turn ? walks[t].turn_deg : walks[t].offset_mm, AP_LOOP_STEPS + 1,
                   TRACKER_COLORS[t], t == 1 ? "stroke-dasharray=\"6 5\"" : "");
    chart_end(&c);
}

static double largest(const double *v) {
    double most = 0;
    for (int k = 0; k <= AP_LOOP_STEPS; k++)
        most = fmax(most, v[k]);
    return most;
}

static void coherence_table(FILE *f, const struct ap_coherence *walks) {
    static const char *const words[] = {"each device goes its own way", "hands hang on the head",
                                        "head and hands hang on the table's edge"};
    fputs("<table><thead><tr><th>tracker</th><th class=\"l\">how</th><th>on the way, at "
          "most</th><th>after the round</th><th>off the exact value</th></tr></thead><tbody>\n",
          f);
    for (int t = 0; t < 3; t++) {
        const struct ap_coherence *w = &walks[t];
        fprintf(f,
                "<tr><td><span class=\"dot\" style=\"background:%s\"></span>%s</td>"
                "<td class=\"l\">%s</td><td>%.1f mm, %.1f°</td><td>%.1f mm, %.1f°</td>"
                "<td>%.0e</td></tr>\n",
                TRACKER_COLORS[t], ap_tracker_kind_name(w->kind), words[t], largest(w->offset_mm),
                largest(w->turn_deg), w->offset_mm[AP_LOOP_STEPS], w->turn_deg[AP_LOOP_STEPS],
                w->defect);
    }
    fputs("</tbody></table>\n", f);
}

enum ap_status ap_svg_coherence(struct ap_error *err, FILE *f, struct ap_space space) {
    struct ap_coherence *walks = calloc(3, sizeof *walks);
    enum ap_status st = walks ? AP_OK : ap_fail(err, AP_ENVIRONMENT, "out of memory");
    static const enum ap_tracker_kind kinds[] = {AP_TRACKER_NAIVE, AP_TRACKER_ANCHOR,
                                                 AP_TRACKER_BILLIARDS};
    for (int t = 0; t < 3 && !st; t++)
        st = ap_coherence_walk(err, space, kinds[t], &walks[t]);
    if (st == AP_INPUT) {
        fprintf(f,
                "<p>Not for a radius of %g m: beside it the loop is too large for doubles.</p>\n",
                space.rho_m);
        st = AP_OK;
    } else if (!st) {
        svg_begin(f, 1060, 310, "how far the seen hand leaves the felt one");
        coherence_chart(f, walks, 56, false);
        coherence_chart(f, walks, 590, true);
        fputs("</svg>\n", f);
        coherence_table(f, walks);
    }
    free(walks);
    return st;
}
