#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/app/gnuplot.h"
#include "src/app/vergence.h"
#include "src/base/file.h"
#include "src/base/log.h"
#include "src/base/number.h"

static const char HEADER[] = "frame,target,true_m,exact_arcmin,measured_arcmin,error_px,inferred_m";

static enum ap_status no_memory(struct ap_error *err) {
    return ap_fail(err, AP_ENVIRONMENT, "out of memory");
}

static char *file_path(const struct ap_capture *c, const char *name) {
    return ap_path_join(c->dir, name);
}

// --- vergence.csv

// Quoted where it must be (RFC 4180).
static void write_name(FILE *f, const char *name) {
    if (!strpbrk(name, ",\"\r\n")) {
        fputs(name, f);
        return;
    }
    fputc('"', f);
    for (; *name; name++) {
        if (*name == '"')
            fputc('"', f);
        fputc(*name, f);
    }
    fputc('"', f);
}

// NAN is an empty field.
static void write_number(FILE *f, double v) {
    char text[AP_DOUBLE_TEXT_MAX];
    fputc(',', f);
    if (isnan(v))
        return;
    ap_format_double(text, v);
    fputs(text, f);
}

static enum ap_status write_csv(struct ap_error *err, const char *path, const struct ap_capture *c,
                                const struct ap_vergence_row *rows, size_t count) {
    struct ap_outfile file;
    enum ap_status st = ap_outfile_open(err, path, &file);
    if (st)
        return st;
    fprintf(file.stream, "%s\n", HEADER);
    for (size_t i = 0; i < count; i++) {
        const struct ap_vergence_row *r = &rows[i];
        fprintf(file.stream, "%" PRId64 ",", r->frame);
        write_name(file.stream, c->targets[r->target].name);
        write_number(file.stream, r->true_m);
        write_number(file.stream, r->exact_arcmin);
        write_number(file.stream, r->measured_arcmin);
        write_number(file.stream, r->error_px);
        write_number(file.stream, r->inferred_m);
        fputc('\n', file.stream);
    }
    return ap_outfile_commit(err, &file);
}

// Cuts one field off *at: quoted or plain, unescaped in place. NULL where there is none.
static char *next_field(char **at) {
    char *from = *at, *to = *at, *field = *at;
    if (!from)
        return NULL;
    if (*from == '"') {
        for (from++; *from && !(from[0] == '"' && from[1] != '"'); from++) {
            if (*from == '"')
                from++;
            *to++ = *from;
        }
        if (*from != '"')
            return NULL;
        from++;
    } else {
        from += strcspn(from, ",");
        to = from;
    }
    if (*from != ',' && *from != '\0')
        return NULL;
    *at = *from == ',' ? from + 1 : NULL;
    *to = '\0';
    return field;
}

static bool read_number(const char *text, double *v) {
    if (text[0] == '\0')
        *v = NAN;
    else if (strcmp(text, "inf") == 0)
        *v = INFINITY;
    else
        return ap_parse_double(text, strlen(text), v);
    return true;
}

static int target_index(const struct ap_capture *c, const char *name) {
    for (size_t i = 0; i < c->target_count; i++)
        if (strcmp(c->targets[i].name, name) == 0)
            return (int)i;
    return -1;
}

static bool read_row(const struct ap_capture *c, char *line, struct ap_vergence_row *row) {
    char *at = line, *frame = next_field(&at), *name = at ? next_field(&at) : NULL;
    struct ap_vergence_row r = {0};
    double *numbers[] = {&r.true_m, &r.exact_arcmin, &r.measured_arcmin, &r.error_px,
                         &r.inferred_m};
    if (!frame || !name || !ap_parse_int64(frame, strlen(frame), &r.frame))
        return false;
    r.target = target_index(c, name);
    for (int i = 0; i < 5; i++) {
        char *field = next_field(&at);
        if (!field || !read_number(field, numbers[i]))
            return false;
    }
    r.image = c->space.kappa > 0 && r.true_m > M_PI * c->space.rho_m;
    *row = r;
    return at == NULL && r.target >= 0;
}

