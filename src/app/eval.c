#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "src/app/command.h"
#include "src/base/number.h"
#include "src/geom/map.h"
#include "src/view/view.h"

// A request per line on standard input, an answer per line on standard output.

enum { LINE_MAX_BYTES = 16 << 20, BLOCK_BYTES = 1 << 16, ANSWER_MAX = 16 };

struct reader {
    char block[BLOCK_BYTES];
    size_t at, end;
    char *line;
    size_t len, room;
    bool too_long; // the rest of the line was read and dropped
};

// Flushes before it may block, so that whoever writes a request and waits gets its answer.
static enum ap_status fill(struct ap_error *err, struct reader *r) {
    if (fflush(stdout) != 0)
        return ap_fail(err, AP_ENVIRONMENT, "cannot write the answers: %s", strerror(errno));
    ssize_t n;
    do
        n = read(STDIN_FILENO, r->block, sizeof r->block);
    while (n < 0 && errno == EINTR);
    if (n < 0)
        return ap_fail(err, AP_INPUT, "cannot read standard input: %s", strerror(errno));
    r->at = 0;
    r->end = (size_t)n;
    return AP_OK;
}

static enum ap_status append(struct ap_error *err, struct reader *r, const char *bytes, size_t n) {
    if (n == 0)
        return AP_OK;
    if (r->too_long || n > LINE_MAX_BYTES - r->len) {
        r->too_long = true;
        return AP_OK;
    }
    if (r->len + n > r->room) {
        size_t room = 2 * (r->len + n);
        char *line = realloc(r->line, room);
        if (!line)
            return ap_fail(err, AP_ENVIRONMENT, "no memory for a line of %zu bytes", r->len + n);
        r->line = line;
        r->room = room;
    }
    memcpy(r->line + r->len, bytes, n);
    r->len += n;
    return AP_OK;
}

// The next line without its end ("\n" or "\r\n"); *more is false at the end of the input.
static enum ap_status read_line(struct ap_error *err, struct reader *r, bool *more) {
    r->len = 0;
    r->too_long = false;
    bool any = false, ended = false;
    while (!ended) {
        if (r->at == r->end) {
            enum ap_status st = fill(err, r);
            if (st)
                return st;
            if (r->end == 0)
                break;
        }
        any = true;
        char *start = r->block + r->at, *newline = memchr(start, '\n', r->end - r->at);
        ended = newline != NULL;
        size_t n = ended ? (size_t)(newline - start) : r->end - r->at;
        r->at += n + ended;
        enum ap_status st = append(err, r, start, n);
        if (st)
            return st;
    }
    if (r->len > 0 && r->line[r->len - 1] == '\r')
        r->len--;
    *more = any;
    return AP_OK;
}

struct words {
    const char *at, *end;
    size_t index; // of the word last taken, from 1
};

struct word {
    const char *text;
    size_t len;
};

static bool is_blank(char c) {
    return c == ' ' || c == '\t';
}

static bool next_word(struct words *words, struct word *word) {
    while (words->at < words->end && is_blank(*words->at))
        words->at++;
    word->text = words->at;
    while (words->at < words->end && !is_blank(*words->at))
        words->at++;
    word->len = (size_t)(words->at - word->text);
    words->index += word->len > 0;
    return word->len > 0;
}

static bool word_is(struct word word, const char *text) {
    return word.len == strlen(text) && memcmp(word.text, text, word.len) == 0;
}

static int shown(struct word word) {
    return word.len < 40 ? (int)word.len : 40;
}

struct request {
    struct ap_space space;
    enum ap_view_mode mode;
    double *numbers; // kept from request to request
    size_t count, room;
};

struct answer {
    double value[ANSWER_MAX];
    size_t count;
};

static enum ap_status take_number(struct ap_error *err, struct words *words, struct word word,
                                  double *value) {
    if (ap_parse_double(word.text, word.len, value))
        return AP_OK;
    return ap_fail(err, AP_INPUT, "word %zu: expected a finite decimal number, not '%.*s'",
                   words->index, shown(word), word.text);
}

static enum ap_status take_space(struct ap_error *err, struct words *words,
                                 struct ap_space *space) {
    struct word name, radius;
    double rho_m;
    char text[8] = "";
    next_word(words, &name);
    if (!next_word(words, &radius))
        return ap_fail(err, AP_INPUT, "expected SPACE RADIUS OP ARGS");
    enum ap_status st = take_number(err, words, radius, &rho_m);
    if (st)
        return st;
    if (name.len >= sizeof text)
        return ap_fail(err, AP_INPUT, "no space is named '%.*s': use s3, e3 or h3", shown(name),
                       name.text);
    memcpy(text, name.text, name.len);
    return ap_space_from_name(err, text, rho_m, space);
}

