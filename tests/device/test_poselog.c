#include <inttypes.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "src/device/poselog.h"
#include "tests/device/memory_file.h"

// What a log of up to four texts gives, as one string: "t device x y z qx qy qz qw;" per sample,
// then the error, if any, with the file's name as FILE.
struct reading {
    char rows[4096];
    char error[AP_ERROR_TEXT_MAX];
    enum ap_status status;
    int64_t skipped;
};

static void append(struct reading *r, const char *device, const struct ap_sample *s) {
    const struct ap_pose *p = &s->pose;
    const double v[7] = {p->p.x, p->p.y, p->p.z, p->q.x, p->q.y, p->q.z, p->q.w};
    size_t n = strlen(r->rows), size = sizeof r->rows;
    n += (size_t)snprintf(r->rows + n, size - n, "%" PRId64 " %s", s->t_ns, device);
    for (int i = 0; i < 7 && n < size; i++) // what a turn leaves of a zero is zero
        n += (size_t)snprintf(r->rows + n, size - n, " %g", fabs(v[i]) < 1e-15 ? 0 : v[i]);
    if (n < size)
        snprintf(r->rows + n, size - n, ";");
}

static void hide_path(char *text) {
    for (char *at; (at = strstr(text, "/dev/fd/")) != NULL;) {
        char *end = at + 8 + strspn(at + 8, "0123456789");
        memmove(at + 4, end, strlen(end) + 1);
        memcpy(at, "FILE", 4);
    }
}

static struct reading read_all(const struct ap_poselog_params *params) {
    struct reading r = {0};
    struct ap_error err = {""};
    struct ap_poselog *log = NULL;
    r.status = ap_poselog_open(&err, params, &log);
    bool got = true;
    while (!r.status && got) {
        struct ap_sample sample;
        r.status = ap_poselog_next(&err, log, &sample, &got);
        if (!r.status && got)
            append(&r, ap_poselog_device_name(log, sample.device), &sample);
    }
    if (r.status && log) { // fails the same way again
        struct ap_error again = {""};
        struct ap_sample sample;
        assert_int_equal(ap_poselog_next(&again, log, &sample, &got), r.status);
        assert_string_equal(again.text, err.text);
    }
    memcpy(r.error, err.text, sizeof r.error);
    hide_path(r.error);
    if (log)
        r.skipped = ap_poselog_skipped(log);
    ap_poselog_close(log);
    return r;
}

// `texts` ends with NULL; each may start with "role=>".
static struct reading read_texts(struct ap_poselog_params params, const char *const *texts) {
    struct memory_file files[4];
    char arguments[4][128];
    const char *sources[4];
    size_t n = 0;
    for (; texts[n]; n++) {
        const char *arrow = strstr(texts[n], "=>");
        files[n] = memory_text(arrow ? arrow + 2 : texts[n]);
        int role = arrow ? (int)(arrow + 1 - texts[n]) : 0;
        snprintf(arguments[n], sizeof arguments[n], "%.*s%s", role, texts[n], files[n].path);
        sources[n] = arguments[n];
    }
    params.sources = sources;
    params.source_count = n;
    struct reading r = read_all(&params);
    for (size_t i = 0; i < n; i++)
        close(files[i].fd);
    return r;
}

#define READ(...)                                                                                  \
    read_texts((struct ap_poselog_params){.skip_bad = false},                                      \
               (const char *const[]){__VA_ARGS__, NULL})
#define READ_WITH(params, ...) read_texts(params, (const char *const[]){__VA_ARGS__, NULL})

static const struct ap_poselog_params skipping = {.skip_bad = true};

static void check_rows(struct reading r, const char *rows) {
    if (r.status)
        fail_msg("error %d: %s", r.status, r.error);
    assert_string_equal(r.rows, rows);
}

static void check_error(struct reading r, const char *rows, const char *error) {
    assert_int_equal(r.status, AP_INPUT);
    assert_string_equal(r.rows, rows);
    if (strncmp(r.error, error, strlen(error)) != 0)
        fail_msg("'%s', expected '%s…'", r.error, error);
}

#define HEADER "t_ns,device,px,py,pz,qx,qy,qz,qw\n"

