#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "src/app/command.h"
#include "src/base/file.h"
#include "src/base/log.h"
#include "src/base/number.h"
#include "src/image/compare.h"

// antipode compare: two captures or two pictures.

struct limits {
    double min_psnr, min_ssim, max_flip, max_pixels, max_step; // NAN: not asked for
};

struct options {
    const char *metric, *out;
    struct limits limits;
    double ppd;
    bool quiet;
};

// What is known of a pair; numbers that were not asked for are NAN.
struct verdict {
    struct ap_difference d;
    double ssim, flip;
    bool passes;
};

struct run {
    const struct options *options;
    FILE *csv;
    size_t pairs, same, within, differ, missing, unreadable;
    double lowest_psnr;
};

static enum ap_status no_memory(struct ap_error *err) {
    return ap_fail(err, AP_ENVIRONMENT, "out of memory");
}

// ---- names: those of a folder's pictures, sorted

struct names {
    char **name;
    size_t count, room;
};

static void names_finish(struct names *names) {
    for (size_t k = 0; k < names->count; k++)
        free(names->name[k]);
    free(names->name);
    *names = (struct names){0};
}

static bool ends_in(const char *text, size_t n, const char *end) {
    size_t m = strlen(end);
    return n >= m && memcmp(text + n - m, end, m) == 0;
}

static bool is_picture(const char *name) {
    size_t n = strlen(name);
    return name[0] != '.' && n > 4 && (ends_in(name, n, ".png") || ends_in(name, n, ".pam"));
}

// NNNNNN-…: a capture's, and not made from others.
static bool is_frame(const char *name) {
    size_t digits = strspn(name, "0123456789"), n = strlen(name) - 4;
    return digits >= 6 && name[digits] == '-' && !ends_in(name, n, "-sbs") &&
           !ends_in(name, n, "-anaglyph") && !ends_in(name, n, "-diff");
}

static bool add_name(struct names *names, const char *name) {
    if (names->count == names->room) {
        size_t room = names->room ? 2 * names->room : 64;
        char **more = realloc(names->name, room * sizeof *more);
        if (!more)
            return false;
        names->name = more;
        names->room = room;
    }
    names->name[names->count] = strdup(name);
    return names->name[names->count] && ++names->count;
}

// Without its last four letters, which may differ between the two sides.
static int by_stem(const void *a, const void *b) {
    const char *p = *(char *const *)a, *q = *(char *const *)b;
    size_t n = strlen(p) - 4, m = strlen(q) - 4;
    int order = memcmp(p, q, n < m ? n : m);
    return order ? order : (n > m) - (n < m);
}

static int by_name(const void *a, const void *b) {
    int order = by_stem(a, b);
    return order ? order : strcmp(*(char *const *)a, *(char *const *)b);
}

static enum ap_status list(struct ap_error *err, const char *dir, struct names *names) {
    DIR *d = opendir(dir);
    if (!d)
        return ap_fail(err, AP_INPUT, "%s: cannot be read: %s", dir, strerror(errno));
    enum ap_status st = AP_OK;
    for (struct dirent *e; !st && (e = readdir(d));)
        if (is_picture(e->d_name) && !add_name(names, e->d_name))
            st = no_memory(err);
    closedir(d);
    if (names->count)
        qsort(names->name, names->count, sizeof *names->name, by_name);
    return st;
}

static bool has_frames(const struct names *names) {
    for (size_t k = 0; k < names->count; k++)
        if (is_frame(names->name[k]))
            return true;
    return false;
}

static void keep_frames(struct names *names) {
    size_t kept = 0;
    for (size_t k = 0; k < names->count; k++)
        if (is_frame(names->name[k]))
            names->name[kept++] = names->name[k];
        else
            free(names->name[k]);
    names->count = kept;
}

// ---- one pair

static bool wants(const struct options *o, const char *metric, double limit) {
    return !isnan(limit) || strcmp(o->metric, metric) == 0 || strcmp(o->metric, "all") == 0;
}

static bool passes(const struct limits *l, const struct verdict *v) {
    bool asked = !isnan(l->min_psnr) || !isnan(l->min_ssim) || !isnan(l->max_flip) ||
                 !isnan(l->max_pixels) || !isnan(l->max_step);
    if (!asked)
        return v->d.pixels == 0;
    return !(v->d.psnr_db < l->min_psnr) && !(v->ssim < l->min_ssim) && !(v->flip > l->max_flip) &&
           !((double)v->d.pixels > l->max_pixels) && !(v->d.largest_step > l->max_step);
}

