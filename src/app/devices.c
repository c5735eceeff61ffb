#include <inttypes.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "src/app/live_options.h"
#include "src/base/clock.h"
#include "src/base/log.h"
#include "src/base/utf8.h"

// antipode devices: what is plugged in, and with --watch what it says.

static const char help[] =
    "Lists the HID devices that are plugged in: name, bus, serial number, driver, degrees of\n"
    "freedom, reports a second and what it is used as. Where there is no permission it says which\n"
    "udev rule is missing and where it belongs. Only devices that a driver knows are opened.\n"
    "With --watch the table goes on until Ctrl-C: poses (yaw, pitch and roll in degrees, place in\n"
    "metres), rate, losses, age of the newest report, battery; devices may come and go.\n"
    "    antipode devices --watch --device head=A1B2C3 --device left=joycon\n"
    "Exit status: 0; 1 where a device could not be opened; 2 usage; 3 a recording that cannot be\n"
    "read; 4 devices cannot be looked for.";

static const int64_t MS = 1000000;

struct devices_options {
    struct ap_live_options live;
    bool watch, json;
    double seconds;
};

static const char *bus_name(uint16_t bus) {
    return bus == 3 ? "usb" : bus == 5 ? "bluetooth" : bus == 6 ? "virtual" : "other";
}

// "head, left", or the state where there is no role.
static void use_of(const struct ap_live_device *d, char *text, size_t size) {
    size_t n = 0;
    text[0] = '\0';
    for (int t = 0; t < d->tracker_count && n < size; t++)
        if (d->role[t][0])
            n += (size_t)snprintf(text + n, size - n, "%s%s", n ? ", " : "", d->role[t]);
    if (n == 0 || d->state != AP_LIVE_RUNNING)
        snprintf(text, size, "%s",
                 d->state == AP_LIVE_RUNNING ? "silent" : ap_live_state_name(d->state));
}

static void print_device(const struct ap_live_device *d) {
    char use[160], rate[24] = "-", degrees[8] = "-", where[320];
    use_of(d, use, sizeof use);
    if (d->state == AP_LIVE_RUNNING)
        snprintf(rate, sizeof rate, "%.0f", d->rate_hz);
    if (d->degrees)
        snprintf(degrees, sizeof degrees, "%d", d->degrees);
    snprintf(where, sizeof where, "%s (%s)", d->place.path, d->way);
    printf("%-32.32s %-9s %-18s %-20s %3s %7s  %-16s %s\n", d->place.name, bus_name(d->place.bus),
           d->place.serial[0] ? d->place.serial : "-", d->driver ? d->driver->name : "-", degrees,
           rate, use, where);
}

static void print_head(void) {
    printf("%-32s %-9s %-18s %-20s %3s %7s  %-16s %s\n", "device", "bus", "serial", "driver", "dof",
           "rate/s", "used as", "path");
}

static void print_reasons(const struct ap_live *live) {
    struct ap_live_device d;
    for (int i = 0; i < ap_live_device_count(live); i++) {
        ap_live_device_at(live, i, &d);
        if (d.why[0])
            ap_log(d.state == AP_LIVE_RUNNING ? AP_LOG_WARNING : AP_LOG_ERROR, "devices: %s",
                   d.why);
    }
}

static bool any_failed(const struct ap_live *live) {
    struct ap_live_device d;
    for (int i = 0; i < ap_live_device_count(live); i++) {
        ap_live_device_at(live, i, &d);
        if (d.state == AP_LIVE_DENIED || d.state == AP_LIVE_FAILED)
            return true;
    }
    return false;
}

static json_t *device_json(const struct ap_live_device *d, int64_t now_ns) {
    char path[AP_LIVE_PATH_MAX];
    snprintf(path, sizeof path, "%s", d->place.path); // of a recording: any bytes
    ap_utf8_tidy(path);
    json_t *roles = json_array();
    for (int t = 0; t < d->tracker_count; t++)
        json_array_append_new(roles, json_string(d->role[t]));
    json_t *object = json_pack(
        "{s:s, s:s, s:s, s:s, s:s, s:i, s:i, s:s, s:i, s:f, s:s, s:o, s:I, s:I, s:I, s:s}", "name",
        d->place.name, "bus", bus_name(d->place.bus), "serial", d->place.serial, "path", path,
        "way", d->way, "vendor", (int)d->place.vendor, "product", (int)d->place.product, "driver",
        d->driver ? d->driver->name : "", "degrees", d->degrees, "rate_hz", d->rate_hz, "state",
        ap_live_state_name(d->state), "roles", roles, "reports", (json_int_t)d->reports, "bad",
        (json_int_t)d->bad, "lost", (json_int_t)d->lost, "why", d->why);
    if (object && d->newest_ns)
        json_object_set_new(object, "age_ms", json_real((double)(now_ns - d->newest_ns) * 1e-6));
    if (object && d->battery_percent >= 0)
        json_object_set_new(object, "battery_percent", json_integer(d->battery_percent));
    return object;
}

