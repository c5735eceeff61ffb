#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include <dirent.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "src/base/file.h"

static char dir[64];

static int make_dir(void **state) {
    (void)state;
    snprintf(dir, sizeof dir, "/tmp/antipode-test-XXXXXX");
    return mkdtemp(dir) ? 0 : -1;
}

static int count_entries(void) {
    DIR *d = opendir(dir);
    int n = 0;
    for (struct dirent *e = readdir(d); e; e = readdir(d))
        n += strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0;
    closedir(d);
    return n;
}

static int remove_dir(void **state) {
    (void)state;
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s", dir);
    return system(command);
}

static void commit_gives_the_name_and_abort_leaves_nothing(void **state) {
    (void)state;
    char *path = ap_path_join(dir, "a.txt");
    struct ap_outfile f;
    assert_int_equal(ap_outfile_open(NULL, path, &f), AP_OK);
    fputs("half", f.stream);
    fflush(f.stream);
    assert_false(ap_file_exists(path));
    ap_outfile_abort(&f);
    assert_int_equal(count_entries(), 0);
    ap_outfile_abort(&f); // a finished one is left alone

    assert_int_equal(ap_file_write(NULL, path, "whole", 5), AP_OK);
    char *bytes;
    size_t len;
    assert_int_equal(ap_file_read(NULL, path, 5, &bytes, &len), AP_OK);
    assert_int_equal(len, 5);
    assert_string_equal(bytes, "whole");
    free(bytes);
    struct ap_error err;
    assert_int_equal(ap_file_read(&err, path, 4, &bytes, &len), AP_INPUT);
    assert_non_null(strstr(err.text, "larger than 4"));
    remove(path);
    free(path);
}

static void a_full_disk_keeps_the_old_file(void **state) {
    (void)state;
    char *path = ap_path_join(dir, "b.txt");
    assert_int_equal(ap_file_write(NULL, path, "old", 3), AP_OK);
    struct rlimit before, tiny;
    getrlimit(RLIMIT_FSIZE, &before);
    tiny = (struct rlimit){1000, before.rlim_max};
    signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &tiny);
    char *large = calloc(1, 100000);
    struct ap_error err = {""};
    enum ap_status st = ap_file_write(&err, path, large, 100000);
    setrlimit(RLIMIT_FSIZE, &before);
    free(large);
    assert_int_equal(st, AP_ENVIRONMENT);
    assert_non_null(strstr(err.text, "b.txt: cannot be written: "));
    char *bytes;
    size_t len;
    assert_int_equal(ap_file_read(NULL, path, 100, &bytes, &len), AP_OK);
    assert_string_equal(bytes, "old");
    free(bytes);
    assert_int_equal(count_entries(), 1);
    remove(path);
    free(path);
}

// A name would otherwise be given to a file in the place of what stands there: of /dev/null…
static void what_is_no_file_is_not_replaced(void **state) {
    (void)state;
    char path[256], folder[256];
    struct ap_error err = {""};
    struct ap_outfile file;
    snprintf(folder, sizeof folder, "%s/thing", dir);
    snprintf(path, sizeof path, "%s/thing/", dir);
    assert_int_equal(mkfifo(folder, 0600), 0);
    assert_int_equal(ap_outfile_open(&err, folder, &file), AP_ENVIRONMENT);
    assert_non_null(strstr(err.text, "thing: is no plain file"));
    unlink(folder);
    assert_int_equal(mkdir(folder, 0700), 0);
    assert_int_equal(ap_outfile_open(&err, folder, &file), AP_ENVIRONMENT);
    assert_int_equal(ap_outfile_open(&err, path, &file), AP_ENVIRONMENT);
    assert_int_equal(ap_outfile_open(&err, "", &file), AP_ENVIRONMENT);
    assert_int_equal(rmdir(folder), 0); // nothing was left in it
}

static void folders_are_made_and_errors_name_the_place(void **state) {
    (void)state;
    char *deep = ap_path_join(dir, "x/y/z");
    assert_int_equal(ap_make_dirs(NULL, deep), AP_OK);
    assert_int_equal(ap_make_dirs(NULL, deep), AP_OK);
    char *file = ap_path_join(deep, "f");
    assert_int_equal(ap_file_write(NULL, file, "", 0), AP_OK);
    char *under = ap_path_join(file, "g");
    struct ap_error err;
    assert_int_equal(ap_make_dirs(&err, under), AP_ENVIRONMENT);
    assert_non_null(strstr(err.text, "cannot be made"));
    assert_int_equal(ap_file_write(&err, under, "", 0), AP_ENVIRONMENT);
    free(deep);
    free(file);
    free(under);
}

static void error_texts_are_one_line(void **state) {
    (void)state;
    struct ap_error err;
    assert_int_equal(ap_fail(&err, AP_INPUT, "a\nb\x1b%s", "c"), AP_INPUT);
    assert_string_equal(err.text, "a?b?c");
    assert_int_equal(ap_fail(&err, AP_USAGE, "again: %s", err.text), AP_USAGE);
    assert_string_equal(err.text, "again: a?b?c");
    assert_int_equal(ap_fail(NULL, AP_USAGE, "x"), AP_USAGE);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(commit_gives_the_name_and_abort_leaves_nothing),
        cmocka_unit_test(a_full_disk_keeps_the_old_file),
        cmocka_unit_test(what_is_no_file_is_not_replaced),
        cmocka_unit_test(folders_are_made_and_errors_name_the_place),
        cmocka_unit_test(error_texts_are_one_line),
    };
    return cmocka_run_group_tests(tests, make_dir, remove_dir);
}
