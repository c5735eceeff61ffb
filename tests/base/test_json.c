#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "src/base/file.h"
#include "src/base/json.h"

static char path[64];

static enum ap_status read_text(struct ap_error *err, const char *text, json_t **root) {
    assert_int_equal(ap_file_write(NULL, path, text, strlen(text)), AP_OK);
    return ap_json_read(err, path, root);
}

static int make_path(void **state) {
    (void)state;
    snprintf(path, sizeof path, "/tmp/antipode-json-%d.json", (int)getpid());
    return 0;
}

static int remove_path(void **state) {
    (void)state;
    return remove(path);
}

static void errors_name_line_and_column(void **state) {
    (void)state;
    struct ap_error err;
    json_t *root;
    assert_int_equal(read_text(&err, "{\"a\": 1,\n \"b\": }", &root), AP_INPUT);
    assert_non_null(strstr(err.text, ".json:2:"));
    assert_int_equal(read_text(&err, "{\"a\": 1, \"a\": 2}", &root), AP_INPUT);
    assert_non_null(strstr(err.text, "duplicate"));
    assert_int_equal(ap_json_read(&err, "/nowhere/x.json", &root), AP_INPUT);
}

static void errors_name_the_place_in_the_document(void **state) {
    (void)state;
    json_t *root;
    assert_int_equal(
        read_text(NULL, "{\"objects\": [{\"ball\": {\"radius_m\": \"big\", \"at\": [1, 2]}}]}",
                  &root),
        AP_OK);
    struct ap_json_at top = ap_json_root(root, "room.json");
    struct ap_json_at objects = ap_json_member(&top, "objects");
    struct ap_json_at object = ap_json_element(&objects, 0);
    struct ap_json_at ball = ap_json_member(&object, "ball");
    struct ap_error err;
    double v, three[3];
    assert_int_equal(ap_json_number(&err, &ball, "radius_m", &v), AP_INPUT);
    assert_string_equal(err.text, "room.json: /objects/0/ball/radius_m: expected a number");
    assert_int_equal(ap_json_numbers(&err, &ball, "at", 3, three), AP_INPUT);
    assert_string_equal(err.text, "room.json: /objects/0/ball/at: expected an array of 3 numbers");
    static const char *const known[] = {"radius_m", "color", NULL};
    assert_int_equal(ap_json_check_keys(&err, &ball, known), AP_INPUT);
    assert_string_equal(err.text,
                        "room.json: /objects/0/ball/at: unknown key; known here: radius_m, color");
    assert_int_equal(ap_json_check_keys(&err, &objects, known), AP_INPUT);
    json_decref(root);
}

static void numbers_must_be_finite_and_typed(void **state) {
    (void)state;
    json_t *root;
    assert_int_equal(
        read_text(NULL, "{\"n\": 3, \"s\": \"x\", \"b\": true, \"v\": [1, 2.5]}", &root), AP_OK);
    struct ap_json_at top = ap_json_root(root, "f");
    double n = 0, v[2] = {0};
    bool b = false;
    const char *s = NULL;
    assert_int_equal(ap_json_number(NULL, &top, "n", &n), AP_OK);
    assert_int_equal(ap_json_string(NULL, &top, "s", &s), AP_OK);
    assert_int_equal(ap_json_bool(NULL, &top, "b", &b), AP_OK);
    assert_int_equal(ap_json_numbers(NULL, &top, "v", 2, v), AP_OK);
    assert_true(n == 3 && b && v[1] == 2.5);
    assert_string_equal(s, "x");
    assert_int_equal(ap_json_bool(NULL, &top, "n", &b), AP_INPUT);
    assert_int_equal(ap_json_string(NULL, &top, "absent", &s), AP_INPUT);
    assert_true(ap_json_has(&top, "n") && !ap_json_has(&top, "absent"));
    json_decref(root);
    assert_int_equal(read_text(NULL, "{\"n\": 1e999}", &root), AP_INPUT);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(errors_name_line_and_column),
        cmocka_unit_test(errors_name_the_place_in_the_document),
        cmocka_unit_test(numbers_must_be_finite_and_typed),
    };
    return cmocka_run_group_tests(tests, make_path, remove_path);
}