static enum ap_status print_json(struct ap_error *err, const struct ap_live *live) {
    struct ap_live_device d;
    json_t *list = json_array();
    bool ok = list != NULL;
    for (int i = 0; ok && i < ap_live_device_count(live); i++) {
        ap_live_device_at(live, i, &d);
        ok = json_array_append_new(list, device_json(&d, ap_live_now_ns(live))) == 0;
    }
    ok = ok && json_dumpf(list, stdout, JSON_INDENT(1) | JSON_REAL_PRECISION(9)) == 0;
    json_decref(list);
    printf("\n");
    return ok ? AP_OK : ap_fail(err, AP_ENVIRONMENT, "the list cannot be written");
}

static void print_list(const struct ap_live *live, bool by_bus) {
    struct ap_live_device d;
    int count = ap_live_device_count(live);
    if (count)
        print_head();
    else
        ap_log(AP_LOG_INFO, "no HID device is plugged in (%s)",
               by_bus ? "that this --bus leads to" : "/sys/class/hidraw has none");
    for (int i = 0; i < count; i++) {
        ap_live_device_at(live, i, &d);
        print_device(&d);
    }
}

// --- watching

static const char *const state_words[] = {
    [AP_POSE_NONE] = "none",       [AP_POSE_EXACT] = "exact", [AP_POSE_INTERPOLATED] = "between",
    [AP_POSE_PREDICTED] = "ahead", [AP_POSE_LOST] = "lost",
};

// In degrees: about y, then x, then z.
static void angles_of(struct ap_quat q, double degrees[3]) {
    static const double DEGREE = 57.295779513082321;
    degrees[0] = DEGREE * atan2(2 * (q.w * q.y + q.x * q.z), 1 - 2 * (q.x * q.x + q.y * q.y));
    degrees[1] = DEGREE * asin(fmax(-1, fmin(1, 2 * (q.w * q.x - q.y * q.z))));
    degrees[2] = DEGREE * atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.x * q.x + q.z * q.z));
}

static void print_role(const struct ap_live *live, int role, int64_t now_ns, const char *clear) {
    struct ap_live_answer a = ap_live_at(live, role, now_ns);
    if (a.state == AP_POSE_NONE)
        return;
    double turn[3];
    angles_of(a.pose.q, turn);
    printf("%-12s %-7s %7.1f %6.1f %7.1f  %7.3f %7.3f %7.3f  %8.1f  %3.0f%% %s%s\n",
           ap_live_role_name(live, role), state_words[a.state], turn[0], turn[1], turn[2],
           a.pose.p.x, a.pose.p.y, a.pose.p.z, (double)a.age_ns * 1e-6, 100 * (double)a.trigger,
           a.select ? "select" : "", clear);
}

static void print_traffic(const struct ap_live_device *d, int64_t now_ns, const char *clear) {
    char use[160], age[24] = "-", battery[16] = "-", lost[24] = "-";
    use_of(d, use, sizeof use);
    if (d->newest_ns)
        snprintf(age, sizeof age, "%.1f", (double)(now_ns - d->newest_ns) * 1e-6);
    if (d->battery_percent >= 0)
        snprintf(battery, sizeof battery, "%d%%", d->battery_percent);
    if (d->lost >= 0)
        snprintf(lost, sizeof lost, "%" PRId64, d->lost);
    printf("%-32.32s %-18s %7.0f %9" PRId64 " %6s %5" PRId64 " %8s %5s  %s%s\n", d->place.name,
           d->place.serial[0] ? d->place.serial : "-", d->rate_hz, d->reports, lost, d->bad, age,
           battery, use, clear);
}