static void test_formats(void **unused) {
    (void)unused;
    check_rows(READ(HEADER "1,head,1,2,3,0,0,0,1\n2,my-pen,4,5,6,1,0,0,0\n"),
               "1 head 1 2 3 0 0 0 1;2 my-pen 4 5 6 1 0 0 0;");
    check_rows(READ("# TUM\n1.5 1 2 3 0.6 0 0 0.8\n"), "1500000000 head 1 2 3 0.6 0 0 0.8;");
    check_rows(READ("#timestamp [ns], p_x [m]\n1403636580838555648,1,2,3,0.8,0.6,0,0,7,x,\n"),
               "1403636580838555648 head 1 2 3 0.6 0 0 0.8;");
    check_rows(READ("\xef\xbb\xbf# c\r\n\r\n" HEADER "1,head,1,2,3,0,0,0,1\r\n  # more\n"
                    " 2 , head\t, 1,2,3,0,0,0,1"),
               "1 head 1 2 3 0 0 0 1;2 head 1 2 3 0 0 0 1;");
    check_rows(READ("\xef\xbb\xbf" HEADER), "");
    check_rows(READ("  0\t1  2 3 0 0 0 1 \r\n"), "0 head 1 2 3 0 0 0 1;");
    // Columns in another order, unknown ones among them.
    check_rows(READ("note,qw,qx,qy,qz,device,pz,py,px,t_ns\nhello,1,0,0,0,head,3,2,1,9\n"),
               "9 head 1 2 3 0 0 0 1;");
}

static void test_unknown_formats(void **unused) {
    (void)unused;
    check_error(READ(""), "", "FILE: no pose in it");
    check_error(READ("# only\n\n"), "", "FILE: no pose in it");
    check_error(READ("# c\nhello\n"), "", "FILE:2:1: expected a pose log");
    check_error(
        READ("D: 0\nR: 3 01 02 03\n"), "",
        "FILE:2:6: expected a descriptor without fault (report descriptor, byte 2: an item");
    check_error(READ("D: 0\nN: x\n"), "", "FILE: no report in this HID recording");
    check_error(READ("t_ns,device,px,py,pz,qx,qy,qz\n"), "",
                "FILE:1:1: expected the header t_ns,device,px,py,pz,qx,qy,qz,qw[,…]; it has no qw");
    check_error(READ("t_ns,device,px,py,pz,qx,qy,qz,qw,px\n"), "",
                "FILE:1:34: expected each column name once, not 'px' again");
    check_error(READ("{\"json\": [1, 2]}"), "", "FILE: /: expected a motion capture");
    check_error(READ("0,1,2,3,1,0,0\n"), "", "FILE: no pose in it; rates and forces of fewer than");
    struct ap_error err;
    struct ap_poselog *log = NULL;
    const char *missing = "left=/nonexistent/log.csv", *folder = "/", *empty = "left=";
    struct ap_poselog_params params = {.sources = &missing, .source_count = 1};
    assert_int_equal(ap_poselog_open(&err, &params, &log), AP_INPUT);
    assert_string_equal(err.text, "/nonexistent/log.csv: cannot open: No such file or directory");
    params.sources = &folder;
    assert_int_equal(ap_poselog_open(&err, &params, &log), AP_INPUT);
    params.sources = &empty;
    assert_int_equal(ap_poselog_open(&err, &params, &log), AP_USAGE);
    params.source_count = 0;
    assert_int_equal(ap_poselog_open(&err, &params, &log), AP_USAGE);
    assert_null(log);
}

struct bad_case {
    const char *text, *rows, *error;
};

