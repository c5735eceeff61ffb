#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>

#include "src/app/play/body.h"

// Where a visitor of `play` is in a world of cells.

static struct ap_frame_input step(struct ap_body *body, struct ap_pose head, int64_t t_ns) {
    struct ap_error err = {""};
    struct ap_xr_frame frame = {.time_ns = t_ns, .head = {true, true, head}};
    struct ap_frame_input input = {.viewer = {.world_from_nose = AP_ISO_IDENTITY}};
    if (ap_body_step(&err, body, &frame, false, &input))
        fail_msg("%s", err.text);
    return input;
}

static double from_middle_m(const struct ap_room *room, const struct ap_frame_input *input) {
    struct ap_vec4 base = {0, 0, 0, room->scene->space.rho_m};
    struct ap_vec4 at = ap_iso_apply(&input->viewer.world_from_nose, base);
    return ap_vec3_length(ap_log_unchecked(room->scene->space, at, 0));
}

// However high her head, she begins in the middle of a cell, upright as she is; from there she goes
// as far as she walks. At a table nothing of the kind happens.
static void visitors_begin_in_the_middle(void **state) {
    (void)state;
    static const char *const scenes[] = {"torus", "honeycomb:5,3,4", "honeycomb:5,3,3,struts",
                                         "mirrored-dodecahedron"};
    for (int s = 0; s < 5; s++) {
        struct ap_error err = {""};
        struct ap_room_options options = AP_ROOM_OPTIONS_NONE;
        struct ap_room room;
        struct ap_body body;
        options.scene = s < 4 ? scenes[s] : NULL;
        assert_int_equal(ap_room_open(&err, &options, &room), AP_OK);
        assert_int_equal(ap_body_init(&err, &room, &body), AP_OK);
        struct ap_pose head = {{0.2, 1.63, 0.4},
                               ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, 0.3)};
        struct ap_frame_input input = step(&body, head, 1000000000);
        double begins_m = from_middle_m(&room, &input);
        for (int k = 1; k <= 30; k++) {
            head.p.z -= 0.01;
            input = step(&body, head, 1000000000 + k * 11111111);
        }
        double went_m = from_middle_m(&room, &input);
        print_message("%s: begins %.2g m from the middle, after 0.3 m at %.6f m\n",
                      s < 4 ? scenes[s] : "the table", begins_m, went_m);
        if (s < 4 ? !(begins_m < 1e-12) || !(fabs(went_m - 0.3) < 1e-12) : !(begins_m > 0.5))
            fail_msg("%g m and %g m, expected 0 and 0.3 (at the table more than 0.5)", begins_m,
                     went_m);
        ap_room_close(&room);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(visitors_begin_in_the_middle)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
