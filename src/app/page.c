#include "src/app/page.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/app/html.h"
#include "src/app/plots.h"
#include "src/base/file.h"

// Of the whole page about 6 MB; the rest is text and drawings.
static const struct ap_html_viewer VIEWER = {.width_px = 480, .budget = 5000000};

static void write_header(FILE *f, const struct ap_capture *c) {
    fprintf(f,
            "<header><h1>A walk in %s</h1>\n<p class=\"sub\"><span>%s, radius %.4g m</span>"
            "<span>%s view</span><span>tracker ",
            ap_html_space_title(c->space), ap_space_name(c->space), c->space.rho_m,
            ap_view_mode_name(c->view));
    ap_html_text(f, c->tracker);
    fprintf(f, "</span><span>%zu of %" PRId64 " frames captured</span></p>\n", c->frame_count,
            c->total_frames);
    if (c->interrupted)
        fputs("<p class=\"banner\">This run was interrupted: what follows is only as far as it "
              "came.</p>\n",
              f);
    fputs("</header>\n", f);
}

static void write_tracker_text(FILE *f, const struct ap_capture *c) {
    if (strcmp(c->tracker, "billiards") == 0)
        fprintf(f,
                "<p>Whoever walks here walks round a real table of %.2f m by %.2f m. Head and "
                "hands hang on the edge of it that is nearest, and that edge of the real table "
                "is an edge of the virtual one: a hand laid on the wood is seen on the "
                "wood.</p>\n",
                c->table_edge_m, c->table_edge_m);
    else if (strcmp(c->tracker, "anchor") == 0)
        fputs("<p>The head moves through the curved world step by step, and the hands hang on the "
              "head: they are always seen where they are felt, while the world as a whole slips "
              "away from the room.</p>\n",
              f);
    else
        fputs("<p>Head and hands each move through the curved world on their own. After a walk "
              "they no longer agree: the hands are not seen where they are felt.</p>\n",
              f);
}

static void write_walk(FILE *f, const struct ap_capture *c) {
    fputs("<h2>The walk from above</h2>\n<div class=\"card\">\n", f);
    ap_svg_walk(f, c);
    fputs("<p class=\"note\">Amber: the head, with a needle where its nose pointed when a picture "
          "was taken; ",
          f);
    bool any = false;
    for (int i = 0; i < c->device_count; i++) {
        if (strcmp(c->devices[i], "head") == 0)
            continue;
        fputs(any ? ", " : "the thin lines: ", f);
        ap_html_text(f, c->devices[i]);
        any = true;
    }
    fputs(any ? ". " : "no hands. ", f);
    fputs("On the right, distances and directions from the middle of the table are true; other "
          "straight lines, as the table's edges are, look bent on flat paper.</p>\n</div>\n",
          f);
}

static enum ap_status write_coherence(struct ap_error *err, FILE *f, struct ap_space space) {
    fprintf(f,
            "<h2>Hands where you feel them</h2>\n<p>In a curved space a walk round a loop turns "
            "you, though you never turned. Here a head goes once round a square of %.1f m, "
            "forward, left, back, right, while a hand rests; the charts show how far the hand "
            "that is seen leaves the hand that is felt. With the naive tracker the error stays "
            "and adds up with every round. The anchor keeps the hands on the head all the way; "
            "the table parts them a little where the head is far from its edge, but closes the "
            "round exactly.</p>\n"
            "<div class=\"card\">\n",
            AP_LOOP_SIDE_M);
    enum ap_status st = ap_svg_coherence(err, f, space);
    fputs("</div>\n", f);
    return st;
}

// --- vergence

static void write_dot(FILE *f, const struct ap_capture_target *t) {
    fprintf(f, "<span class=\"dot\" style=\"background:#%02x%02x%02x\"></span>", t->color[0],
            t->color[1], t->color[2]);
    ap_html_text(f, t->name);
}

static void write_summaries(FILE *f, const struct ap_capture *c, const struct ap_vergence_row *rows,
                            size_t count) {
    fputs("<div class=\"scroll\"><table><thead><tr><th>target</th><th>true distance</th>"
          "<th>exact vergence</th><th>measured in</th><th>worst error</th></tr></thead><tbody>\n",
          f);
    for (size_t t = 0; t < c->target_count; t++) {
        struct ap_vergence_summary s = ap_vergence_summarize(rows, count, (int)t);
        if (s.frames == 0)
            continue;
        fputs("<tr><td>", f);
        write_dot(f, &c->targets[t]);
        fprintf(f, "</td><td>%.3f … %.3f m</td>", s.least_m, s.most_m);
        if (s.measured)
            fprintf(f, "<td>%.1f′ … %.1f′</td>", s.least_arcmin, s.most_arcmin);
        else
            fputs("<td>–</td>", f);
        fprintf(f, "<td>%zu of %zu frames</td>", s.measured, s.frames);
        if (s.measured)
            fprintf(f, "<td>%.3f px</td></tr>\n", s.worst_px);
        else
            fputs("<td>–</td></tr>\n", f);
    }
    fputs("</tbody></table></div>\n", f);
}

static void write_cell(FILE *f, double v, const char *format) {
    fputs("<td>", f);
    if (isnan(v))
        fputs("–", f);
    else if (isinf(v))
        fputs("∞", f);
    else
        fprintf(f, strcmp(format, "px") == 0 ? "%+.3f" : "%.3f", v);
    fputs("</td>", f);
}