static const struct bad_case bad_cases[] = {
    {HEADER "1,head,1,2,3,0,0,0,1,5\n", "",
     "FILE:2:23: expected 9 fields as in the header, not 10"},
    {HEADER "1,head,1,2,3,0,0,0\n", "", "FILE:2:19: expected 9 fields"},
    {HEADER "1.5,head,1,2,3,0,0,0,1\n", "", "FILE:2:1: expected the time in whole nanoseconds"},
    {HEADER "9000000000000000000,head,1,2,3,0,0,0,1\n", "", "FILE:2:1: expected the time"},
    {HEADER "1,,1,2,3,0,0,0,1\n", "", "FILE:2:3: expected a device"},
    {HEADER "1,my pen,1,2,3,0,0,0,1\n", "", "FILE:2:3: expected a device"},
    {HEADER "1,head,1,nan,3,0,0,0,1\n", "", "FILE:2:10: expected a decimal number for py"},
    {HEADER "1,head,1, x,3,0,0,0,1\n", "", "FILE:2:11: expected a decimal number for py"},
    {HEADER "1,head,1,inf,3,0,0,0,1\n", "", "FILE:2:10: expected a decimal number for py"},
    {HEADER "1,head,1e10,2,3,0,0,0,1\n", "", "FILE:2:8: expected a decimal number for px"},
    {HEADER "1,head,1,2,,0,0,0,1\n", "", "FILE:2:12: expected a decimal number for pz"},
    {HEADER "1,head,1,2,3,0,0,0,0.9\n", "", "FILE:2:14: expected a unit quaternion"},
    {HEADER "1,head,1,2,3,0,0,0,1.1\n", "", "FILE:2:14: expected a unit quaternion"},
    {HEADER "1,head,1,2,3,0,0,0,0\n", "", "FILE:2:14: expected a unit quaternion"},
    {HEADER "5,head,1,2,3,0,0,0,1\n4,left,1,2,3,0,0,0,1\n", "5 head 1 2 3 0 0 0 1;",
     "FILE:3:1: expected a time not before the line before (5 ns), not 4 ns"},
    {HEADER "5,head,1,2,3,0,0,0,1\n5,left,1,2,3,0,0,0,1\n5,head,1,2,3,0,0,0,1\n",
     "5 head 1 2 3 0 0 0 1;5 left 1 2 3 0 0 0 1;",
     "FILE:4:1: expected a time after the last one of 'head' (5 ns)"},
    {"t_ns,device,px,py,pz,qx,qy,qz,qw,trigger,select\n1,head,1,2,3,0,0,0,1,1.5,0\n", "",
     "FILE:2:22: expected trigger between 0 and 1"},
    {"t_ns,device,px,py,pz,qx,qy,qz,qw,trigger,select\n1,head,1,2,3,0,0,0,1,,2\n", "",
     "FILE:2:23: expected select 0 or 1"},
    {"0 1 2 3 0 0 0\n", "", "FILE:1:14: expected 8 fields (t x y z qx qy qz qw), not 7"},
    {"0 1 2 3 0 0 0 1 9\n", "", "FILE:1:18: expected 8 fields"},
    {"0 1 2 3 0 0 0 1\n0 1 2 3 0 0 0 1\n", "0 head 1 2 3 0 0 0 1;",
     "FILE:2:1: expected a time after the last one of 'head'"},
    {"0 1 2 3 0 0 0 1\n1 1 2 3 0 0 a 1\n", "0 head 1 2 3 0 0 0 1;",
     "FILE:2:13: expected a decimal number for qz"},
    {"0,1,2,3,1,0,0,0\n1,1,2,3,1,0,0\n", "0 head 1 2 3 0 0 0 1;",
     "FILE:2:14: expected at least 8 fields"},
    {"0,1,2,3,1,0,0,\n", "", "FILE:1:15: expected a decimal number for qz"},
};

static void test_bad_lines(void **unused) {
    (void)unused;
    for (size_t i = 0; i < sizeof bad_cases / sizeof *bad_cases; i++)
        check_error(READ(bad_cases[i].text), bad_cases[i].rows, bad_cases[i].error);
}

static void test_skip_bad(void **unused) {
    (void)unused;
    for (size_t i = 0; i < sizeof bad_cases / sizeof *bad_cases; i++) {
        struct reading r = READ_WITH(skipping, bad_cases[i].text);
        check_rows(r, bad_cases[i].rows);
        assert_int_equal(r.skipped, 1);
    }
    struct reading r = READ_WITH(skipping, "noise\n0 1 2 3 0 0 0 1\nx\n-1 1 2 3 0 0 0 1\n"
                                           "0 1 2 3 0 0 0 1\n1 1 2 3 0 0 0 1\n");
    check_rows(r, "0 head 1 2 3 0 0 0 1;1000000000 head 1 2 3 0 0 0 1;");
    assert_int_equal(r.skipped, 4);
    // No header, nothing to read: that is not one bad line.
    r = READ_WITH(skipping, "t,device\n1,head\n");
    assert_int_equal(r.status, AP_INPUT);
}

static void test_long_lines(void **unused) {
    (void)unused;
    static char text[300000];
    for (size_t len = 65530; len < 65545; len++) {
        size_t n =
            (size_t)snprintf(text, sizeof text, HEADER "1,head,1,2,3,0,0,0,1\n2,head,1,2,3,0,");
        size_t start = n - 15;
        while (n - start < len - 4)
            text[n++] = '0';
        n += (size_t)snprintf(text + n, 64, ",0,1\r\n3,head,1,2,3,0,0,0,1\n");
        struct reading r = READ(text);
        if (len <= 65536)
            check_rows(r, "1 head 1 2 3 0 0 0 1;2 head 1 2 3 0 0 0 1;3 head 1 2 3 0 0 0 1;");
        else
            check_error(r, "1 head 1 2 3 0 0 0 1;", "FILE:3:65537: expected a line of at most");
        r = READ_WITH(skipping, text);
        assert_int_equal(r.skipped, len > 65536);
    }
    memset(text, 'x', sizeof text - 1);
    check_error(READ(text), "", "FILE:1:65537: expected a line of at most 65536 bytes");
}