static enum ap_status take_numbers(struct ap_error *err, struct words *words,
                                   struct request *request) {
    request->count = 0;
    for (struct word word; next_word(words, &word);) {
        if (request->count == request->room) {
            size_t room = 2 * request->room + 64;
            double *numbers = realloc(request->numbers, room * sizeof *numbers);
            if (!numbers)
                return ap_fail(err, AP_ENVIRONMENT, "no memory for %zu numbers", room);
            request->numbers = numbers;
            request->room = room;
        }
        enum ap_status st = take_number(err, words, word, &request->numbers[request->count]);
        if (st)
            return st;
        request->count++;
    }
    return AP_OK;
}

static struct ap_vec3 vec3_at(const double *n) {
    return (struct ap_vec3){n[0], n[1], n[2]};
}

static struct ap_vec4 vec4_at(const double *n) {
    return (struct ap_vec4){n[0], n[1], n[2], n[3]};
}

static struct answer of_iso(struct ap_iso m) {
    struct answer a = {.count = 16};
    memcpy(a.value, m.m, sizeof m.m);
    return a;
}

// Round s3 more often than this, the rounding of an arc's length is an angle.
static const double MOST_RAD = 0x1p50;

static enum ap_status check_arcs(struct ap_error *err, const struct request *r) {
    for (size_t i = 0; r->space.kappa > 0 && i + 3 <= r->count; i += 3) {
        double t = ap_vec3_length(vec3_at(r->numbers + i)) / r->space.rho_m;
        if (!(t < MOST_RAD))
            return ap_fail(err, AP_INPUT,
                           "more than %.0e radii long: no digit of where it ends in s3 is left",
                           MOST_RAD);
    }
    return AP_OK;
}

static enum ap_status run_exp(struct ap_error *err, const struct request *r, struct answer *a) {
    enum ap_status st = check_arcs(err, r);
    struct ap_vec4 p = ap_exp(r->space, vec3_at(r->numbers));
    if (!st)
        *a = (struct answer){{p.x, p.y, p.z, p.w}, 4};
    return st;
}

static enum ap_status run_log(struct ap_error *err, const struct request *r, struct answer *a) {
    double image = r->count == 5 ? r->numbers[4] : 0;
    struct ap_vec3 v;
    if (image != 0 && image != 1)
        return ap_fail(err, AP_INPUT, "image %g: expected 0, or 1 in s3", image);
    enum ap_status st = ap_log_map(err, r->space, vec4_at(r->numbers), (int)image, &v);
    if (!st)
        *a = (struct answer){{v.x, v.y, v.z}, 3};
    return st;
}

static enum ap_status run_dist(struct ap_error *err, const struct request *r, struct answer *a) {
    a->count = 1;
    return ap_distance(err, r->space, vec4_at(r->numbers), vec4_at(r->numbers + 4), a->value);
}

static enum ap_status run_translate(struct ap_error *err, const struct request *r,
                                    struct answer *a) {
    enum ap_status st = check_arcs(err, r);
    if (!st)
        *a = of_iso(ap_iso_translate(r->space, vec3_at(r->numbers)));
    return st;
}

static enum ap_status run_walk(struct ap_error *err, const struct request *r, struct answer *a) {
    enum ap_status st = check_arcs(err, r);
    if (st)
        return st;
    size_t count = r->count / 3;
    struct ap_vec3 *steps = malloc(count ? count * sizeof *steps : 1);
    if (!steps)
        return ap_fail(err, AP_ENVIRONMENT, "no memory for %zu steps", count);
    for (size_t i = 0; i < count; i++)
        steps[i] = vec3_at(r->numbers + 3 * i);
    *a = of_iso(ap_iso_walk(r->space, steps, count));
    free(steps);
    return AP_OK;
}

static enum ap_status run_vergence(struct ap_error *err, const struct request *r,
                                   struct answer *a) {
    a->count = 1;
    return ap_vergence_ahead(err, r->space, r->mode, r->numbers[0], r->numbers[1], a->value);
}

struct op {
    const char *name, *arguments;
    size_t min, max; // numbers; max 0: any multiple of three
    enum ap_status (*run)(struct ap_error *err, const struct request *request, struct answer *a);
};

static const struct op ops[] = {
    {"exp", "vx vy vz", 3, 3, run_exp},
    {"log", "x y z w [image]", 4, 5, run_log},
    {"dist", "two points, 8 numbers", 8, 8, run_dist},
    {"translate", "vx vy vz", 3, 3, run_translate},
    {"walk", "triples vx vy vz", 0, 0, run_walk},
    {"vergence", "native|tourist IPD D", 2, 2, run_vergence},
};

static enum ap_status take_op(struct ap_error *err, struct words *words, const struct op **op) {
    struct word word;
    if (!next_word(words, &word))
        return ap_fail(err, AP_INPUT, "expected SPACE RADIUS OP ARGS");
    for (size_t i = 0; i < sizeof ops / sizeof ops[0]; i++) {
        if (word_is(word, ops[i].name)) {
            *op = &ops[i];
            return AP_OK;
        }
    }
    return ap_fail(err, AP_INPUT,
                   "no operation '%.*s': use exp, log, dist, translate, walk or vergence",
                   shown(word), word.text);
}

