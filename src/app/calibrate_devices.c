#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/app/calibrate.h"
#include "src/base/clock.h"
#include "src/base/log.h"
#include "src/device/calibration/mount.h"
#include "src/device/calibration/store.h"

// antipode calibrate rest and mount: what the devices' readers say is collected here, under a lock
// of our own, until it is enough.

static const int64_t MS = 1000000;
static const double REST_S = 5, DEGREE = M_PI / 180;

struct collector {
    pthread_mutex_t lock;
    const char *only;
    bool wants_rest;
    char key[AP_LIVE_DEVICES_MAX][AP_CALIBRATION_KEY_MAX];
    struct ap_rest *rest[AP_LIVE_DEVICES_MAX];
    struct ap_mount mount;
    int mounted; // the device that is being mounted; −1: none yet
    double from_level_rad;
    bool has_nodded;
};

static void on_started(void *user, int device, const struct ap_live_place *place,
                       const struct ap_device_info *info, int64_t now_ns) {
    struct collector *c = user;
    (void)info, (void)now_ns;
    pthread_mutex_lock(&c->lock);
    ap_device_key(c->key[device], sizeof c->key[device], place->serial, place->vendor,
                  place->product);
    pthread_mutex_unlock(&c->lock);
}

static void take_rest(struct collector *c, const struct ap_live_pose_row *r) {
    const struct ap_driver_sample *s = r->sample;
    bool measured = s->has_imu || s->kind == AP_SAMPLE_IMU;
    if (measured && !c->rest[r->device])
        c->rest[r->device] = calloc(1, sizeof *c->rest[r->device]);
    if (measured && c->rest[r->device])
        ap_rest_add(c->rest[r->device], r->t_ns,
                    s->has_imu ? s->gyro_rad_s : s->angular_velocity_rad_s, s->acceleration_m_s2);
}

// Looking ahead begins anew whenever it was not still.
static void take_mount(struct collector *c, const struct ap_live_pose_row *r) {
    const struct ap_driver_sample *s = r->sample;
    if (s->kind == AP_SAMPLE_FLIGHT || s->tracker != 0 ||
        (c->mounted >= 0 && c->mounted != r->device))
        return;
    c->mounted = r->device;
    ap_mount_add(&c->mount, r->t_ns, s->pose.q);
    if (!ap_mount_is_level(&c->mount)) {
        if (c->mount.unrest_rad > 1.5 * DEGREE)
            memset(&c->mount, 0, sizeof c->mount);
        return;
    }
    struct ap_quat d = ap_quat_mul(ap_quat_conj(c->mount.level), s->pose.q);
    c->from_level_rad = 2 * atan2(sqrt(d.x * d.x + d.y * d.y + d.z * d.z), fabs(d.w));
    c->has_nodded |= c->from_level_rad > 20 * DEGREE;
}

static void on_pose(void *user, const struct ap_live_pose_row *r) {
    struct collector *c = user;
    pthread_mutex_lock(&c->lock);
    if (!c->only || strcmp(c->only, c->key[r->device]) == 0) {
        if (c->wants_rest)
            take_rest(c, r);
        else
            take_mount(c, r);
    }
    pthread_mutex_unlock(&c->lock);
}

// Everything that measures has lain long enough, and there is something.
static bool rest_is_done(struct collector *c, int poses) {
    int devices = 0, done = 0;
    struct ap_rest_result r;
    for (int i = 0; i < AP_LIVE_DEVICES_MAX; i++) {
        if (!c->rest[i])
            continue;
        devices++;
        done += ap_rest_result(NULL, c->rest[i], &r) == AP_OK && r.seconds >= REST_S &&
                r.poses >= poses;
    }
    return devices > 0 && done == devices;
}

static bool mount_is_done(const struct collector *c) {
    return c->has_nodded && c->from_level_rad < 5 * DEGREE;
}

static bool is_over(const struct ap_live *live) {
    struct ap_live_device d;
    int count = ap_live_device_count(live), gone = 0;
    for (int i = 0; i < count; i++) {
        ap_live_device_at(live, i, &d);
        gone += d.state == AP_LIVE_GONE || d.state == AP_LIVE_NO_DRIVER;
    }
    return count > 0 && gone == count;
}

// Until it is enough, Ctrl-C, the time is over, or a recording is.
static void wait_for(struct collector *c, const struct ap_calibrate_options *o,
                     const struct ap_live *live) {
    int64_t now_ns = ap_clock_now_ns(), end_ns = now_ns + (int64_t)(o->seconds * 1e9);
    bool done = false, told = false;
    while (!done && !ap_end_asked() && now_ns < end_ns &&
           !(o->live.replay.count && is_over(live))) {
        now_ns += 100 * MS;
        ap_clock_sleep_until_ns(now_ns);
        pthread_mutex_lock(&c->lock);
        done = c->wants_rest ? rest_is_done(c, (int)o->poses) : mount_is_done(c);
        bool level = !c->wants_rest && ap_mount_is_level(&c->mount);
        pthread_mutex_unlock(&c->lock);
        if (level && !told)
            ap_log(AP_LOG_INFO, "calibrate: now nod, down first, then up, and look ahead again");
        told |= level;
    }
}

