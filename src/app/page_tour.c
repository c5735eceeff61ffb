#include <inttypes.h>
#include <stdlib.h>

#include "src/app/html.h"
#include "src/app/page.h"
#include "src/app/plots.h"
#include "src/base/file.h"

// What all the viewers of the page may take together.
static const size_t PICTURES_BUDGET = 7500000;

static void write_spaces(FILE *f, const struct ap_capture *captures, size_t count) {
    for (size_t i = 0; i < count; i++) {
        const struct ap_capture *c = &captures[i];
        bool told = false;
        for (size_t k = 0; k < i; k++)
            told = told || captures[k].space.kappa == c->space.kappa;
        if (!told) {
            fprintf(f, "<h3>In %s</h3>\n", ap_html_space_title(c->space));
            ap_html_space_text(f, c->space);
        }
    }
}

static enum ap_status write_viewers(struct ap_error *err, FILE *f,
                                    const struct ap_capture *captures, size_t count) {
    const struct ap_html_viewer viewer = {.width_px = 400, .budget = PICTURES_BUDGET / count};
    fputs("<div class=\"row\">\n", f);
    for (size_t i = 0; i < count; i++) {
        const struct ap_capture *c = &captures[i];
        fprintf(f,
                "<div><h3>%s</h3><p class=\"sub\"><span>%s, radius %.3g m</span>"
                "<span>%s view</span><span>",
                ap_html_space_title(c->space), ap_space_name(c->space), c->space.rho_m,
                ap_view_mode_name(c->view));
        ap_html_text(f, c->tracker);
        fprintf(f, "</span>%s</p>\n", c->interrupted ? "<span>interrupted</span>" : "");
        enum ap_status st = ap_html_viewer_write(err, f, c, &viewer);
        if (st)
            return st;
        fputs("</div>\n", f);
    }
    fputs("</div>\n", f);
    ap_html_controls(f);
    return AP_OK;
}

static void write_walks(FILE *f, const struct ap_capture *captures, size_t count) {
    fputs("<h2>One walk, seen from above</h2>\n<p>On the left the room, on the right the world. "
          "Both tables have the same edges and the same square corners; only the number of corners "
          "differs.</p>\n",
          f);
    for (size_t i = 0; i < count; i++) {
        fprintf(f, "<div class=\"card\"><h3>%s</h3>\n", ap_html_space_title(captures[i].space));
        ap_svg_walk(f, &captures[i]);
        fputs("</div>\n", f);
    }
}

static enum ap_status write_trackers(struct ap_error *err, FILE *f,
                                     const struct ap_capture *captures, size_t count) {
    fprintf(f,
            "<h2>Three ways to carry a body into a curved world</h2>\n<p>A head goes once round "
            "a square of %.1f m, forward, left, back, right, and never turns; a hand rests. In "
            "a curved space the loop does not close: whoever walks it comes out turned. The "
            "charts show how far the hand that is seen leaves the hand that is felt. If each "
            "device finds its own way (naive), the error stays, and every round adds to it. "
            "Hang the hands on the head (anchor) and they never part, but the room and the "
            "world do. Hang both on the edge of a real table (billiards): a head high above "
            "the edge is carried a little too far, so that on the way hand and head part, but "
            "the round closes exactly, and the table is always where it is felt.</p>\n",
            AP_LOOP_SIDE_M);
    for (size_t i = 0; i < count; i++) {
        bool told = captures[i].space.kappa == 0;
        for (size_t k = 0; k < i; k++)
            told = told || (captures[k].space.kappa == captures[i].space.kappa &&
                            captures[k].space.rho_m == captures[i].space.rho_m);
        if (told)
            continue;
        fprintf(f, "<div class=\"card\"><h3>%s, radius %.3g m</h3>\n",
                ap_html_space_title(captures[i].space), captures[i].space.rho_m);
        enum ap_status st = ap_svg_coherence(err, f, captures[i].space);
        if (st)
            return st;
        fputs("</div>\n", f);
    }
    return AP_OK;
}