static void test_renormalises(void **unused) {
    (void)unused;
    check_rows(READ(HEADER "1,head,0,0,0,0,0.54001,0,0.72001\n2,head,0,0,0,0,0,-1.0999,0\n"),
               "1 head 0 0 0 0 0.600002 0 0.799999;2 head 0 0 0 0 0 -1 0;");
}

static void test_merge_is_stable(void **unused) {
    (void)unused;
    const char *a = HEADER "1,head,1,0,0,0,0,0,1\n2,a,1,0,0,0,0,0,1\n2,b,2,0,0,0,0,0,1\n"
                           "9,head,2,0,0,0,0,0,1\n";
    const char *b = "left=>0 3 0 0 0 0 0 1\n0.000000002 4 0 0 0 0 0 1\n0.000000009 5 0 0 0 0 0 1";
    check_rows(READ(a, b), "0 left 3 0 0 0 0 0 1;1 head 1 0 0 0 0 0 1;2 a 1 0 0 0 0 0 1;"
                           "2 b 2 0 0 0 0 0 1;2 left 4 0 0 0 0 0 1;9 head 2 0 0 0 0 0 1;"
                           "9 left 5 0 0 0 0 0 1;");
    check_rows(READ(b, a), "0 left 3 0 0 0 0 0 1;1 head 1 0 0 0 0 0 1;2 left 4 0 0 0 0 0 1;"
                           "2 a 1 0 0 0 0 0 1;2 b 2 0 0 0 0 0 1;9 left 5 0 0 0 0 0 1;"
                           "9 head 2 0 0 0 0 0 1;");
    // The same device twice: one recording in two parts is fine, two heads at once are not.
    check_rows(READ("0 1 0 0 0 0 0 1", "1e-9 2 0 0 0 0 0 1"),
               "0 head 1 0 0 0 0 0 1;1 head 2 0 0 0 0 0 1;");
    check_error(READ("0 1 0 0 0 0 0 1", "0 2 0 0 0 0 0 1"), "0 head 1 0 0 0 0 0 1;",
                "FILE:1:1: expected a time after the last one of 'head'");
}

static void test_roles(void **unused) {
    (void)unused;
    check_rows(READ("right=>" HEADER "1,head,1,2,3,0,0,0,1\n"), "1 right 1 2 3 0 0 0 1;");
    check_rows(READ("pen_2-a=>0 1 2 3 0 0 0 1\n"), "0 pen_2-a 1 2 3 0 0 0 1;");
    check_error(READ("right=>" HEADER "1,a,1,2,3,0,0,0,1\n2,b,1,2,3,0,0,0,1\n"),
                "1 right 1 2 3 0 0 0 1;",
                "FILE:3:3: expected only the device 'a', because right= renames it");
    // Not a word before the '=': part of the file's name.
    struct ap_error err;
    struct ap_poselog *log = NULL;
    const char *odd = "./left=x";
    struct ap_poselog_params params = {.sources = &odd, .source_count = 1};
    assert_int_equal(ap_poselog_open(&err, &params, &log), AP_INPUT);
    assert_non_null(strstr(err.text, "./left=x: cannot open"));
}

static void test_axes(void **unused) {
    (void)unused;
    const struct ap_poselog_params z_up = {.z_up = true},
                                   optical = {.head_frame = AP_HEAD_FRAME_OPTICAL},
                                   table = {.has_table = true,
                                            .table_x_m = 2,
                                            .table_z_m = 1,
                                            .table_yaw_rad = M_PI_2};
    check_rows(READ_WITH(z_up, "0 1 2 3 0 0 0 1\n"), "0 head 1 3 -2 -0.707107 0 0 0.707107;");
    // A camera that looks straight ahead along −z with its y down is a level head.
    check_rows(READ_WITH(optical, "0 1 2 3 1 0 0 0\n", "left=>0 1 2 3 1 0 0 0\n"),
               "0 head 1 2 3 0 0 0 -1;0 left 1 2 3 1 0 0 0;");
    // A quarter turn, 2 m to the right and 1 m toward the viewer: what stands a metre along the
    // table's −z (the room's −x) from its centre.
    check_rows(READ_WITH(table, HEADER "0,head,1,7,1,0,0.70710678118654752,0,0.70710678118654752\n"
                                       "1,head,2,7,1,0,0,0,1\n"),
               "0 head 0 7 -1 0 0 0 1;1 head 0 7 0 0 -0.707107 0 0.707107;");
}

