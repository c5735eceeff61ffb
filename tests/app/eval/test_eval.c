#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <fcntl.h>
#include <signal.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "src/app/command.h"
#include "src/geom/map.h"
#include "src/view/view.h"

// The command as a process: requests in through a file or a pipe, answers and exit status out.

static void run_child(int in, int out) {
    signal(SIGPIPE, SIG_IGN); // as main() does
    dup2(in, STDIN_FILENO);
    dup2(out, STDOUT_FILENO);
    char name[] = "eval", *argv[] = {name, NULL};
    struct ap_error err = {""};
    enum ap_status st = ap_command_eval.run(&err, 1, argv);
    fflush(stdout);
    _exit(st && err.text[0] == '\0' ? 99 : (int)st);
}

static int wait_for(pid_t pid) {
    int status;
    assert_int_equal(waitpid(pid, &status, 0), pid);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status);
}

static FILE *scratch(const void *bytes, size_t len) {
    FILE *f = tmpfile();
    assert_non_null(f);
    assert_int_equal(fwrite(bytes, 1, len, f), len);
    rewind(f);
    return f;
}

// Exit status; the answers are malloc'ed into *text.
static int eval_bytes(const void *bytes, size_t len, char **text) {
    FILE *in = scratch(bytes, len), *out = scratch("", 0);
    fflush(stdout);
    pid_t pid = fork();
    assert_true(pid >= 0);
    if (pid == 0)
        run_child(fileno(in), fileno(out));
    int status = wait_for(pid);
    fseek(out, 0, SEEK_END);
    size_t size = (size_t)ftell(out);
    rewind(out);
    *text = calloc(1, size + 1);
    assert_non_null(*text);
    assert_int_equal(fread(*text, 1, size, out), size);
    fclose(in);
    fclose(out);
    return status;
}

static void expect(const char *requests, int status, const char *answers) {
    char *text;
    assert_int_equal(eval_bytes(requests, strlen(requests), &text), status);
    assert_string_equal(text, answers);
    free(text);
}

static size_t lines_in(const char *text) {
    size_t n = 0;
    for (; *text; text++)
        n += *text == '\n';
    return n;
}

static void test_quiet_lines(void **state) {
    (void)state;
    expect("", 0, "");
    expect("\n\n  \t\n# h3 1 exp\n  # too\n\r\n", 0, "");
    expect("e3 2 exp 1 2 3\r\n\ne3 2 exp 0 -0 .5e1", 0, "1 2 3 2\n0 0 5 2\n");
    expect("e3\t2   exp  1\t2 3 \n", 0, "1 2 3 2\n");
}

static void test_simple_answers(void **state) {
    (void)state;
    expect("e3 2 log 1 2 3 2\ne3 2 log 1 2 3 2 0\n", 0, "1 2 3\n1 2 3\n");
    expect("e3 2 dist 1 2 3 2 1 2 7 2\n", 0, "4\n");
    expect("e3 2 translate 1 2 3\n", 0, "1 0 0 0.5 0 1 0 1 0 0 1 1.5 0 0 0 1\n");
    expect("h3 2 walk\n", 0, "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n");
    expect("e3 2 walk 1 0 0 1 0 0 0 0 -2\n", 0, "1 0 0 1 0 1 0 0 0 0 1 -1 0 0 0 1\n");
    expect("s3 1 log 0 0 1 0 1\n", 0, "0 0 -4.7123889803846897\n");
    expect("s3 1 dist 0 0 0 1 0 0 0 -1\n", 0, "3.1415926535897931\n");
}

// Text of the library's own numbers, read back to the last bit.
static void test_seventeen_digits(void **state) {
    (void)state;
    for (int kappa = -1; kappa <= 1; kappa++) {
        struct ap_space s = {kappa, 0.85};
        struct ap_vec3 v = {0.1, -0.7, 1.0 / 3};
        char request[512], *text, *at;
        struct ap_iso m = ap_iso_translate(s, v);
        double vergence;
        assert_int_equal(ap_vergence_ahead(NULL, s, AP_VIEW_TOURIST, 0.064, 0.3, &vergence), 0);
        snprintf(request, sizeof request,
                 "%s 0.85 translate 0.1 -0.7 %.17g\n%s 0.85 vergence tourist 0.064 0.3\n",
                 ap_space_name(s), v.z, ap_space_name(s));
        assert_int_equal(eval_bytes(request, strlen(request), &text), 0);
        at = text;
        for (int i = 0; i < 17; i++) {
            double got = strtod(at, &at), expected = i < 16 ? m.m[i / 4][i % 4] : vergence;
            if (got != expected)
                fail_msg("kappa %d, number %d: %.17g, expected %.17g", kappa, i, got, expected);
            assert_true(*at == (i >= 15 ? '\n' : ' '));
        }
        free(text);
    }
}