static enum ap_status read_csv(struct ap_error *err, const char *path, char *text,
                               const struct ap_capture *c, struct ap_vergence_row **rows,
                               size_t *count) {
    size_t lines = 1, n = 0, line = 0;
    for (const char *p = text; *p; p++)
        lines += *p == '\n';
    struct ap_vergence_row *all = calloc(lines, sizeof *all);
    if (!all)
        return no_memory(err);
    for (char *at = text; at && *at;) {
        char *end = strchr(at, '\n');
        if (end)
            *end++ = '\0';
        line++;
        bool good = line == 1 ? strcmp(at, HEADER) == 0 : read_row(c, at, &all[n++]);
        if (!good) {
            free(all);
            return ap_fail(err, AP_INPUT, "%s:%zu: expected %s", path, line,
                           line == 1 ? HEADER
                                     : "a row of it, for a target of this capture; run `antipode "
                                       "vergence` again");
        }
        at = end;
    }
    *rows = all;
    *count = n;
    return AP_OK;
}

enum ap_status ap_vergence_read(struct ap_error *err, const struct ap_capture *capture,
                                struct ap_vergence_row **rows, size_t *count) {
    char *text = NULL, *path = file_path(capture, "vergence.csv");
    size_t len;
    enum ap_status st = AP_OK;
    if (!path)
        return no_memory(err);
    if (ap_file_exists(path)) {
        st = ap_file_read(err, path, (size_t)1 << 30, &text, &len);
        if (!st)
            st = read_csv(err, path, text, capture, rows, count);
    } else {
        *rows = NULL;
        *count = 0;
    }
    free(text);
    free(path);
    return st;
}

// --- vergence.png

// gnuplot reads the whole script from its standard input and writes the picture to its standard
// output: no name of ours reaches it but the targets', and these lose whatever gnuplot could read
// as more than a letter.
static void plot_name(FILE *f, const char *name) {
    for (; *name; name++) {
        bool plain = strchr("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789 .-+",
                            *name) != NULL;
        fputc(plain ? *name : '_', f);
    }
}

static double farthest(const struct ap_vergence_row *rows, size_t count) {
    double most = 0;
    for (size_t i = 0; i < count; i++)
        if (!isnan(rows[i].measured_arcmin))
            most = fmax(most, rows[i].true_m);
    return most > 0 ? most : 1;
}

enum { CURVE_POINTS = 240 };

static void plot_curves(FILE *f, const struct ap_capture *c, double least_m, double most_m) {
    fprintf(f, "$curves << EOD\n");
    for (int i = 0; i <= CURVE_POINTS; i++) {
        double d = least_m + (most_m - least_m) * i / CURVE_POINTS, v[4] = {0, 0, 0, NAN};
        struct ap_space flat = {0, 1};
        double ipd = c->headset.ipd_m;
        if (ap_vergence_ahead(NULL, c->space, AP_VIEW_NATIVE, ipd, d, &v[0]) ||
            ap_vergence_ahead(NULL, c->space, AP_VIEW_TOURIST, ipd, d, &v[1]) ||
            ap_vergence_ahead(NULL, flat, AP_VIEW_NATIVE, ipd, d, &v[2]))
            continue;
        // Somebody born elsewhere is a tourist of her own space, at the same distance.
        if (c->view == AP_VIEW_BORN)
            ap_vergence_ahead(NULL, c->born, AP_VIEW_TOURIST, ipd, d, &v[3]);
        fprintf(f, "%.6g", d);
        for (int k = 0; k < 4; k++)
            fprintf(f, " %.9g", v[k] * 180 * 60 / M_PI);
        fprintf(f, "\n");
    }
    fprintf(f, "EOD\n");
}

static void plot_data(FILE *f, const struct ap_capture *c, const struct ap_vergence_row *rows,
                      size_t count) {
    for (size_t t = 0; t < c->target_count; t++) {
        fprintf(f, "$t%zu << EOD\n", t);
        // A line that no axis shows, so that a block is never empty.
        fprintf(f, "NaN NaN NaN NaN\n");
        for (size_t i = 0; i < count; i++) {
            const struct ap_vergence_row *r = &rows[i];
            if (r->target != (int)t || isnan(r->measured_arcmin))
                continue;
            fprintf(f, "%.9g %.9g %.9g ", r->true_m, r->exact_arcmin, r->measured_arcmin);
            if (isfinite(r->inferred_m))
                fprintf(f, "%.9g\n", r->inferred_m);
            else
                fprintf(f, "NaN\n");
        }
        fprintf(f, "EOD\n");
    }
}