static void write_rows(FILE *f, const struct ap_capture *c, const struct ap_vergence_row *rows,
                       size_t count) {
    enum { ROWS_MAX = 1500 };
    fputs("<details><summary>every measurement</summary><div class=\"scroll\"><table><thead><tr>"
          "<th>target</th><th>frame</th><th>true distance (m)</th><th>exact (′)</th>"
          "<th>measured (′)</th><th>error (px)</th><th>inferred distance (m)</th></tr></thead>"
          "<tbody>\n",
          f);
    for (size_t i = 0; i < count && i < ROWS_MAX; i++) {
        const struct ap_vergence_row *r = &rows[i];
        fputs("<tr><td>", f);
        write_dot(f, &c->targets[r->target]);
        if (r->image == 1)
            fputs(" (the long way round)", f);
        fprintf(f, "</td><td>%" PRId64 "</td>", r->frame);
        write_cell(f, r->true_m, "m");
        write_cell(f, r->exact_arcmin, "arcmin");
        write_cell(f, r->measured_arcmin, "arcmin");
        write_cell(f, r->error_px, "px");
        write_cell(f, r->inferred_m, "m");
        fputs("</tr>\n", f);
    }
    fputs("</tbody></table></div>\n", f);
    if (count > ROWS_MAX)
        fprintf(f, "<p class=\"note\">The first %d of %zu; all of them are in vergence.csv.</p>\n",
                ROWS_MAX, count);
    fputs("</details>\n", f);
}

static void write_vergence(FILE *f, const struct ap_capture *c, const struct ap_vergence_row *rows,
                           size_t count) {
    if (c->target_count == 0 || count == 0)
        return;
    const struct ap_measured set = {c, rows, count};
    fputs("<h2>What the two eyes make of it</h2>\n<p>Two eyes tell distance by the angle between "
          "their lines of sight, the vergence. Each coloured ball below was looked up in both "
          "eyes’ pictures, and the angle found there compared with the exact one; from the same "
          "two lines comes the distance that the eyes infer.</p>\n<div class=\"card\">\n",
          f);
    ap_svg_vergence(f, &set, 1);
    fputs("</div>\n", f);
    write_summaries(f, c, rows, count);
    write_rows(f, c, rows, count);
}

// --- settings

static void write_command(FILE *f, const struct ap_capture *c) {
    fputs("<pre>", f);
    if (c->command[0]) {
        ap_html_text(f, c->command);
    } else {
        fprintf(f, "antipode replay --space %s --radius %.17g --view %s --tracker ",
                ap_space_name(c->space), c->space.rho_m, ap_view_mode_name(c->view));
        ap_html_text(f, c->tracker);
        fputs(" --out DIR ", f);
        ap_html_text(f, c->log_name);
    }
    fputs("</pre>\n", f);
}

static void write_settings(FILE *f, const struct ap_capture *c) {
    const struct ap_eye_profile *eye = c->headset.eye;
    fputs("<h2>How it was made</h2>\n<div class=\"card\"><dl>\n<dt>log</dt><dd>", f);
    ap_html_text(f, c->log_name);
    fprintf(f,
            "</dd>\n<dt>space</dt><dd>%s, radius %.9g m</dd>\n<dt>view</dt><dd>%s</dd>\n"
            "<dt>tracker</dt><dd>",
            ap_space_name(c->space), c->space.rho_m, ap_view_mode_name(c->view));
    ap_html_text(f, c->tracker);
    if (c->has_table)
        fprintf(f, "</dd>\n<dt>table</dt><dd>edge %.4g m, height %.4g m", c->table_edge_m,
                c->table_height_m);
    fputs("</dd>\n<dt>headset</dt><dd>", f);
    ap_html_text(f, c->headset.name);
    fprintf(f,
            ": %u × %u and %u × %u pixels, %.4g Hz, eyes %.1f mm apart</dd>\n</dl></div>\n"
            "<p>To see it again:</p>\n",
            eye[0].width_px, eye[0].height_px, eye[1].width_px, eye[1].height_px,
            c->headset.refresh_hz, 1000 * c->headset.ipd_m);
    write_command(f, c);
    fputs("<p>In this folder: NNNNNN-left.png, -right.png, -sbs.png and -anaglyph.png by frame "
          "number; contact.png; frames.csv, views.csv, timing.csv and vergence.csv.</p>\n",
          f);
}

static enum ap_status write_page(struct ap_error *err, FILE *f, const struct ap_capture *c,
                                 const struct ap_vergence_row *rows, size_t count) {
    char title[96];
    snprintf(title, sizeof title, "A walk in %s", ap_html_space_title(c->space));
    ap_html_begin(f, title);
    write_header(f, c);
    ap_html_controls(f);
    fputs("<div class=\"solo\">\n", f);
    enum ap_status st = ap_html_viewer_write(err, f, c, &VIEWER);
    if (st)
        return st;
    fputs("</div>\n<h2>What you see</h2>\n", f);
    ap_html_space_text(f, c->space);
    ap_html_view_text(f, c->space, c->view, c->headset.ipd_m);
    write_tracker_text(f, c);
    write_walk(f, c);
    if (c->space.kappa != 0)
        st = write_coherence(err, f, c->space);
    write_vergence(f, c, rows, count);
    fputs("<h2>The pictures</h2>\n<div class=\"thumbs\"></div>\n", f);
    write_settings(f, c);
    ap_html_end(f);
    return st;
}

enum ap_status ap_page_write(struct ap_error *err, const struct ap_capture *capture,
                             const struct ap_vergence_row *rows, size_t count) {
    char *path = ap_path_join(capture->dir, "index.html");
    if (!path)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    struct ap_outfile file = {0};
    enum ap_status st = ap_outfile_open(err, path, &file);
    free(path);
    if (st)
        return st;
    st = write_page(err, file.stream, capture, rows, count);
    if (st) {
        ap_outfile_abort(&file);
        return st;
    }
    return ap_outfile_commit(err, &file);
}