static void test_bad_requests(void **state) {
    (void)state;
    static const char *const bad[] = {
        "h3",
        "h3 1",
        "h3 1 fly 1 2 3",
        "s3 1 exp 1e30 1e30 1e30",
        "s3 1 translate 0 1e16 0",
        "s3 1e-300 walk 1 0 0 1e150 0 0",
        "g3 1 exp 1 2 3",
        "s2xe 1 exp 1 2 3",
        "H3 1 exp 1 2 3",
        "averyveryverylongnameofaspace 1 exp 1 2 3",
        "h3 0 exp 1 2 3",
        "h3 -1 exp 1 2 3",
        "h3 nan exp 1 2 3",
        "h3 inf exp 1 2 3",
        "h3 0x1 exp 1 2 3",
        "h3 1,5 exp 1 2 3",
        "h3 1 exp",
        "h3 1 exp 1 2",
        "h3 1 exp 1 2 3 4",
        "h3 1 exp 1 2 x",
        "h3 1 exp 1 2 1e999",
        "h3 1 exp 1 2 inf",
        "h3 1 exp 1 2 3d",
        "h3 1 exp 800 0 0",
        "h3 1 log 0 0 0 2",
        "h3 1 log 0 0 0 1 1",
        "s3 1 log 0 0 0 -1",
        "s3 1 log 0 0 0 1 1",
        "s3 1 log 0 0 1 0 2",
        "s3 1 log 0 0 1 0 0.5",
        "s3 1 log 0 0 1 0 1 1",
        "e3 1 log 0 0 1 2",
        "h3 1 dist 0 0 0 1",
        "h3 1 dist 0 0 0 1 0 0 0 2",
        "h3 1 walk 1",
        "h3 1 walk 1 2 3 4",
        "h3 1 vergence",
        "h3 1 vergence native",
        "h3 1 vergence cinema 1 1",
        "h3 1 vergence native 0 1",
        "h3 1 vergence native 1 0",
        "h3 1 vergence native 1 -1",
        "s3 1 vergence native 1 6.3",
        "s3 1 vergence tourist 1 6.2831853071795872",
        "h3 1 vergence native 1 2 3",
        "\x01\x02 \xff",
        "; rm",
        "%s%s%n 1 exp 1 2 3",
    };
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        char requests[256], *text;
        snprintf(requests, sizeof requests, "%s\ne3 2 exp 1 2 3\n", bad[i]);
        int status = eval_bytes(requests, strlen(requests), &text);
        bool good = strncmp(text, "error: ", 7) == 0 && strlen(strchr(text, '\n')) > 1 &&
                    strcmp(strchr(text, '\n') + 1, "1 2 3 2\n") == 0;
        if (status != AP_DIFFERS || !good)
            fail_msg("'%s': status %d, answers '%s'", bad[i], status, text);
        for (const char *c = text; *c; c++)
            assert_true(*c == '\n' || (unsigned char)*c >= ' ');
        free(text);
    }
}

static void test_just_inside(void **state) {
    (void)state;
    char *text;
    const char requests[] = "s3 1 vergence tourist 1 6.2831853071795862\n"
                            "s3 1 log 0 0 1e-300 -1\nh3 1 exp 700 0 0\n";
    assert_int_equal(eval_bytes(requests, strlen(requests), &text), 0);
    assert_int_equal(lines_in(text), 3);
    free(text);
}

// Round s3 many times: the error of the length's last bit is an angle, to its square. The numbers
// are of 60 digits.
static void test_many_turns(void **state) {
    (void)state;
    static const double EXACT[4] = {0.36510285394995707, 0.36510285394995707, 0.36510285394995707,
                                    0.77466103433230004};
    const char request[] = "s3 1 exp 1e10 1e10 1e10\n";
    char *text, *at;
    assert_int_equal(eval_bytes(request, strlen(request), &text), 0);
    at = text;
    for (int i = 0; i < 4; i++) {
        double got = strtod(at, &at);
        if (!(fabs(got - EXACT[i]) < 1e-15))
            fail_msg("number %d: %.17g, expected %.17g to 1e-15", i, got, EXACT[i]);
    }
    free(text);
}

static void test_zero_bytes(void **state) {
    (void)state;
    char *text;
    const char requests[] = "e3 2 exp 1 2 3\0\n\0\ne3 2 exp 1 2 3\n";
    assert_int_equal(eval_bytes(requests, sizeof requests - 1, &text), AP_DIFFERS);
    assert_int_equal(lines_in(text), 3);
    assert_non_null(strstr(text, "\n1 2 3 2\n"));
    free(text);
}