static void plot_points(FILE *f, const struct ap_capture *c, int column) {
    for (size_t t = 0; t < c->target_count; t++) {
        const struct ap_capture_target *target = &c->targets[t];
        fprintf(f,
                ", \\\n $t%zu using 1:%d with points pt 7 ps 0.8 lc rgb \"#%02x%02x%02x\" title \"",
                t, column, target->color[0], target->color[1], target->color[2]);
        plot_name(f, target->name);
        fprintf(f, "\"");
    }
}

static void write_script(FILE *f, const struct ap_capture *c, const struct ap_vergence_row *rows,
                         size_t count) {
    double most = 1.05 * farthest(rows, count), least = fmin(0.1, most / 20);
    fprintf(f, "set terminal pngcairo size 1400,620 noenhanced font \"DejaVu Sans,11\" "
               "background rgb \"#14171c\"\nset encoding utf8\n");
    plot_curves(f, c, least, most);
    plot_data(f, c, rows, count);
    fprintf(
        f,
        "set border lc rgb \"#8a93a0\"\nset tics textcolor rgb \"#c8ced6\"\n"
        "set grid lc rgb \"#2b313a\"\nset key bottom left Left reverse textcolor rgb \"#c8ced6\"\n"
        "set xlabel \"true distance (m)\" textcolor rgb \"#c8ced6\"\n"
        "set multiplot layout 1,2 title \"Vergence, %s, radius %.4g m, %s view\" "
        "textcolor rgb \"#e8eaee\"\nset xrange [0:%.6g]\n",
        ap_space_name(c->space), c->space.rho_m, ap_view_mode_name(c->view), most);
    // From the nearest target on; the curves go to infinity at the nose.
    double top = 0, bottom = 0;
    for (size_t i = 0; i < count; i++)
        if (!isnan(rows[i].measured_arcmin)) {
            top = fmax(top, rows[i].measured_arcmin);
            bottom = fmin(bottom, rows[i].measured_arcmin);
        }
    top = top > 0 ? 1.3 * top : 600;
    fprintf(f,
            "set yrange [%.6g:%.6g]\nset ylabel \"vergence (arc minutes)\" textcolor rgb "
            "\"#c8ced6\"\n",
            1.3 * bottom, top);
    fprintf(f, "plot $curves using 1:2 with lines lw 2 lc rgb \"#f0b45b\" title \"native\", \\\n"
               " $curves using 1:3 with lines lw 2 lc rgb \"#5bc0be\" title \"tourist\", \\\n"
               " $curves using 1:4 with lines lw 1 dt 2 lc rgb \"#8a93a0\" title \"flat\"");
    if (c->view == AP_VIEW_BORN)
        fprintf(
            f, ", \\\n $curves using 1:5 with lines lw 2 lc rgb \"#b892ff\" title \"native of %s\"",
            ap_space_name(c->born));
    plot_points(f, c, 3);
    fprintf(
        f,
        "\nset yrange [0:%.6g]\nset key top left Left reverse\nset ylabel \"inferred distance (m)\" "
        "textcolor rgb \"#c8ced6\"\n"
        "plot x with lines lw 1 dt 2 lc rgb \"#8a93a0\" title \"equal to the true one\"",
        2 * most);
    plot_points(f, c, 4);
    fprintf(f, "\nunset multiplot\n");
}

static enum ap_status write_plot(struct ap_error *err, const char *path, const struct ap_capture *c,
                                 const struct ap_vergence_row *rows, size_t count) {
    FILE *script = tmpfile();
    if (!script)
        return ap_fail(err, AP_ENVIRONMENT, "a temporary file cannot be made: %s", strerror(errno));
    write_script(script, c, rows, count);
    enum ap_status st = ap_gnuplot(err, script, path);
    fclose(script);
    return st;
}

enum ap_status ap_vergence_write(struct ap_error *err, const struct ap_capture *capture,
                                 const struct ap_vergence_row *rows, size_t count) {
    char *csv = file_path(capture, "vergence.csv"), *plot = file_path(capture, "vergence.png");
    enum ap_status st = csv && plot ? AP_OK : no_memory(err);
    if (!st)
        st = write_csv(err, csv, capture, rows, count);
    if (!st)
        st = write_plot(err, plot, capture, rows, count);
    free(csv);
    free(plot);
    return st;
}
