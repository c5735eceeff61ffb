#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "sim_hmd/core/negotiate.h"
#include "sim_hmd/ext/extensions.h"
#include "sim_hmd/strict/strict.h"

// The lists of functions, those that programs get and those that the lint knows, hold the same
// names: a function that one of them lacks would be handed out without a check, and nobody would
// hear of it.

static void nothing(void) {}

// The lint looks at all but this one, which looks at itself.
static bool exempt(const char *name) {
    return strcmp(name, "xrGetInstanceProcAddr") == 0;
}

static int missing_wrapper(const char *name) {
    bool wrapped = sim_strict_wrap(name, nothing) != nothing;
    if (wrapped == !exempt(name))
        return 0;
    fprintf(stderr, "%s: %s\n", name,
            wrapped ? "wrapped, though it is exempt" : "not in strict/functions.inc");
    return 1;
}

#define NAME(name, when) #name,
static const char *const core[] = {SIM_CORE_FUNCTIONS(NAME)};
enum { CORE_COUNT = sizeof core / sizeof *core };

static void every_function_is_looked_at(void **unused) {
    (void)unused;
    int missing = 0, count = 0;
    sim_strict_on = true;
    for (int i = 0; i < CORE_COUNT; i++, count++)
        missing += missing_wrapper(core[i]);
    for (int id = 0; id < SIM_EXTENSION_COUNT; id++)
        for (const struct sim_function *f = sim_extensions[id].functions; f && f->name;
             f++, count++)
            missing += missing_wrapper(f->name);
    sim_strict_on = false;
    printf("%d functions, %d of them without a wrapper\n", count, missing);
    assert_int_equal(missing, 0);
    // What the lint does not know comes through as it is.
    assert_true(sim_strict_wrap("xrNoSuchFunction", nothing) == nothing);
}

static bool offered(const char *name) {
    for (int i = 0; i < CORE_COUNT; i++)
        if (strcmp(core[i], name) == 0)
            return true;
    for (int id = 0; id < SIM_EXTENSION_COUNT; id++)
        for (const struct sim_function *f = sim_extensions[id].functions; f && f->name; f++)
            if (strcmp(f->name, name) == 0)
                return true;
    return false;
}

#define CALL1(f, ...) #f,
#define CALL2(f, ...) #f,
#define CALL3(f, ...) #f,
#define CALL4(f, ...) #f,
#define CALL5(f, ...) #f,
#define CALL6(f, ...) #f,
static const char *const looked_at[] = {
// clang-format off
#include "sim_hmd/strict/functions.inc"
    // clang-format on
};

static void nothing_else_is(void **unused) {
    (void)unused;
    int strangers = 0;
    for (size_t i = 0; i < sizeof looked_at / sizeof *looked_at; i++)
        if (!offered(looked_at[i])) {
            fprintf(stderr, "%s: in strict/functions.inc, and no function of the runtime's\n",
                    looked_at[i]);
            strangers++;
        }
    assert_int_equal(strangers, 0);
}

// While the lint is off nothing stands before a function, but what may switch it on.
static void off_is_off(void **unused) {
    (void)unused;
    sim_strict_on = false;
    for (size_t i = 0; i < sizeof looked_at / sizeof *looked_at; i++) {
        bool wrapped = sim_strict_wrap(looked_at[i], nothing) != nothing;
        if (wrapped != (strcmp(looked_at[i], "xrCreateInstance") == 0))
            fail_msg("%s is%s wrapped", looked_at[i], wrapped ? "" : " not");
    }
}

// Loaders answer for this function themselves; what comes through looks at itself.
static void asking_wrongly_is_told(void **unused) {
    (void)unused;
    char report[] = "/tmp/sim-functions-XXXXXX", text[2048];
    int file = mkstemp(report);
    assert_true(file >= 0);
    PFN_xrVoidFunction function;
    sim_strict_start(report);
    assert_int_equal(xrGetInstanceProcAddr(XR_NULL_HANDLE, NULL, &function),
                     XR_ERROR_VALIDATION_FAILURE);
    assert_int_equal(xrGetInstanceProcAddr(XR_NULL_HANDLE, "xrEndFrame", NULL),
                     XR_ERROR_VALIDATION_FAILURE);
    sim_strict_finish();
    ssize_t n = read(file, text, sizeof text - 1);
    close(file);
    unlink(report);
    assert_true(n > 0);
    text[n] = '\0';
    if (!strstr(text, "VUID-xrGetInstanceProcAddr-name-parameter") ||
        !strstr(text, "VUID-xrGetInstanceProcAddr-function-parameter") ||
        !strstr(text, "{\"errors\":2,"))
        fail_msg("expected both statements and 2 errors, the report says:\n%s", text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_function_is_looked_at),
        cmocka_unit_test(nothing_else_is),
        cmocka_unit_test(off_is_off),
        cmocka_unit_test(asking_wrongly_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
