// clang-format off
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
// clang-format on
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "src/base/file.h"
#include "tests/app/page/synth.h"

static const uint8_t RED[3] = {0xff, 0x20, 0x20};

// The files of a capture, without pictures.
static char *make(struct ap_capture *c) {
    char *dir = synth_folder();
    *c = synth_capture(dir, (struct ap_space){-1, 0.85}, AP_VIEW_TOURIST, 6);
    synth_target(c, "lamp <1>", RED, (struct ap_vec3){0, 0.1, -0.8}, 0.05);
    snprintf(c->log_name, sizeof c->log_name, "walk \xff.csv");
    snprintf(c->command, sizeof c->command, "antipode replay walk.csv");
    c->background[1] = 0x1f;
    c->interrupted = true;
    size_t frames = c->frame_count;
    c->frame_count = 0; // no pictures…
    synth_write(c);
    c->frame_count = frames;
    assert_int_equal(ap_capture_write(NULL, dir, c), AP_OK); // …but in the list
    return dir;
}

static void what_is_written_is_read(void **state) {
    (void)state;
    struct ap_capture c, r;
    struct ap_error err = {""};
    char *dir = make(&c);
    if (ap_capture_read(&err, dir, &r))
        fail_msg("%s", err.text);
    assert_int_equal(r.space.kappa, -1);
    assert_true(r.space.rho_m == 0.85 && r.view == AP_VIEW_TOURIST && r.interrupted);
    assert_string_equal(r.tracker, "billiards");
    assert_string_equal(r.log_name, "walk ?.csv"); // JSON holds no other than UTF-8
    assert_string_equal(r.command, "antipode replay walk.csv");
    assert_true(r.has_table && r.table_edge_m == 0.9 && r.table_height_m == 0.75);
    assert_int_equal(r.background[1], 0x1f);
    assert_memory_equal(&r.headset.eye, &c.headset.eye, sizeof c.headset.eye);
    assert_int_equal(r.target_count, 1);
    assert_string_equal(r.targets[0].name, "lamp <1>");
    assert_memory_equal(&r.targets[0].at, &c.targets[0].at, sizeof r.targets[0].at);
    assert_int_equal(r.total_frames, 6);
    assert_int_equal(r.frame_count, 3);
    for (size_t i = 0; i < 3; i++) {
        assert_int_equal(r.frames[i].frame, 2 * i);
        assert_int_equal(r.frames[i].t_ns, c.frames[i].t_ns);
        assert_memory_equal(&r.frames[i].world_from_head, &c.frames[i].world_from_head,
                            sizeof r.frames[i].world_from_head);
    }
    assert_int_equal(r.device_count, 2);
    assert_int_equal(r.step_count, 12);
    assert_string_equal(r.devices[1], "right");
    ap_capture_finish(&r);
    ap_capture_finish(&c);
    synth_remove(dir);
}

static void writing_repeats(void **state) {
    (void)state;
    struct ap_capture c;
    char *dir = make(&c), *first = synth_read_text(dir, "capture.json");
    assert_int_equal(ap_capture_write(NULL, dir, &c), AP_OK);
    char *second = synth_read_text(dir, "capture.json");
    assert_string_equal(first, second);
    free(first);
    free(second);
    ap_capture_finish(&c);
    synth_remove(dir);
}

// One line, the file's name in it, and the words given.
static void expect_error(const char *dir, const char *file, const char *words) {
    struct ap_capture r;
    struct ap_error err = {""};
    enum ap_status st = ap_capture_read(&err, dir, &r);
    if (st != AP_INPUT || strchr(err.text, '\n') || !strstr(err.text, file) ||
        !strstr(err.text, words))
        fail_msg("status %d, \"%s\"; expected 3 and \"%s\" … \"%s\"", st, err.text, file, words);
}

// Replaces the first `from` in the file by `to` (at least as long a string may come out).
static char *replaced(const char *text, const char *from, const char *to) {
    const char *at = strstr(text, from);
    if (!at)
        fail_msg("no \"%s\" in the file", from);
    size_t size = strlen(text) + strlen(to) + 1;
    char *made = malloc(size);
    assert_non_null(made);
    snprintf(made, size, "%.*s%s%s", (int)(at - text), text, to, at + strlen(from));
    return made;
}

struct breakage {
    const char *from, *to, *words;
};

static void check_breakages(const char *file, const struct breakage *b, size_t n) {
    struct ap_capture c;
    char *dir = make(&c), *good = synth_read_text(dir, file);
    for (size_t i = 0; i < n; i++) {
        char *bad = replaced(good, b[i].from, b[i].to);
        synth_write_text(dir, file, bad);
        expect_error(dir, file, b[i].words);
        free(bad);
    }
    free(good);
    ap_capture_finish(&c);
    synth_remove(dir);
}