static enum ap_status take_mode(struct ap_error *err, struct words *words,
                                enum ap_view_mode *mode) {
    struct word word;
    bool any = next_word(words, &word);
    if (any && word_is(word, "native"))
        *mode = AP_VIEW_NATIVE;
    else if (any && word_is(word, "tourist"))
        *mode = AP_VIEW_TOURIST;
    else
        return ap_fail(err, AP_INPUT, "vergence: expected native or tourist, not '%.*s'",
                       shown(word), word.text);
    return AP_OK;
}

static enum ap_status evaluate(struct ap_error *err, struct words words, struct request *request,
                               struct answer *answer) {
    const struct op *op = NULL;
    enum ap_status st = take_space(err, &words, &request->space);
    if (!st)
        st = take_op(err, &words, &op);
    if (!st && op->run == run_vergence)
        st = take_mode(err, &words, &request->mode);
    if (!st)
        st = take_numbers(err, &words, request);
    if (st)
        return st;
    size_t n = request->count;
    if (op->max ? n < op->min || n > op->max : n % 3 != 0)
        return ap_fail(err, AP_INPUT, "%s: %zu numbers: expected %s", op->name, n, op->arguments);
    st = op->run(err, request, answer);
    for (size_t i = 0; !st && i < answer->count; i++)
        if (!isfinite(answer->value[i]))
            st = ap_fail(err, AP_INPUT, "%s: the answer is beyond the range of a double", op->name);
    return st;
}

static void print_answer(const struct answer *answer) {
    char text[AP_DOUBLE_TEXT_MAX];
    for (size_t i = 0; i < answer->count; i++) {
        size_t n = ap_format_double(text, answer->value[i] + 0.0); // no "-0"
        fwrite(text, 1, n, stdout);
        putchar(i + 1 < answer->count ? ' ' : '\n');
    }
}

// One line: nothing, an answer or an error. AP_ENVIRONMENT stops the program.
static enum ap_status serve(struct ap_error *err, const struct reader *r, struct request *request,
                            size_t *asked, size_t *failed) {
    if (r->len == 0)
        return AP_OK;
    struct words words = {r->line, r->line + r->len, 0}, peek = words;
    struct word first;
    struct ap_error reason;
    struct answer answer;
    if (!next_word(&peek, &first) || first.text[0] == '#')
        return AP_OK;
    ++*asked;
    enum ap_status st =
        r->too_long ? ap_fail(&reason, AP_INPUT, "the line is longer than %d bytes", LINE_MAX_BYTES)
                    : evaluate(&reason, words, request, &answer);
    if (st == AP_ENVIRONMENT)
        return ap_fail(err, st, "%s", reason.text);
    if (!st) {
        print_answer(&answer);
    } else {
        ++*failed;
        printf("error: %s\n", reason.text);
    }
    return ferror(stdout) ? ap_fail(err, AP_ENVIRONMENT, "cannot write the answers") : AP_OK;
}

static enum ap_status serve_all(struct ap_error *err) {
    struct reader *r = calloc(1, sizeof *r);
    struct request request = {{0, 1}, AP_VIEW_NATIVE, NULL, 0, 0};
    size_t asked = 0, failed = 0;
    enum ap_status st = r ? AP_OK : ap_fail(err, AP_ENVIRONMENT, "no memory");
    for (bool more = true; !st;) {
        st = read_line(err, r, &more);
        if (st || !more)
            break;
        st = serve(err, r, &request, &asked, &failed);
    }
    if (!st && failed)
        st = ap_fail(err, AP_DIFFERS, "%zu of %zu requests failed", failed, asked);
    if (r)
        free(r->line);
    free(r);
    free(request.numbers);
    return st;
}

static enum ap_status run_eval(struct ap_error *err, int argc, char **argv) {
    static const struct ap_usage usage = {
        .command = "eval",
        .operands = "",
        .text =
            "Reads a request per line from standard input, SPACE RADIUS OP ARGS, and writes an\n"
            "answer per line with 17 significant digits. SPACE is s3, e3 or h3, RADIUS in metres.\n"
            "\n"
            "  exp vx vy vz                  the point x y z w\n"
            "  log x y z w [image]           the tangent vector vx vy vz\n"
            "  dist x y z w x y z w          the distance of two points\n"
            "  translate vx vy vz            the isometry, 16 numbers by rows\n"
            "  walk vx vy vz vx vy vz ...    the product of the translations\n"
            "  vergence native|tourist IPD D the angle straight ahead, radians\n"
            "\n"
            "A bad request is answered by 'error: ...' and the rest go on. Blank lines and lines\n"
            "that begin with # give no answer. Exit status: 0; 1 some requests failed; 3 standard\n"
            "input cannot be read; 4 the answers cannot be written.",
    };
    int operands;
    bool done;
    enum ap_status st = ap_parse_options(err, &usage, argc, argv, &operands, &done);
    return st || done ? st : serve_all(err);
}

const struct ap_command ap_command_eval = {"eval", "points and isometries, for other programs",
                                           run_eval};