static void print_frame(const struct ap_live *live, bool terminal) {
    const char *clear = terminal ? "\033[K" : "";
    struct ap_live_device d;
    int64_t now_ns = ap_live_now_ns(live);
    if (terminal)
        printf("\033[H");
    printf("%-32s %-18s %7s %9s %6s %5s %8s %5s  %s%s\n", "device", "serial", "rate/s", "reports",
           "lost", "bad", "age/ms", "batt", "used as", clear);
    for (int i = 0; i < ap_live_device_count(live); i++) {
        ap_live_device_at(live, i, &d);
        print_traffic(&d, now_ns, clear);
    }
    printf("%s\n%-12s %-7s %7s %6s %7s  %7s %7s %7s  %8s  %4s%s\n", clear, "role", "pose", "yaw",
           "pitch", "roll", "x/m", "y/m", "z/m", "age/ms", "trig", clear);
    for (int role = 0; role < ap_live_role_count(live); role++)
        print_role(live, role, now_ns, clear);
    printf("%s", terminal ? "\033[J" : "\n");
    fflush(stdout);
}

static void watch(const struct ap_live *live, double seconds) {
    bool terminal = isatty(STDOUT_FILENO);
    int64_t now_ns = ap_clock_now_ns();
    int64_t end_ns = isnan(seconds) ? INT64_MAX : now_ns + (int64_t)(seconds * 1e9);
    if (terminal)
        printf("\033[2J");
    while (!ap_end_asked() && now_ns < end_ns && !ferror(stdout)) {
        now_ns += terminal ? 100 * MS : 1000 * MS;
        ap_clock_sleep_until_ns(now_ns < end_ns ? now_ns : end_ns);
        print_frame(live, terminal);
    }
}

// Long enough to count reports, from when all have been switched on.
static void listen(struct ap_live *live, double seconds) {
    ap_live_settle(live, ap_clock_now_ns() + 3000 * MS);
    int64_t now_ns = ap_clock_now_ns();
    int64_t until_ns = now_ns + (isnan(seconds) ? 1200 * MS : (int64_t)(seconds * 1e9));
    while (!ap_end_asked() && now_ns < until_ns && ap_live_device_count(live)) {
        now_ns += 50 * MS;
        ap_clock_sleep_until_ns(now_ns);
    }
}

static enum ap_status show(struct ap_error *err, const struct devices_options *o) {
    struct ap_live *live = NULL;
    enum ap_status st = ap_live_options_open(err, &o->live, &(struct ap_live_params){0}, &live);
    if (st)
        return st;
    ap_catch_end();
    if (o->watch)
        watch(live, o->seconds);
    else
        listen(live, o->seconds);
    if (o->json)
        st = print_json(err, live);
    else if (!o->watch)
        print_list(live, o->live.bus.count > 0);
    fflush(stdout);
    print_reasons(live);
    if (!st && any_failed(live))
        st = AP_DIFFERS;
    if (fflush(stdout) != 0 || ferror(stdout))
        st = ap_fail(err, AP_ENVIRONMENT, "standard output cannot be written");
    ap_live_close(live);
    return st;
}

static enum ap_status run(struct ap_error *err, int argc, char **argv) {
    struct devices_options o = {.seconds = NAN};
    const struct ap_option options[] = {
        {"watch", AP_OPTION_FLAG, &o.watch, "", "go on, with poses, rates, losses, age, battery"},
        {"json", AP_OPTION_FLAG, &o.json, "", "the list as JSON"},
        {"seconds", AP_OPTION_NUMBER, &o.seconds, "S", "listen so long (1.2; --watch: to Ctrl-C)"},
        AP_LIVE_OPTION_TABLE(o.live),
    };
    const struct ap_usage usage = {.command = "devices",
                                   .operands = "",
                                   .text = help,
                                   .options = options,
                                   .option_count = sizeof options / sizeof options[0]};
    int operands;
    bool done;
    enum ap_status st = ap_parse_options(err, &usage, argc, argv, &operands, &done);
    if (!st && !done && !isnan(o.seconds) && !(o.seconds >= 0 && o.seconds <= 1e6))
        st = ap_fail(err, AP_USAGE, "--seconds: expected 0 to 1000000, not %g", o.seconds);
    if (!st && !done && o.watch && o.json)
        st = ap_fail(err, AP_USAGE, "--json writes one list, --watch goes on: one of them");
    return st || done ? st : show(err, &o);
}

const struct ap_command ap_command_devices = {"devices", "what is plugged in, and what it says",
                                              run};