static enum ap_status collect(struct ap_error *err, const struct ap_calibrate_options *o,
                              struct collector *c) {
    struct ap_live *live = NULL;
    pthread_mutex_init(&c->lock, NULL);
    c->only = o->only;
    c->mounted = -1;
    ap_catch_end();
    const struct ap_live_params base = {
        .listener = {.user = c, .started = on_started, .pose = on_pose}};
    struct ap_live_options options = o->live;
    options.uncalibrated = c->wants_rest;
    options.unmounted = true;
    enum ap_status st = ap_live_options_open(err, &options, &base, &live);
    if (!st && !ap_live_settle(live, ap_clock_now_ns() + 3000 * MS))
        ap_log(AP_LOG_WARNING, "calibrate: a device takes long to start");
    if (!st)
        wait_for(c, o, live);
    ap_live_close(live); // no callback comes from here on
    pthread_mutex_destroy(&c->lock);
    return st;
}

// What is known of the device already stays but for what is new.
static enum ap_status keep(struct ap_error *err, const struct ap_device_calibration *fresh) {
    struct ap_device_calibration c = *fresh;
    bool found = false;
    char *dir = NULL;
    enum ap_status st = ap_config_path(err, NULL, &dir);
    if (!st)
        st = ap_calibration_read(err, dir, fresh->key, &c, &found);
    if (!st && found && fresh->has_bias) {
        c.has_bias = true;
        c.rest = fresh->rest;
    }
    if (!st && found && fresh->has_mount) {
        c.has_mount = true;
        c.tracker_from_body = fresh->tracker_from_body;
    }
    if (!st)
        st = ap_calibration_write(err, dir, &c);
    free(dir);
    return st;
}

static enum ap_status keep_rest(struct ap_error *err, const char *key, const struct ap_rest *rest) {
    struct ap_device_calibration c = {.has_bias = true, .tracker_from_body = AP_QUAT_IDENTITY};
    struct ap_error why = {""};
    enum ap_status st = ap_rest_result(&why, rest, &c.rest);
    if (st)
        return ap_fail(err, st, "%s: %s", key, why.text);
    snprintf(c.key, sizeof c.key, "%s", key);
    st = keep(err, &c);
    const struct ap_imu_bias *b = &c.rest.bias;
    if (!st)
        printf("%s: gyroscope %.4f %.4f %.4f deg/s (within %.4f), accelerometer %.4f %.4f %.4f "
               "m/s2, from %.1f s at rest in %d pose%s\n",
               key, b->gyr_rad_s.x / DEGREE, b->gyr_rad_s.y / DEGREE, b->gyr_rad_s.z / DEGREE,
               c.rest.gyr_sigma_rad_s / DEGREE, b->acc_m_s2.x, b->acc_m_s2.y, b->acc_m_s2.z,
               c.rest.seconds, c.rest.poses, c.rest.poses == 1 ? "" : "s");
    return st;
}

enum ap_status ap_calibrate_rest(struct ap_error *err, const struct ap_calibrate_options *o) {
    struct collector *c = calloc(1, sizeof *c);
    if (!c)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    c->wants_rest = true;
    ap_log(AP_LOG_INFO, "calibrate: lay the devices down and let go%s",
           o->poses > 1 ? "; every few seconds on another side" : "");
    enum ap_status st = collect(err, o, c);
    int devices = 0;
    for (int i = 0; i < AP_LIVE_DEVICES_MAX && !st; i++)
        if (c->rest[i]) {
            devices++;
            st = keep_rest(err, c->key[i], c->rest[i]);
        }
    if (!st && devices == 0)
        st = ap_fail(err, AP_ENVIRONMENT,
                     "no device measured rates and forces; antipode devices says what is there");
    for (int i = 0; i < AP_LIVE_DEVICES_MAX; i++)
        free(c->rest[i]);
    free(c);
    return st;
}

enum ap_status ap_calibrate_mount(struct ap_error *err, const struct ap_calibrate_options *o) {
    struct collector *c = calloc(1, sizeof *c);
    if (!c)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    ap_log(AP_LOG_INFO, "calibrate: look (or point) level ahead and hold still");
    struct ap_device_calibration fresh = {.has_mount = true};
    struct ap_mount_result result;
    enum ap_status st = collect(err, o, c);
    if (!st && c->mounted < 0)
        st = ap_fail(err, AP_ENVIRONMENT,
                     "no device said how it is turned; antipode devices says what is there");
    if (!st)
        st = ap_mount_result(err, &c->mount, &result);
    if (!st) {
        memcpy(fresh.key, c->key[c->mounted], sizeof fresh.key);
        fresh.tracker_from_body = result.tracker_from_body;
        st = keep(err, &fresh);
    }
    struct ap_quat q = fresh.tracker_from_body;
    if (!st)
        printf("%s: body in the tracker's axes %.5f %.5f %.5f %.5f, from a nod of %.0f degrees\n",
               fresh.key, q.x, q.y, q.z, q.w, result.nod_rad / DEGREE);
    free(c);
    return st;
}
