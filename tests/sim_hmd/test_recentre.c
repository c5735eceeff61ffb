#include <math.h>
#include <stdio.h>

#include "tests/sim_hmd/client.h"

// Recentring at the settings' times; times in the past and the future.

// The head walks along x at 1 m/s, turned by 0.5 rad about y, from 0 to 2 s of the log.
static void write_log(void) {
    static char text[20000];
    size_t n = (size_t)sprintf(text, "t_ns,device,px,py,pz,qx,qy,qz,qw\n");
    for (int k = 0; k <= 200; k++)
        n += (size_t)sprintf(text + n, "%d0000000,head,%.2f,1.6,0,0,0.247403959,0,0.968912422\n", k,
                             0.01 * k);
    client_file("head.csv", text);
}

static XrSpaceLocation locate(XrSpace space, XrSpace base, XrTime time) {
    XrSpaceLocation at = {.type = XR_TYPE_SPACE_LOCATION};
    XR_OK(xrLocateSpace(space, base, time, &at));
    return at;
}

static void x_is(XrSpaceLocation at, double expected, const char *what) {
    if (!at.locationFlags || !(fabs(at.pose.position.x - expected) <= 1e-6))
        fail_msg("%s: x is %.9g, expected %.9g ± 1e-6", what, (double)at.pose.position.x, expected);
}

static void local_moves_and_says_so(void **state) {
    (void)state;
    write_log();
    client_settings("{\"poses\": {\"logs\": [\"head.csv\"]}, \"clock\": \"virtual\", "
                    "\"refresh_hz\": 10, \"recentre_s\": [0.35, 1.0]}");
    struct client c = {0};
    client_start(&c);
    XrTime times[4];
    int n = 0;
    for (int frame = 0; frame < 12; frame++) {
        XrTime now = client_wait(&c).predictedDisplayTime;
        XrEventDataBuffer event = {.type = XR_TYPE_EVENT_DATA_BUFFER};
        while (xrPollEvent(c.instance, &event) == XR_SUCCESS) {
            if (event.type == XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING) {
                XrEventDataReferenceSpaceChangePending *change = (void *)&event;
                assert_int_equal(change->referenceSpaceType, XR_REFERENCE_SPACE_TYPE_LOCAL);
                assert_true(change->session == c.session && change->poseValid);
                assert_int_equal(change->changeTime, now);
                // LOCAL is turned with the head: what it moved by lies along both axes.
                double by = n ? 0.6 : 0.4; // frames at 0.4 s and 1.0 s
                assert_true(fabs(change->poseInPreviousSpace.position.x - by * cos(0.5)) < 1e-6);
                assert_true(fabs(change->poseInPreviousSpace.position.z - by * sin(0.5)) < 1e-6);
                assert_true(n < 4);
                times[n++] = change->changeTime;
            }
            event.type = XR_TYPE_EVENT_DATA_BUFFER;
        }
        client_begin(&c);
        client_end_empty(&c, now);
    }
    assert_int_equal(n, 2);
    assert_int_equal(times[0], 1400000000);
    x_is(locate(c.local, c.stage, times[0] - 1), 0, "LOCAL before the first change");
    x_is(locate(c.local, c.stage, times[0]), 0.4, "LOCAL after the first change");
    x_is(locate(c.local, c.stage, times[1] - 1), 0.4, "LOCAL before the second change");
    x_is(locate(c.local, c.stage, times[1] + 500000000), 1.0, "LOCAL after the second change");
    client_stop(&c);
}

static void other_times_can_be_asked_for(void **state) {
    (void)state;
    write_log();
    client_settings("{\"poses\": {\"logs\": [\"head.csv\"]}, \"clock\": \"virtual\", "
                    "\"refresh_hz\": 10}");
    struct client c = {0};
    client_start(&c);
    for (int frame = 0; frame < 15; frame++) {
        XrTime now = client_wait(&c).predictedDisplayTime;
        client_begin(&c);
        client_end_empty(&c, now);
        if (frame < 12)
            continue;
        // The virtual clock's frame is at 1 s + frame/10.
        double x = (double)(now - 1000000000) * 1e-9;
        x_is(locate(c.view, c.stage, now), x, "now");
        x_is(locate(c.view, c.stage, now - 1100000000), x - 1.1, "more than a second ago");
        x_is(locate(c.view, c.stage, now + 300000000), x + 0.3, "later");
    }
    // Beyond the recording the last pose stays, untracked; nothing overflows.
    XrSpaceLocation at = locate(c.view, c.stage, INT64_MAX);
    assert_false(at.locationFlags & XR_SPACE_LOCATION_POSITION_TRACKED_BIT);
    locate(c.view, c.stage, 1);
    client_stop(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(local_moves_and_says_so, client_teardown),
        cmocka_unit_test_teardown(other_times_can_be_asked_for, client_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