// DIR/NAME-diff.png of a picture's name or path.
static char *picture_path(const char *dir, const char *name) {
    const char *slash = strrchr(name, '/');
    const char *base = slash ? slash + 1 : name;
    size_t n = strlen(base), size = n + 16;
    if (n > 4 && base[n - 4] == '.')
        n -= 4;
    char *file = malloc(size);
    if (!file)
        return NULL;
    snprintf(file, size, "%.*s-diff.png", (int)n, base);
    char *path = ap_path_join(dir, file);
    free(file);
    return path;
}

static enum ap_status write_picture(struct ap_error *err, const char *dir, const char *name,
                                    const struct ap_image pair[2], const float *map) {
    struct ap_image made = {0};
    char *path = picture_path(dir, name);
    enum ap_status st = path ? AP_OK : no_memory(err);
    if (!st)
        st = ap_image_difference_picture(err, &pair[0], &pair[1], map, &made);
    if (!st)
        st = ap_png_write(err, path, &made);
    ap_image_finish(&made);
    free(path);
    return st;
}

static enum ap_status measure(struct ap_error *err, const struct options *o, const char *name,
                              const struct ap_image pair[2], struct verdict *v) {
    *v = (struct verdict){.ssim = NAN, .flip = NAN};
    float *map = NULL;
    enum ap_status st = ap_image_difference(err, &pair[0], &pair[1], &v->d);
    if (!st && wants(o, "ssim", o->limits.min_ssim))
        st = ap_image_ssim(err, &pair[0], &pair[1], &v->ssim);
    if (!st && wants(o, "flip", o->limits.max_flip)) {
        map = malloc((size_t)pair[0].width * pair[0].height * sizeof *map);
        if (v->d.pixels == 0)
            v->flip = 0;
        else
            st = map ? ap_image_flip(err, &pair[0], &pair[1], o->ppd, &v->flip, map)
                     : no_memory(err);
    }
    v->passes = passes(&o->limits, v);
    if (!st && o->out && v->d.pixels)
        st = write_picture(err, o->out, name, pair, map);
    free(map);
    return st;
}

// ---- telling

// A name as a CSV field, and a control character nowhere.
static void print_name(FILE *out, const char *name, bool csv) {
    bool quote = csv && strpbrk(name, ",\"\n\r");
    if (quote)
        putc('"', out);
    for (const char *c = name; *c; c++) {
        if (quote && *c == '"')
            putc('"', out);
        putc((unsigned char)*c < ' ' || *c == 0x7f ? '?' : *c, out);
    }
    if (quote)
        putc('"', out);
}

static void csv_number(FILE *csv, double v) {
    char text[AP_DOUBLE_TEXT_MAX] = "";
    if (!isnan(v))
        ap_format_double(text, v);
    fprintf(csv, ",%s", text);
}

static void tell_csv(FILE *csv, const char *name, const char *state, const struct verdict *v) {
    if (!csv)
        return;
    print_name(csv, name, true);
    fprintf(csv, ",%s", state);
    if (!v) {
        fputs(",,,,,,,,,,\n", csv);
        return;
    }
    const struct ap_difference *d = &v->d;
    csv_number(csv, d->psnr_db);
    csv_number(csv, v->ssim);
    csv_number(csv, v->flip);
    fprintf(csv, ",%llu,%d,%u,%u,%u,%u,%llu\n", (unsigned long long)d->pixels, d->largest_step,
            d->largest.x, d->largest.y, d->largest.width, d->largest.height,
            (unsigned long long)d->largest.pixels);
}

static void tell(const struct run *r, const char *name, const struct verdict *v) {
    const struct ap_difference *d = &v->d;
    const char *state = d->pixels == 0 ? "same" : v->passes ? "within" : "differs";
    tell_csv(r->csv, name, state, v);
    if (r->options->quiet && v->passes)
        return;
    print_name(stdout, name, false);
    printf(": %s", state);
    if (d->pixels) {
        printf(": PSNR %.3f dB", d->psnr_db);
        if (!isnan(v->ssim))
            printf(", SSIM %.6f", v->ssim);
        if (!isnan(v->flip))
            printf(", FLIP %.6f", v->flip);
        printf(", %llu pixels by up to %d, most of them together %llu in %ux%u at %u,%u",
               (unsigned long long)d->pixels, d->largest_step,
               (unsigned long long)d->largest.pixels, d->largest.width, d->largest.height,
               d->largest.x, d->largest.y);
    }
    putchar('\n');
}

// A difference that is not one of pixels.
static void tell_other(struct run *r, const char *name, const char *state, const char *why) {
    tell_csv(r->csv, name, state, NULL);
    print_name(stdout, name, false);
    printf(": %s\n", why);
}