// A walk of many steps on one line; past 16 MiB a line is refused, and the next one served.
static void test_long_lines(void **state) {
    (void)state;
    enum { STEPS = 20000, HUGE_LINE = (16 << 20) + 10 };
    char *line = malloc(HUGE_LINE + 64), *text, *at = line;
    assert_non_null(line);
    at += sprintf(at, "e3 2 walk");
    for (int i = 0; i < STEPS; i++)
        at += sprintf(at, " 0 0.5 -1");
    at += sprintf(at, "\n");
    assert_int_equal(eval_bytes(line, (size_t)(at - line), &text), 0);
    assert_string_equal(text, "1 0 0 0 0 1 0 5000 0 0 1 -10000 0 0 0 1\n");
    free(text);
    memset(line, '1', HUGE_LINE);
    memcpy(line + HUGE_LINE, "\ne3 2 exp 1 2 3\n", 17);
    assert_int_equal(eval_bytes(line, HUGE_LINE + 16, &text), AP_DIFFERS);
    assert_memory_equal(text, "error: ", 7);
    assert_string_equal(strchr(text, '\n'), "\n1 2 3 2\n");
    free(text);
    free(line);
}

static void test_answers_cannot_be_written(void **state) {
    (void)state;
    FILE *in = scratch("e3 2 exp 1 2 3\n", 15);
    int full = open("/dev/full", O_WRONLY), ends[2];
    assert_true(full >= 0);
    fflush(stdout);
    pid_t pid = fork();
    if (pid == 0)
        run_child(fileno(in), full);
    assert_int_equal(wait_for(pid), AP_ENVIRONMENT);
    close(full);
    rewind(in);
    assert_int_equal(pipe(ends), 0);
    close(ends[0]); // nobody reads
    pid = fork();
    if (pid == 0)
        run_child(fileno(in), ends[1]);
    assert_int_equal(wait_for(pid), AP_ENVIRONMENT);
    close(ends[1]);
    fclose(in);
}

static void test_requests_cannot_be_read(void **state) {
    (void)state;
    int folder = open(".", O_RDONLY);
    FILE *out = scratch("", 0);
    fflush(stdout);
    pid_t pid = fork();
    if (pid == 0)
        run_child(folder, fileno(out));
    assert_int_equal(wait_for(pid), AP_INPUT);
    close(folder);
    fclose(out);
}

// Ask, wait for the answer, ask again: nothing is held back in a buffer.
static void test_conversation(void **state) {
    (void)state;
    int to[2], from[2];
    assert_int_equal(pipe(to), 0);
    assert_int_equal(pipe(from), 0);
    fflush(stdout);
    pid_t pid = fork();
    if (pid == 0) {
        close(to[1]);
        run_child(to[0], from[1]);
    }
    close(to[0]);
    close(from[1]);
    alarm(20); // a held answer must not hang the suite
    for (int i = 0; i < 3; i++) {
        char answer[64] = "";
        assert_int_equal(write(to[1], "e3 2 exp 1 2", 12), 12);
        assert_int_equal(write(to[1], " 3\n", 3), 3);
        assert_int_equal(read(from[0], answer, sizeof answer - 1), 8);
        assert_string_equal(answer, "1 2 3 2\n");
    }
    alarm(0);
    close(to[1]);
    assert_int_equal(wait_for(pid), 0);
    close(from[0]);
}

static void test_options(void **state) {
    (void)state;
    char name[] = "eval", bad[] = "--fast", more[] = "file";
    char *option[] = {name, bad, NULL}, *operand[] = {name, more, NULL};
    struct ap_error err = {""};
    assert_int_equal(ap_command_eval.run(&err, 2, option), AP_USAGE);
    assert_int_equal(ap_command_eval.run(&err, 2, operand), AP_USAGE);
    assert_true(err.text[0] != '\0');
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_quiet_lines),
        cmocka_unit_test(test_simple_answers),
        cmocka_unit_test(test_seventeen_digits),
        cmocka_unit_test(test_bad_requests),
        cmocka_unit_test(test_just_inside),
        cmocka_unit_test(test_many_turns),
        cmocka_unit_test(test_zero_bytes),
        cmocka_unit_test(test_long_lines),
        cmocka_unit_test(test_answers_cannot_be_written),
        cmocka_unit_test(test_requests_cannot_be_read),
        cmocka_unit_test(test_conversation),
        cmocka_unit_test(test_options),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
