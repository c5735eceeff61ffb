#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdlib.h>

#include "sim_hmd/core/handles.h"

static int freed;

static void count_and_free(struct sim_object *object) {
    freed++;
    free(object);
}

static struct sim_object *add(enum sim_type type, struct sim_object *parent) {
    struct sim_object *o = calloc(1, sizeof *o);
    assert_non_null(o);
    assert_true(sim_object_add(o, type, parent, count_and_free));
    return o;
}

static void a_tree_goes_with_its_root(void **state) {
    (void)state;
    freed = 0;
    struct sim_object *root = add(SIM_INSTANCE, NULL);
    struct sim_object *set = add(SIM_ACTION_SET, root);
    for (int i = 0; i < 100; i++)
        add(SIM_ACTION, set);
    struct sim_object *session = add(SIM_SESSION, root);
    add(SIM_SPACE, session);
    sim_object_destroy(set->first_child->next); // one in the middle
    assert_int_equal(freed, 1);
    assert_int_equal(sim_object_count(), 103);
    sim_object_destroy(session);
    assert_int_equal(freed, 3);
    sim_object_destroy(root);
    assert_int_equal(freed, 104);
    assert_int_equal(sim_object_count(), 0);
}

static void old_handles_stay_dead(void **state) {
    (void)state;
    uint64_t old[300];
    for (int i = 0; i < 300; i++) {
        struct sim_object *o = add(i & 1 ? SIM_SPACE : SIM_SESSION, NULL);
        old[i] = o->handle;
        assert_ptr_equal(sim_object_get(o->handle, o->type), o);
        assert_null(sim_object_get(o->handle, SIM_SWAPCHAIN));
        for (int j = 0; j < i; j++) {
            assert_null(sim_object_get(old[j], SIM_SPACE));
            assert_null(sim_object_get(old[j], SIM_SESSION));
        }
        sim_object_destroy(o);
    }
    assert_null(sim_object_get(0, SIM_INSTANCE));
    assert_null(sim_object_get(UINT64_MAX, SIM_INSTANCE));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_tree_goes_with_its_root),
        cmocka_unit_test(old_handles_stay_dead),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