static void count(struct run *r, const struct verdict *v) {
    if (v->d.pixels == 0)
        r->same++;
    else if (v->passes)
        r->within++;
    else
        r->differ++;
    r->lowest_psnr = v->d.psnr_db < r->lowest_psnr ? v->d.psnr_db : r->lowest_psnr;
}

// A picture that cannot be read is told and counted; what the machine lacks ends the command.
static enum ap_status compare_files(struct ap_error *err, struct run *r, const char *name,
                                    const char *const path[2]) {
    struct ap_image pair[2] = {{0}, {0}};
    struct ap_error why = {""};
    enum ap_status st = AP_OK;
    r->pairs++;
    for (int k = 0; k < 2 && !st; k++)
        st = ap_picture_read(&why, path[k], &pair[k]);
    if (st == AP_INPUT) {
        r->unreadable++;
        ap_log(AP_LOG_ERROR, "compare: %s", why.text);
        tell_csv(r->csv, name, "unreadable", NULL);
        st = AP_OK;
    } else if (!st && (pair[0].width != pair[1].width || pair[0].height != pair[1].height)) {
        char text[96];
        snprintf(text, sizeof text, "differs: %ux%u and %ux%u pixels", pair[0].width,
                 pair[0].height, pair[1].width, pair[1].height);
        r->differ++;
        tell_other(r, name, "size", text);
    } else if (!st) {
        struct verdict v;
        st = measure(&why, r->options, name, pair, &v);
        if (!st) {
            tell(r, name, &v);
            count(r, &v);
        }
    }
    ap_image_finish(&pair[0]);
    ap_image_finish(&pair[1]);
    return st ? ap_fail(err, st, "%s", why.text) : AP_OK;
}

static enum ap_status compare_pair(struct ap_error *err, struct run *r, char *const dir[2],
                                   const char *a, const char *b) {
    char *path[2] = {ap_path_join(dir[0], a), ap_path_join(dir[1], b)};
    enum ap_status st =
        path[0] && path[1] ? compare_files(err, r, a, (const char *const *)path) : no_memory(err);
    free(path[0]);
    free(path[1]);
    return st;
}

static void tell_missing(struct run *r, char *const dir[2], const char *name, int side) {
    char why[600];
    snprintf(why, sizeof why, "differs: missing in %s", dir[side]);
    for (char *c = why; *c; c++)
        *c = (unsigned char)*c < ' ' || *c == 0x7f ? '?' : *c;
    r->missing++;
    tell_other(r, name, side ? "missing in B" : "missing in A", why);
}

static enum ap_status compare_folders(struct ap_error *err, struct run *r, char *const dir[2]) {
    struct names names[2] = {{0}, {0}};
    enum ap_status st = list(err, dir[0], &names[0]);
    if (!st)
        st = list(err, dir[1], &names[1]);
    if (!st && (has_frames(&names[0]) || has_frames(&names[1])))
        for (int k = 0; k < 2; k++)
            keep_frames(&names[k]);
    if (!st && names[0].count + names[1].count == 0)
        st = ap_fail(err, AP_INPUT, "no picture (NNNNNN-left.png…) in %s or %s", dir[0], dir[1]);
    size_t i = 0, k = 0;
    while (!st && (i < names[0].count || k < names[1].count)) {
        int order = i == names[0].count   ? 1
                    : k == names[1].count ? -1
                                          : by_stem(&names[0].name[i], &names[1].name[k]);
        if (order == 0)
            st = compare_pair(err, r, dir, names[0].name[i], names[1].name[k]);
        else
            tell_missing(r, dir, order < 0 ? names[0].name[i] : names[1].name[k], order < 0);
        i += order <= 0;
        k += order >= 0;
    }
    names_finish(&names[0]);
    names_finish(&names[1]);
    return st;
}

// ---- the command

static enum ap_status kind_of(struct ap_error *err, const char *path, bool *folder) {
    struct stat s;
    if (stat(path, &s) != 0)
        return ap_fail(err, AP_INPUT, "%s: cannot be read: %s", path, strerror(errno));
    *folder = S_ISDIR(s.st_mode);
    return AP_OK;
}

static enum ap_status compare(struct ap_error *err, struct run *r, char *const path[2]) {
    bool folder[2];
    for (int k = 0; k < 2; k++) {
        enum ap_status st = kind_of(err, path[k], &folder[k]);
        if (st)
            return st;
    }
    if (folder[0] != folder[1])
        return ap_fail(err, AP_INPUT, "%s is a folder and %s is not: expected two of a kind",
                       path[!folder[0]], path[folder[0]]);
    return folder[0] ? compare_folders(err, r, path)
                     : compare_files(err, r, path[0], (const char *const *)path);
}

