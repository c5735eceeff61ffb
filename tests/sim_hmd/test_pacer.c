#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "sim_hmd/core/pacer.h"

static void virtual_time_does_not_look_at_the_clock(void **state) {
    (void)state;
    struct sim_pacer p;
    sim_pacer_init(&p, SIM_CLOCK_VIRTUAL, 90, 12345);
    // round(k·1e9/90): 11111111, 22222222, 33333333, 44444444, 55555556.
    const int64_t expected[] = {1000000000, 1011111111, 1022222222,
                                1033333333, 1044444444, 1055555556};
    for (int k = 0; k < 6; k++) {
        struct sim_prediction f = sim_pacer_next(&p, 777 * k);
        assert_int_equal(f.index, k);
        assert_int_equal(f.display_ns, expected[k]);
        assert_int_equal(f.wake_machine_ns, INT64_MIN);
        assert_int_equal(sim_pacer_now(&p, 999999999999), expected[k]);
    }
}

static void a_late_program_skips_places_of_the_grid(void **state) {
    (void)state;
    struct sim_pacer p;
    const int64_t ms = 1000000, epoch = 5000 * ms;
    sim_pacer_init(&p, SIM_CLOCK_REAL, 100, epoch);
    struct sim_prediction f = sim_pacer_next(&p, epoch + 3 * ms);
    assert_int_equal(f.display_ns, 1000 * ms + 13 * ms); // a period from now
    assert_int_equal(f.wake_machine_ns, epoch + 3 * ms);
    f = sim_pacer_next(&p, epoch + 4 * ms); // early: wakes a period before the next place
    assert_int_equal(f.display_ns, 1023 * ms);
    assert_int_equal(f.wake_machine_ns, epoch + 13 * ms);
    f = sim_pacer_next(&p, epoch + 61 * ms); // late: places 3…5 are past
    assert_int_equal(f.display_ns, 1063 * ms);
    assert_true(f.wake_machine_ns <= epoch + 61 * ms);
    assert_int_equal(f.index, 2);
    assert_int_equal(f.missed, 3); // places 2, 3 and 4: the one before was 1
    int64_t last = f.display_ns;
    for (int64_t now = 61; now < 1000; now += 7) { // never back, never in the past, on the grid
        f = sim_pacer_next(&p, epoch + now * ms);
        assert_true(f.display_ns > last);
        assert_true(f.display_ns > 1000 * ms + now * ms);
        assert_int_equal((f.display_ns - 1013 * ms) % (10 * ms), 0);
        last = f.display_ns;
    }
}

static void a_new_rate_starts_at_the_last_frame(void **state) {
    (void)state;
    struct sim_pacer p;
    sim_pacer_init(&p, SIM_CLOCK_VIRTUAL, 90, 0);
    sim_pacer_set_rate(&p, 100); // before the first frame: as if made so
    assert_int_equal(sim_pacer_next(&p, 0).display_ns, 1000000000);
    assert_int_equal(sim_pacer_next(&p, 0).display_ns, 1010000000);
    sim_pacer_set_rate(&p, 120);
    struct sim_prediction f = sim_pacer_next(&p, 0);
    assert_int_equal(f.display_ns, 1018333333);
    assert_int_equal(f.period_ns, 8333333);
    assert_int_equal(f.index, 2);
    assert_int_equal(sim_pacer_next(&p, 0).display_ns, 1026666667);
    const int64_t ms = 1000000;
    sim_pacer_init(&p, SIM_CLOCK_REAL, 100, 0);
    assert_int_equal(sim_pacer_next(&p, 3 * ms).display_ns, 1013 * ms);
    sim_pacer_set_rate(&p, 50);
    assert_int_equal(sim_pacer_next(&p, 4 * ms).display_ns, 1033 * ms);
    assert_int_equal(sim_pacer_next(&p, 60 * ms).display_ns, 1073 * ms); // late
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(virtual_time_does_not_look_at_the_clock),
        cmocka_unit_test(a_late_program_skips_places_of_the_grid),
        cmocka_unit_test(a_new_rate_starts_at_the_last_frame),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