static enum ap_status write_vergence(struct ap_error *err, FILE *f,
                                     const struct ap_capture *captures, size_t count) {
    struct ap_measured *sets = calloc(count, sizeof *sets);
    struct ap_vergence_row **rows = calloc(count, sizeof(struct ap_vergence_row *));
    enum ap_status st = sets && rows ? AP_OK : ap_fail(err, AP_ENVIRONMENT, "out of memory");
    size_t n = 0, measured = 0;
    double worst = 0;
    for (; n < count && !st; n++) {
        sets[n].capture = &captures[n];
        st = ap_vergence_read(err, &captures[n], &rows[n], &sets[n].count);
        sets[n].rows = rows[n];
        for (size_t t = 0; t < captures[n].target_count && !st; t++) {
            struct ap_vergence_summary s =
                ap_vergence_summarize(sets[n].rows, sets[n].count, (int)t);
            measured += s.measured;
            worst = s.worst_px > worst ? s.worst_px : worst;
        }
    }
    if (!st && measured > 0) {
        fprintf(f,
                "<h2>What the two eyes make of it</h2>\n<p>The angle between the two lines of "
                "sight tells how far a thing is. In the native view (solid) it is the same in "
                "every space; in the tourist view (dashed) it misleads. The dots were measured "
                "in the pictures: %zu pairs, at worst %.3f pixels off the exact angle.</p>\n"
                "<div class=\"card\">\n",
                measured, worst);
        ap_svg_vergence(f, sets, count);
        fputs("</div>\n", f);
    }
    for (size_t i = 0; rows && i < count; i++)
        free(rows[i]);
    free(rows);
    free(sets);
    return st;
}

static enum ap_status write_tour(struct ap_error *err, FILE *f, const struct ap_capture *captures,
                                 size_t count) {
    ap_html_begin(f, "One walk, several worlds");
    fputs("<header><h1>One walk, several worlds</h1>\n<p class=\"sub\">The same steps in the same "
          "room, seen in spaces that are curved in different ways.</p></header>\n",
          f);
    enum ap_status st = write_viewers(err, f, captures, count);
    if (st)
        return st;
    fputs("<h2>What you see</h2>\n", f);
    write_spaces(f, captures, count);
    st = write_trackers(err, f, captures, count);
    if (!st) {
        write_walks(f, captures, count);
        st = write_vergence(err, f, captures, count);
    }
    ap_html_end(f);
    return st;
}

enum ap_status ap_tour_page_write(struct ap_error *err, const char *path,
                                  const struct ap_capture *captures, size_t count) {
    if (count == 0)
        return ap_fail(err, AP_USAGE, "a page needs at least one capture");
    struct ap_outfile file = {0};
    enum ap_status st = ap_outfile_open(err, path, &file);
    if (st)
        return st;
    st = write_tour(err, file.stream, captures, count);
    if (st) {
        ap_outfile_abort(&file);
        return st;
    }
    return ap_outfile_commit(err, &file);
}

static enum ap_status run_page(struct ap_error *err, int argc, char **argv) {
    const char *out = NULL;
    const struct ap_option options[] = {
        {"out", AP_OPTION_TEXT, &out, "FILE", "where the page is written (required)"}};
    const struct ap_usage usage = {
        .command = "page",
        .operands = "DIR…",
        .text = "Writes one page, a self-contained HTML file, over the captures in the folders DIR "
                "(made by `antipode replay --out DIR`), side by side, with the walks, the three "
                "trackers, and the measured vergence of folders that `antipode vergence DIR` has "
                "seen.\n\nExit status: 0; 2 usage; 3 a DIR holds no capture, or a broken one; 4 "
                "FILE cannot be written.",
        .options = options,
        .option_count = 1,
        .min_operands = 1,
        .max_operands = 16};
    int operands = 0;
    bool done = false;
    enum ap_status st = ap_parse_options(err, &usage, argc, argv, &operands, &done);
    if (st || done)
        return st;
    if (!out)
        return ap_fail(err, AP_USAGE, "--out FILE is missing (see antipode page --help)");
    struct ap_capture captures[16] = {{0}};
    for (int i = 0; i < operands && !st; i++)
        st = ap_capture_read(err, argv[1 + i], &captures[i]);
    if (!st)
        st = ap_tour_page_write(err, out, captures, (size_t)operands);
    for (int i = 0; i < operands; i++)
        ap_capture_finish(&captures[i]);
    return st;
}

const struct ap_command ap_command_page = {"page", "put several captures side by side on one page",
                                           run_page};