static enum ap_status check(struct ap_error *err, const struct options *o) {
    if (!(o->ppd > 0 && o->ppd <= 1000))
        return ap_fail(err, AP_USAGE, "--pixels-per-degree: expected above 0, at most 1000");
    if (o->limits.max_pixels < 0 || o->limits.max_step < 0 || o->limits.max_flip < 0)
        return ap_fail(err, AP_USAGE, "a --max- of less than 0 is never met");
    return AP_OK;
}

static enum ap_status open_csv(struct ap_error *err, const char *dir, struct ap_outfile *csv) {
    enum ap_status st = ap_make_dirs(err, dir);
    char *path = st ? NULL : ap_path_join(dir, "compare.csv");
    if (!st)
        st = path ? ap_outfile_open(err, path, csv) : no_memory(err);
    free(path);
    if (!st)
        fputs("picture,state,psnr_db,ssim,flip,pixels,largest_step,region_x,region_y,region_width,"
              "region_height,region_pixels\n",
              csv->stream);
    return st;
}

static enum ap_status finish(struct ap_error *err, const struct run *r) {
    printf("%zu pairs: %zu the same, %zu within the limits, %zu differ, %zu unreadable; %zu "
           "missing on one side",
           r->pairs, r->same, r->within, r->differ, r->unreadable, r->missing);
    if (r->within + r->differ > 0 && isfinite(r->lowest_psnr))
        printf("; lowest PSNR %.3f dB", r->lowest_psnr);
    putchar('\n');
    if (fflush(stdout) != 0 || ferror(stdout))
        return ap_fail(err, AP_ENVIRONMENT, "standard output: cannot be written");
    if (r->unreadable)
        return AP_INPUT; // each was told
    return r->differ || r->missing ? AP_DIFFERS : AP_OK;
}

static enum ap_status run_compare(struct ap_error *err, const struct options *o,
                                  char *const path[2]) {
    struct run r = {.options = o, .lowest_psnr = INFINITY};
    struct ap_outfile csv = {0};
    enum ap_status st = check(err, o);
    if (!st && o->out)
        st = open_csv(err, o->out, &csv);
    if (st)
        return st;
    r.csv = csv.stream;
    st = compare(err, &r, path);
    if (csv.stream && !st)
        st = ap_outfile_commit(err, &csv);
    else
        ap_outfile_abort(&csv);
    return st ? st : finish(err, &r);
}

static enum ap_status command(struct ap_error *err, int argc, char **argv) {
    struct options o = {.metric = "psnr", .limits = {NAN, NAN, NAN, NAN, NAN}, .ppd = AP_FLIP_PPD};
    const struct ap_option options[] = {
        {"metric", AP_OPTION_CHOICE, &o.metric, "psnr|ssim|flip|all",
         "what is computed beside PSNR (psnr)"},
        {"min-psnr", AP_OPTION_NUMBER, &o.limits.min_psnr, "DB", "let pass from this PSNR on"},
        {"min-ssim", AP_OPTION_NUMBER, &o.limits.min_ssim, "S", "let pass from this SSIM on"},
        {"max-flip", AP_OPTION_NUMBER, &o.limits.max_flip, "F", "let pass up to this mean FLIP"},
        {"max-pixels", AP_OPTION_NUMBER, &o.limits.max_pixels, "N",
         "let pass up to so many differing pixels"},
        {"max-step", AP_OPTION_NUMBER, &o.limits.max_step, "N",
         "let pass where no byte differs by more"},
        {"pixels-per-degree", AP_OPTION_NUMBER, &o.ppd, "N", "of FLIP's viewer (67.02)"},
        {"out", AP_OPTION_TEXT, &o.out, "DIR", "compare.csv and a picture of each difference"},
        {"quiet", AP_OPTION_FLAG, &o.quiet, "", "tell of what fails only, and the sum"},
    };
    const struct ap_usage usage = {
        .command = "compare",
        .operands = "A B",
        .text = "Tells two captures apart (folders of NNNNNN-left.png…, PNG or PAM), or two "
                "pictures. Pictures of\nthe same name are a pair; a line for each: PSNR, how many "
                "pixels differ and by how much, the largest\npatch of them. Without a limit any "
                "difference counts, with several all must hold. Exit status: 0 the\nsame or within "
                "the limits; 1 a difference, or a picture that one side lacks; 3 a picture or "
                "folder\nthat cannot be read.",
        .options = options,
        .option_count = sizeof options / sizeof *options,
        .min_operands = 2,
        .max_operands = 2};
    int operands;
    bool done;
    enum ap_status st = ap_parse_options(err, &usage, argc, argv, &operands, &done);
    return st || done ? st : run_compare(err, &o, argv + 1);
}

const struct ap_command ap_command_compare = {"compare", "tells two captures apart", command};
