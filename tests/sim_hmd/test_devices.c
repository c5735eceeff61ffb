#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "tests/sim_hmd/client.h"

// Live devices as the source of poses, with a recording that is played as one: what an OpenXR
// program is told of the head while it turns, after it is unplugged, and where there is no device.

enum { REPORTS = 600, HZ = 200 };
static const double RATE_RAD_S = 0.8;

static char *put_word(char *at, double x) {
    int value = (int)lround(x * 32767);
    return at + sprintf(at, " %02x %02x", (unsigned)(value & 255), (unsigned)(value >> 8 & 255));
}

// A SlimeVR receiver whose tracker turns about the vertical at 0.8 rad/s for 3 s.
static void write_recording(void) {
    char *text = malloc(400 * REPORTS), *at = text;
    assert_non_null(text);
    at += sprintf(at, "D: 0\nR: 15 05 01 09 00 a1 01 09 00 75 08 95 40 81 02 c0\n"
                      "N: SlimeVR receiver\nP: \nI: 3 1209 7690\n");
    for (int i = 0; i < REPORTS; i++) {
        double h = RATE_RAD_S * i / HZ / 2, r = sqrt(0.5);
        const double q[4] = {r * cos(h), r * sin(h), r * sin(h), r * cos(h)};
        at += sprintf(at, "E: %06d.%06d 64 ff 05 11", i / HZ, i % HZ * (1000000 / HZ));
        for (int k = 3; k < 16; k++)
            at += sprintf(at, " 00");
        for (int packet = 0; packet < 3; packet++) {
            at += sprintf(at, " 01 05");
            for (int k = 0; k < 4; k++)
                at = put_word(at, q[k]);
            at += sprintf(at, " 00 00 00 00 00 00");
        }
        *at++ = '\n';
    }
    *at = 0;
    client_file("head.hid", text);
    free(text);
}

static XrSpaceLocation head_at(const struct client *c, XrTime time) {
    XrSpaceLocation at = {.type = XR_TYPE_SPACE_LOCATION};
    XR_OK(xrLocateSpace(c->view, c->stage, time, &at));
    return at;
}

static double yaw_of(XrQuaternionf q) {
    return 2 * atan2((double)q.y, (double)q.w);
}

static bool is_tracked(XrSpaceLocation at) {
    return at.locationFlags & XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT;
}

static int by_size(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void the_head_turns_and_goes(void **state) {
    (void)state;
    write_recording();
    client_settings("{\"poses\": {\"devices\": [\"head=slimevr\"], \"replay\": [\"head.hid\"], "
                    "\"stats\": true}, \"refresh_hz\": 50}");
    struct client c = {0};
    client_start(&c);
    // Seen, and then not for 0.3 s: a machine that stands still for a moment loses it, too.
    XrTime first = 0, seen_ns = 0, now = 0;
    double first_yaw = 0;
    static double errors[400];
    size_t count = 0;
    for (int frame = 0; frame < 400 && (!seen_ns || now - seen_ns < 300000000); frame++) {
        now = client_wait(&c).predictedDisplayTime;
        client_begin(&c);
        XrSpaceLocation at = head_at(&c, now);
        client_end_empty(&c, now);
        if (!is_tracked(at))
            continue;
        if (!seen_ns) {
            first = now;
            first_yaw = yaw_of(at.pose.orientation);
        }
        seen_ns = now;
        errors[count++] = fabs(yaw_of(at.pose.orientation) - first_yaw -
                               RATE_RAD_S * (double)(now - first) * 1e-9);
        // The neck model's: 8 cm above and before 1.5 m.
        assert_true(fabs((double)at.pose.position.y - 1.58) < 1e-3);
    }
    qsort(errors, count, sizeof *errors, by_size);
    double middle = errors[count / 2], worst = errors[count ? count - 1 : 0];
    printf("yaw within %.4f rad of what it was turned by (worst %.4f), over %.2f s\n", middle,
           worst, (double)(seen_ns - first) * 1e-9);
    assert_true(seen_ns - first > 1500000000);
    // A prediction ends after 40 ms and is lost after 100: 0.08 rad.
    if (!(middle < 0.01 && worst < 0.1))
        fail_msg("the head is %.4f rad off, %.4f at worst; allowed 0.01 and 0.1", middle, worst);
    assert_true(now - seen_ns >= 300000000); // the recording's end unplugs it
    client_stop(&c);
}

static void nobody_is_nowhere(void **state) {
    (void)state;
    write_recording();
    // The only device has another role, so the head is nobody.
    client_settings("{\"poses\": {\"devices\": [\"cue=slimevr\"], \"replay\": [\"head.hid\"]}, "
                    "\"refresh_hz\": 50}");
    struct client c = {0};
    client_start(&c);
    for (int frame = 0; frame < 3; frame++) {
        XrTime now = client_wait(&c).predictedDisplayTime;
        client_begin(&c);
        assert_false(is_tracked(head_at(&c, now)));
        client_end_empty(&c, now);
    }
    client_stop(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_head_turns_and_goes),
        cmocka_unit_test(nobody_is_nowhere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
