#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/app/calibrate.h"
#include "src/app/logs.h"
#include "src/base/clock.h"
#include "src/base/file.h"
#include "src/base/log.h"
#include "src/base/number.h"
#include "src/device/calibration/store.h"

// antipode calibrate table: touches from pose logs or from devices, the table out of them.

enum { HANDS_MAX = AP_LIVE_DEVICES_MAX * AP_LIVE_TRACKERS_MAX };

struct touching {
    pthread_mutex_t lock;
    struct ap_touch_finder finder[HANDS_MAX]; // by the log's device, or the live device
    struct ap_vec3 touch[AP_TABLE_TOUCHES_MAX];
    int count, wanted, moved;
};

static enum ap_status read_tip(struct ap_error *err, const char *text, struct ap_vec3 *tip) {
    double v[3];
    const char *at = text;
    for (int i = 0; i < 3; i++) {
        size_t len = strcspn(at, ",");
        if (!ap_parse_double(at, len, &v[i]) || !(fabs(v[i]) <= 1) || (at[len] == ',') != (i < 2))
            return ap_fail(err, AP_USAGE,
                           "--tip: expected X,Y,Z in metres, each at most 1, not '%s'", text);
        at += len + 1;
    }
    *tip = (struct ap_vec3){v[0], v[1], v[2]};
    return AP_OK;
}

static void take(struct touching *t, int hand, int64_t t_ns, struct ap_pose pose, bool pressed) {
    struct ap_vec3 touch;
    if (hand < 0 || hand >= HANDS_MAX || t->count >= t->wanted)
        return;
    enum ap_touch_event event = ap_touch_find(&t->finder[hand], t_ns, pose, pressed, &touch);
    t->moved += event == AP_TOUCH_MOVED;
    if (event == AP_TOUCH_MADE)
        t->touch[t->count++] = touch;
}

static enum ap_status touch_in_logs(struct ap_error *err, struct touching *t, char *const *logs,
                                    int log_count) {
    const struct ap_log_options options = AP_LOG_OPTIONS_NONE;
    struct ap_poselog *log = NULL;
    struct ap_sample s;
    bool got = true;
    enum ap_status st = ap_logs_open(err, &options, logs, log_count, &log);
    while (!st && got && t->count < t->wanted) {
        st = ap_poselog_next(err, log, &s, &got);
        if (!st && got && strcmp(ap_poselog_device_name(log, s.device), "head") != 0)
            take(t, s.device, s.t_ns, s.pose, s.select || s.trigger > 0.5f || s.squeeze > 0.5f);
    }
    ap_poselog_close(log);
    return st;
}

static void on_pose(void *user, const struct ap_live_pose_row *r) {
    struct touching *t = user;
    const struct ap_driver_sample *s = r->sample;
    if (strcmp(r->role, "head") == 0)
        return;
    pthread_mutex_lock(&t->lock);
    take(t, r->device * AP_LIVE_TRACKERS_MAX + r->tracker, r->t_ns, r->pose,
         (s->buttons & 1) || s->trigger > 0.5f);
    pthread_mutex_unlock(&t->lock);
}

static enum ap_status touch_live(struct ap_error *err, const struct ap_calibrate_options *o,
                                 struct touching *t) {
    struct ap_live *live = NULL;
    ap_catch_end();
    ap_log(AP_LOG_INFO,
           "calibrate: touch %d corners of the table with a controller and press its "
           "trigger at each",
           t->wanted);
    struct ap_live_options options = o->live;
    options.uncalibrated = false; // how the controller is mounted matters
    const struct ap_live_params base = {.listener = {.user = t, .pose = on_pose}};
    enum ap_status st = ap_live_options_open(err, &options, &base, &live);
    int64_t now_ns = ap_clock_now_ns(), end_ns = now_ns + (int64_t)(o->seconds * 1e9);
    for (int seen = 0; !st && seen < t->wanted && !ap_end_asked() && now_ns < end_ns;) {
        now_ns += 50000000;
        ap_clock_sleep_until_ns(now_ns);
        pthread_mutex_lock(&t->lock);
        int count = t->count;
        pthread_mutex_unlock(&t->lock);
        if (count > seen)
            ap_log(AP_LOG_INFO, "calibrate: corner %d of %d", count, t->wanted);
        seen = count;
    }
    ap_live_close(live);
    return st;
}

static enum ap_status save(struct ap_error *err, const struct ap_calibrate_options *o,
                           const struct ap_room_calibration *room, char **path) {
    char *dir = NULL;
    enum ap_status st = AP_OK;
    if (o->out) {
        *path = strdup(o->out);
        if (!*path)
            st = ap_fail(err, AP_ENVIRONMENT, "out of memory");
    } else {
        st = ap_config_path(err, NULL, &dir);
        if (!st)
            st = ap_make_dirs(err, dir);
        if (!st)
            st = ap_config_path(err, "room.json", path);
    }
    free(dir);
    return st ? st : ap_room_file_write(err, *path, room);
}

static enum ap_status finish(struct ap_error *err, const struct ap_calibrate_options *o,
                             const struct touching *t) {
    struct ap_table_fit fit;
    char *path = NULL;
    if (t->count < t->wanted)
        return ap_fail(err, AP_INPUT, "%d of %d corners were touched%s", t->count, t->wanted,
                       t->moved ? "; hold still while the trigger is pressed" : "");
    enum ap_status st =
        ap_table_fit(err, t->touch, t->count, isnan(o->table_edge) ? 0 : o->table_edge, &fit);
    for (int i = 0; !st && i < t->count; i++)
        printf("corner %d at %.4f %.4f %.4f, off by %.1f mm\n", i + 1, t->touch[i].x, t->touch[i].y,
               t->touch[i].z, 1e3 * fit.residual_m[i]);
    const struct ap_room_calibration room = {fit.place, fit.rms_m};
    if (!st)
        st = save(err, o, &room, &path);
    const struct ap_table_place *p = &fit.place;
    if (!st)
        printf("table: --table-at %.17g,%.17g,%.17g --table-height %.17g, edge %.4f m; angle %.2f "
               "degrees, %.2f off level\n%s: written\n",
               p->x_m, p->z_m, p->yaw_rad, p->height_m, p->edge_m, 180 / M_PI * fit.corner_rad,
               180 / M_PI * fit.slope_rad, path);
    free(path);
    const char *doubt = st ? NULL : ap_table_fit_doubt(&fit);
    return doubt ? ap_fail(err, AP_DIFFERS, "%s", doubt) : st;
}

enum ap_status ap_calibrate_table(struct ap_error *err, const struct ap_calibrate_options *o,
                                  char *const *logs, int log_count) {
    struct ap_vec3 tip = {0, 0, 0};
    enum ap_status st = o->tip ? read_tip(err, o->tip, &tip) : AP_OK;
    struct touching *t = calloc(1, sizeof *t);
    if (!t)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    t->wanted = (int)o->corners;
    for (int i = 0; i < HANDS_MAX; i++)
        t->finder[i].tip_m = tip;
    pthread_mutex_init(&t->lock, NULL);
    if (!st)
        st = log_count > 0 ? touch_in_logs(err, t, logs, log_count) : touch_live(err, o, t);
    if (!st)
        st = finish(err, o, t);
    pthread_mutex_destroy(&t->lock);
    free(t);
    return st;
}
