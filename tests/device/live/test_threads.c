#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "src/device/live/live.h"
#include "tests/device/live/devices.h"

// Frame loops ask, somebody looks at the table and recentres, a listener listens, while devices
// report, come and go. ThreadSanitizer looks on; here every answer has to be a pose.

enum { ASKERS = 3, DEVICES = 4, ROUNDS = 150 };
static const int64_t MS = 1000000, START_NS = 1000000000;

struct play {
    struct fake_bus *fake;
    struct ap_live *live;
    atomic_bool over;
    atomic_llong asked, seen, wrong, told;
};

static bool is_pose(const struct ap_live_answer *a) {
    struct ap_quat q = a->pose.q;
    double square = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
    return fabs(square - 1) < 1e-9 && ap_vec3_length(a->pose.p) < 10 && a->trigger >= 0 &&
           a->trigger <= 1;
}

static void *ask(void *arg) {
    struct play *p = arg;
    while (!atomic_load(&p->over)) {
        int64_t now_ns = ap_live_now_ns(p->live);
        for (int role = 0; role < ap_live_role_count(p->live); role++) {
            struct ap_live_answer a = ap_live_at(p->live, role, now_ns + (role % 3 - 1) * 10 * MS);
            atomic_fetch_add(&p->asked, 1);
            atomic_fetch_add(&p->seen, a.state != AP_POSE_NONE);
            atomic_fetch_add(&p->wrong, !is_pose(&a));
        }
    }
    return NULL;
}

static void *look(void *arg) {
    struct play *p = arg;
    static struct ap_live_device d;
    while (!atomic_load(&p->over)) {
        for (int i = 0; i < ap_live_device_count(p->live); i++) {
            ap_live_device_at(p->live, i, &d);
            atomic_fetch_add(&p->wrong, d.tracker_count > 1 || d.reports < 0);
        }
        ap_live_recentre(p->live);
    }
    return NULL;
}

static void on_pose(void *user, const struct ap_live_pose_row *row) {
    struct play *p = user;
    atomic_fetch_add(&p->told, row->t_ns > 0);
}

static void play_round(struct play *p, const int *devices, int round) {
    fake_set_now(p->fake, START_NS + round * 10 * MS);
    for (int i = 0; i < DEVICES; i++)
        send_slimevr(p->fake, devices[i], 0.01 * round, round % 20 == 0 ? 2 : 0);
    if (round % 10 == 3)
        fake_unplug(p->fake, devices[round / 10 % DEVICES]);
    if (round % 10 == 8)
        fake_replug(p->fake, devices[round / 10 % DEVICES], NULL);
    if (round % 4 == 0)
        assert_true(fake_settle(p->fake));
}

static void test_everybody_at_once(void **state) {
    (void)state;
    struct play p = {.fake = fake_bus_create(START_NS)};
    struct ap_live_bus way = fake_way(p.fake);
    const struct ap_live_params params = {
        .buses = &way, .bus_count = 1, .listener = {.user = &p, .pose = on_pose}};
    assert_int_equal(ap_live_open(NULL, &params, &p.live), AP_OK);
    int devices[DEVICES];
    for (int i = 0; i < DEVICES; i++)
        devices[i] = plug_slimevr(p.fake, (const char[]){(char)('A' + i), 0});
    pthread_t threads[ASKERS + 1];
    for (int i = 0; i < ASKERS; i++)
        assert_int_equal(pthread_create(&threads[i], NULL, ask, &p), 0);
    assert_int_equal(pthread_create(&threads[ASKERS], NULL, look, &p), 0);
    for (int round = 1; round <= ROUNDS; round++)
        play_round(&p, devices, round);
    assert_true(fake_settle(p.fake));
    atomic_store(&p.over, true);
    for (int i = 0; i <= ASKERS; i++)
        pthread_join(threads[i], NULL);
    printf("%lld questions, %lld poses, %lld told\n", (long long)p.asked, (long long)p.seen,
           (long long)p.told);
    assert_int_equal(p.wrong, 0);
    assert_true(p.seen > 100 && p.told > ROUNDS);
    assert_int_equal(ap_live_device_count(p.live), DEVICES);
    ap_live_close(p.live);
    fake_bus_free(p.fake);
}

// Closing at any moment: while devices start, while they report, at once.
static void test_close_at_any_moment(void **state) {
    (void)state;
    for (int i = 0; i < 40; i++) {
        struct fake_bus *fake = fake_bus_create(START_NS);
        struct ap_live_bus way = fake_way(fake);
        struct ap_live *live = NULL;
        const struct ap_live_params params = {.buses = &way, .bus_count = 1};
        assert_int_equal(ap_live_open(NULL, &params, &live), AP_OK);
        int d = i % 4 ? plug_slimevr(fake, "A") : -1;
        if (i % 4 == 2)
            assert_true(fake_settle(fake));
        if (d >= 0)
            send_slimevr(fake, d, 0.1, 0);
        if (i % 4 == 3)
            fake_unplug(fake, d);
        ap_live_close(live);
        assert_true(fake->destroyed);
        for (int k = 0; k < FAKE_DEVICES; k++)
            assert_false(fake->devices[k].open);
        fake_bus_free(fake);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_everybody_at_once),
        cmocka_unit_test(test_close_at_any_moment),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