static void broken_json_is_refused(void **state) {
    (void)state;
    static const struct breakage b[] = {
        {"{", "[", "not JSON"},
        {"\"antipode_capture\": 1", "\"antipode_capture\": 2", "/antipode_capture"},
        {"\"view\"", "\"veiw\"", "/veiw"},
        {"\"h3\"", "\"h4\"", "/space"},
        {"\"tourist\"", "\"local\"", "/view"},
        {"\"radius_m\": 0.8", "\"radius_m\": -0.8", "/radius_m"},
        {"\"total\": 6", "\"total\": 4", "/frames/captured/2"},
        {"\"total\": 6", "\"total\": -6", "/frames/total"},
        {"\"total\": 6", "\"total\": 6.5", "/frames/total"},
        {"\n   2,", "\n   0,", "/frames/captured/1"},
        {"#ff2020", "#ff20200", "/targets/0/color"},
        {"#ff2020", "red", "/targets/0/color"},
        {"\"interrupted\": true", "\"interrupted\": 1", "/interrupted"},
        {"\"at\": [", "\"at\": [1e300, ", "/targets/0/at"},
        {"\"billiards\"", "\"billiards, the game of kings\"", "/tracker"},
        {"\"targets\": [", "\"targets\": 7, \"x\": [", "/x"},
    };
    check_breakages("capture.json", b, sizeof b / sizeof b[0]);
}

// A hand whose tracker had no head yet has a row without a matrix, which makes no step.
static void rows_without_a_virtual_pose_are_skipped(void **state) {
    (void)state;
    struct ap_capture c, r;
    char *dir = make(&c), *good = synth_read_text(dir, "frames.csv");
    char *more = replaced(good, "\n0,1000,head",
                          "\n0,1000,left,exact,0,0,0,0,0,0,1,,,,,,,,,,,,,,,,"
                          "\n0,1000,head");
    synth_write_text(dir, "frames.csv", more);
    struct ap_error err = {""};
    if (ap_capture_read(&err, dir, &r))
        fail_msg("%s", err.text);
    assert_int_equal(r.frame_count, 3);
    assert_int_equal(r.step_count, 12);
    assert_int_equal(r.device_count, 2);
    ap_capture_finish(&r);
    free(good);
    free(more);
    ap_capture_finish(&c);
    synth_remove(dir);
}

static void broken_rows_are_refused(void **state) {
    (void)state;
    static const struct breakage b[] = {
        {"frame,t_ns", "t_ns,frame", ":1:"},
        {",head,", ",,", ":2: field 3"},
        {",exact,", ",wild,", ":2: field 4"},
        {",exact,", ",exact,nan,", ":2: expected 27 fields, found 28"},
        {",exact,", ",exact", ":2: expected 27 fields, found 26"},
        {",exact,0,", ",exact,nan,", ":2: field 5"},
        {",exact,0,", ",exact,1e999,", ":2: field 5"},
        {"\n0,1000,head", "\n0,1000,left,exact,0,0,0,0,0,0,1,,,,,,,,,,,,,,,,1.5.2\n0,1000,head",
         ":2: field 27"},
        {"\n0,", "\n-1,", ":2: field 1"},
        {"\n0,", "\n5,", ":3: field 1"},
        {"\n0,1000", "\n0,1000.5", ":2: field 2"},
        // A matrix that is no isometry: the last entry ten times as large.
        {"\n0,1000,right", "e1\n0,1000,right", ":2: the matrix is no isometry"},
    };
    check_breakages("frames.csv", b, sizeof b / sizeof b[0]);
}

static void long_and_empty_files_are_refused(void **state) {
    (void)state;
    struct ap_capture c;
    char *dir = make(&c), *text = malloc(10001);
    assert_non_null(text);
    memset(text, 'x', 10000);
    text[10000] = '\0';
    synth_write_text(dir, "frames.csv", text);
    expect_error(dir, "frames.csv", "too long");
    free(text);
    synth_write_text(dir, "frames.csv", "");
    expect_error(dir, "frames.csv", "empty");
    char *path = synth_path(dir, "frames.csv");
    unlink(path);
    free(path);
    expect_error(dir, "frames.csv", "cannot be read");
    path = synth_path(dir, "capture.json");
    unlink(path);
    free(path);
    expect_error(dir, dir, "no capture here");
    ap_capture_finish(&c);
    synth_remove(dir);
}

static void eyes_are_rounded_as_the_runtime_rounds(void **state) {
    (void)state;
    struct ap_capture c;
    char *dir = make(&c);
    struct ap_viewer v = ap_capture_viewer(&c, 1);
    assert_true(v.eye[0].view_from_eye.p.x == -(double)(float)0.032);
    assert_true(v.eye[1].frustum.right == tan((double)(float)0.75));
    assert_memory_equal(&v.world_from_nose, &c.frames[1].world_from_head, sizeof v.world_from_nose);
    ap_capture_finish(&c);
    synth_remove(dir);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_written_is_read),
        cmocka_unit_test(writing_repeats),
        cmocka_unit_test(broken_json_is_refused),
        cmocka_unit_test(rows_without_a_virtual_pose_are_skipped),
        cmocka_unit_test(broken_rows_are_refused),
        cmocka_unit_test(long_and_empty_files_are_refused),
        cmocka_unit_test(eyes_are_rounded_as_the_runtime_rounds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