static void test_columns_by_name(void **unused) {
    (void)unused;
    struct memory_file file =
        memory_text("t_ns,device,px,py,pz,qx,qy,qz,qw,trigger,squeeze,select,note\n"
                    "1,left,1,2,3,0,0,0,1,0.25,1,1, a b \n2,left,1,2,3,0,0,0,1,,,,\n");
    const char *path = file.path, *text;
    size_t len;
    struct ap_poselog_params params = {.sources = &path, .source_count = 1};
    struct ap_poselog *log = NULL;
    struct ap_sample s;
    bool got;
    assert_int_equal(ap_poselog_open(NULL, &params, &log), AP_OK);
    assert_false(ap_poselog_column(log, "note", &text, &len));
    assert_int_equal(ap_poselog_next(NULL, log, &s, &got), AP_OK);
    assert_true(s.trigger == 0.25f && s.squeeze == 1 && s.select);
    assert_true(ap_poselog_column(log, "note", &text, &len));
    assert_true(len == 3 && memcmp(text, "a b", 3) == 0);
    assert_false(ap_poselog_column(log, "nota", &text, &len));
    assert_int_equal(ap_poselog_next(NULL, log, &s, &got), AP_OK);
    assert_true(s.trigger == 0 && s.squeeze == 0 && !s.select);
    assert_true(ap_poselog_column(log, "note", &text, &len) && len == 0);
    ap_poselog_close(log);
    close(file.fd);
}

static uint64_t state = 99;

static double random_number(double scale) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return scale * ((double)(state >> 11) * 0x1p-52 - 1);
}

// Written and read again, every bit is there, and a quaternion that is unit stays as it was.
static void test_round_trip(void **unused) {
    (void)unused;
    enum { COUNT = 2000 };
    static struct ap_sample samples[COUNT];
    struct memory_file file = memory_text("");
    FILE *stream = fdopen(dup(file.fd), "w");
    ap_poselog_write_header(stream);
    for (int i = 0; i < COUNT; i++) {
        struct ap_quat q = {random_number(1), random_number(1), random_number(1), random_number(1)};
        samples[i] =
            (struct ap_sample){.t_ns = i * INT64_C(1234567891234) - 5,
                               .pose = {{random_number(1e-9), random_number(3), random_number(1e8)},
                                        ap_quat_normalize(q)},
                               .trigger = (float)fabs(random_number(1)),
                               .squeeze = (float)fabs(random_number(1e-30)),
                               .select = i & 1,
                               .reset = i % 5 == 2};
        ap_poselog_write_row(stream, "head", &samples[i]);
    }
    assert_int_equal(fclose(stream), 0);
    const char *path = file.path;
    struct ap_poselog_params params = {.sources = &path, .source_count = 1};
    struct ap_poselog *log = NULL;
    bool got = true;
    assert_int_equal(ap_poselog_open(NULL, &params, &log), AP_OK);
    for (int i = 0; i < COUNT; i++) {
        struct ap_sample s;
        assert_int_equal(ap_poselog_next(NULL, log, &s, &got), AP_OK);
        assert_true(got && s.t_ns == samples[i].t_ns && s.select == samples[i].select &&
                    s.reset == samples[i].reset);
        assert_memory_equal(&s.pose, &samples[i].pose, sizeof s.pose);
        assert_true(s.trigger == samples[i].trigger && s.squeeze == samples[i].squeeze);
    }
    ap_poselog_close(log);
    close(file.fd);
}

static void test_many_devices(void **unused) {
    (void)unused;
    static char text[20000] = HEADER;
    size_t n = strlen(text);
    for (int i = 0; i < 257; i++)
        n += (size_t)snprintf(text + n, sizeof text - n, "%d,d%d,0,0,0,0,0,0,1\n", i, i);
    struct reading r = READ_WITH(skipping, text);
    assert_int_equal(r.skipped, 1);
    check_error((struct reading){.status = READ(text).status, .rows = "", .error = "x"}, "", "x");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_formats),
        cmocka_unit_test(test_unknown_formats),
        cmocka_unit_test(test_bad_lines),
        cmocka_unit_test(test_skip_bad),
        cmocka_unit_test(test_long_lines),
        cmocka_unit_test(test_renormalises),
        cmocka_unit_test(test_merge_is_stable),
        cmocka_unit_test(test_roles),
        cmocka_unit_test(test_axes),
        cmocka_unit_test(test_columns_by_name),
        cmocka_unit_test(test_round_trip),
        cmocka_unit_test(test_many_devices),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
