#include <inttypes.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "src/device/poselog.h"
#include "src/device/log/poselog_argument.h"
#include "tests/device/memory_file.h"

// The formats that are read as a whole, rates and forces, CSV with names in its header, and what
// the options of a log make of it.

enum { ROWS_MAX = 40000 };

static const double DEGREE = 3.14159265358979323846 / 180;

struct reading {
    int count;
    enum ap_status status;
    char error[AP_ERROR_TEXT_MAX];
    int64_t skipped;
    struct ap_sample rows[ROWS_MAX];
    char names[ROWS_MAX][16];
};

static struct reading all; // large

static void read_log(const char *source, bool skip_bad) {
    struct ap_poselog_params params = {.sources = &source, .source_count = 1, .skip_bad = skip_bad};
    struct ap_poselog *log = NULL;
    struct ap_error err = {""};
    all.count = 0;
    all.skipped = 0;
    all.status = ap_poselog_open(&err, &params, &log);
    for (bool got = true; !all.status && got && all.count < ROWS_MAX;) {
        struct ap_sample *s = &all.rows[all.count];
        all.status = ap_poselog_next(&err, log, s, &got);
        if (all.status || !got)
            break;
        snprintf(all.names[all.count++], sizeof all.names[0], "%s",
                 ap_poselog_device_name(log, s->device));
    }
    if (log)
        all.skipped = ap_poselog_skipped(log);
    ap_poselog_close(log);
    snprintf(all.error, sizeof all.error, "%s", err.text);
}

static void read_bytes(const void *bytes, size_t len, const char *role, const char *options,
                       bool skip_bad) {
    struct memory_file file = memory_file(bytes, len);
    char source[256];
    snprintf(source, sizeof source, "%s%s%s", role, file.path, options);
    read_log(source, skip_bad);
    close(file.fd);
}

static void read_text(const char *text, const char *options) {
    read_bytes(text, strlen(text), "", options, false);
}

static void good(void) {
    if (all.status)
        fail_msg("%s", all.error);
}

static void bad(enum ap_status status, const char *part) {
    assert_int_equal(all.status, status);
    if (!strstr(all.error, part))
        fail_msg("'%s', expected '…%s…'", all.error, part);
}

static double apart_deg(struct ap_quat a, struct ap_quat b) {
    struct ap_quat d = ap_quat_mul(ap_quat_conj(a), b);
    return 2 * asin(fmin(1, sqrt(d.x * d.x + d.y * d.y + d.z * d.z))) / DEGREE;
}

static void check_row(int i, int64_t t_ns, const char *name, const double want[7]) {
    if (i >= all.count)
        fail_msg("row %d of %d", i, all.count);
    const struct ap_sample *s = &all.rows[i];
    assert_string_equal(all.names[i], name);
    assert_int_equal(s->t_ns, t_ns);
    struct ap_vec3 d = ap_vec3_sub(s->pose.p, (struct ap_vec3){want[0], want[1], want[2]});
    double turn = apart_deg(s->pose.q, (struct ap_quat){want[3], want[4], want[5], want[6]});
    if (!(ap_vec3_length(d) <= 1e-6 && turn <= 1e-4))
        fail_msg("row %d: (%.9g %.9g %.9g; %.9g %.9g %.9g %.9g), %.3g m and %.3g degrees from what "
                 "is expected; 1e-6 m and 1e-4 degrees allowed",
                 i, s->pose.p.x, s->pose.p.y, s->pose.p.z, s->pose.q.x, s->pose.q.y, s->pose.q.z,
                 s->pose.q.w, ap_vec3_length(d), turn);
}

#define ROW(i, t_ns, name, ...) check_row(i, t_ns, name, (const double[7]){__VA_ARGS__})

// What a recording's TUM files say, which somebody else's program has made of it.
static void check_against_tum(const char *shared, const char *recording, const char *name,
                              const char *base, double m, double degrees) {
    char path[1024], line[512];
    snprintf(path, sizeof path, "%s/data/poses/%s_%s.tum", shared, base, name);
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    double worst_m = 0, worst_deg = 0, worst_s = 0;
    int n = 0, i = 0;
    while (fgets(line, sizeof line, file)) {
        double v[8];
        if (line[0] == '#' || sscanf(line, "%lf %lf %lf %lf %lf %lf %lf %lf", &v[0], &v[1], &v[2],
                                     &v[3], &v[4], &v[5], &v[6], &v[7]) != 8)
            continue;
        while (i < all.count && strcmp(all.names[i], name) != 0)
            i++;
        if (i == all.count)
            fail_msg("%s: only %d rows of %s", recording, n, name);
        const struct ap_sample *s = &all.rows[i++];
        worst_s = fmax(worst_s, fabs(1e-9 * (double)s->t_ns - v[0]));
        worst_m = fmax(worst_m,
                       ap_vec3_length(ap_vec3_sub(s->pose.p, (struct ap_vec3){v[1], v[2], v[3]})));
        worst_deg = fmax(worst_deg, apart_deg(s->pose.q, (struct ap_quat){v[4], v[5], v[6], v[7]}));
        n++;
    }
    fclose(file);
    print_message("%s %s: %d poses, worst %.2g s, %.2g m, %.2g degrees\n", recording, name, n,
                  worst_s, worst_m, worst_deg);
    while (i < all.count && strcmp(all.names[i], name) != 0)
        i++;
    assert_int_equal(i, all.count); // no more rows than the file has
    if (!(n > 1000 && worst_m <= m && worst_deg <= degrees && worst_s <= 1.1e-6))
        fail_msg("allowed: %g m, %g degrees, 1.1e-6 s", m, degrees);
}

static void test_recordings(void **unused) {
    (void)unused;
    static const struct {
        const char *file, *base;
    } recordings[] = {{"quest3_iwer.json", "quest3"},
                      {"vive_room_aframe.json", "vive_room"},
                      {"vive_crouch_aframe.json", "vive_crouch"},
                      {"quest2_beatsaber_60s.bsor", "quest2_beatsaber"},
                      {"vivepro2_beatsaber_60s.bsor", "vivepro2_beatsaber"}};
    const char *shared = getenv("ANTIPODE_SHARED");
    if (!shared) {
        print_message("skipped: ANTIPODE_SHARED is not set\n");
        skip();
    }
    for (size_t i = 0; i < sizeof recordings / sizeof *recordings; i++) {
        char path[1024];
        snprintf(path, sizeof path, "%s/data/poses/%s", shared, recordings[i].file);
        read_log(path, false);
        good();
        static const char *const names[] = {"head", "left", "right"};
        for (int k = 0; k < 3; k++)
            check_against_tum(shared, recordings[i].file, names[k], recordings[i].base, 1.1e-6,
                              2e-5);
        int pulled = 0, squeezed = 0;
        for (int k = 0; k < all.count; k++) {
            pulled += all.rows[k].trigger > 0;
            squeezed += all.rows[k].squeeze > 0;
            assert_true(all.rows[k].trigger <= 1 && all.rows[k].squeeze <= 1);
        }
        print_message("%s: trigger in %d rows, squeeze in %d\n", recordings[i].file, pulled,
                      squeezed);
        if (i < 3)
            assert_true(pulled > 0);
    }
}

#define IWER_SCHEMA                                                                                \
    "{\"schema\": [[0, {\"handedness\": \"left\", \"hasGrip\": true, \"hasGamepad\": true, "       \
    "\"numButtons\": 2, \"numAxes\": 1}], [7, {\"handedness\": \"right\", \"hasHand\": false}], "  \
    "[8, {\"handedness\": \"none\"}]], \"frames\": ["
#define RAY "9, 9, 9, 0, 0, 0, 1"

static void test_iwer(void **unused) {
    (void)unused;
    read_text(IWER_SCHEMA
              "[1000.5, 1, 2, 3, 0, 0, 0, 1, [0, " RAY ", [0.1, 0.2, 0.3, 0, 1, 0, 0], "
              "[[1, 1, 0.75], [0, 0, 0.5], 0.1]], [7, 4, 5, 6, 1, 0, 0, 0], [8, " RAY "]],"
              "[1011.6, 1, 2, 4, 0, 0, 0.6, 0.8, [0, " RAY ", null, [null, [0, 0, 0], 0]]]]}",
              "");
    good();
    assert_int_equal(all.count, 5);
    ROW(0, 0, "head", 1, 2, 3, 0, 0, 0, 1);
    ROW(1, 0, "left", 0.1, 0.2, 0.3, 0, 1, 0, 0);
    assert_true(all.rows[1].select && all.rows[1].trigger == 0.75f && all.rows[1].squeeze == 0.5f);
    ROW(2, 0, "right", 4, 5, 6, 1, 0, 0, 0);
    ROW(3, 11100000, "head", 1, 2, 4, 0, 0, 0.6, 0.8);
    ROW(4, 11100000, "left", 9, 9, 9, 0, 0, 0, 1); // no grip in this frame: the ray
    assert_false(all.rows[4].select);
    // A bad frame, and the frame that is lost by it.
    static const char text[] = IWER_SCHEMA "[5, 1, 2, 3, 0, 0, 0, 1], [6, 1, 2, 3, 0, 0, 0, 0], "
                                           "[7, 1, 2, 3, 0, 0, 0, 1]]}";
    read_text(text, "");
    bad(AP_INPUT, "/frames/1/4: expected a unit quaternion");
    read_bytes(text, sizeof text - 1, "", "", true);
    good();
    assert_int_equal(all.count, 2);
    assert_int_equal(all.skipped, 1);
    read_text(IWER_SCHEMA "[5, 1, 2, 3, 0, 0, 0, 1], [4, 1, 2, 3, 0, 0, 0, 1]]}", "");
    bad(AP_INPUT, "/frames/1/0: expected a time not before the frame before");
    read_text(IWER_SCHEMA "[5, 1, 2, 3, 0, 0, 0, 1, [3, " RAY "]]]}", "");
    bad(AP_INPUT, "/frames/0/8/0: expected the index of an input source");
    read_text(IWER_SCHEMA "[1e999, 1, 2, 3, 0, 0, 0, 1]]}", "");
    bad(AP_INPUT, "not JSON");
    read_text("{\"schema\": [], \"frames\": []}", "");
    bad(AP_INPUT, "/schema: expected a list of 1 to 64 input sources");
    read_text(IWER_SCHEMA "]}", "");
    bad(AP_INPUT, "no pose in it");
}

#define POSE(x, ms)                                                                                \
    "{\"position\": {\"x\": " #x ", \"y\": 2, \"z\": 3}, \"rotation\": {\"x\": 30, \"y\": 90, "    \
    "\"z\": 0}, \"timestamp\": " #ms "}"

static void test_aframe(void **unused) {
    (void)unused;
    // A quarter turn about y, then 30 degrees about the new x.
    const double c = cos(15 * DEGREE), s = sin(15 * DEGREE), h = sqrt(0.5);
    static const char *const texts[] = {
        "{\"camera\": {\"poses\": [" POSE(1, 10) ", " POSE(2, 20) ", " POSE(
            3,
            20) "]}, "
                "\"rightHand\": {\"poses\": [" POSE(4, 15) ", " POSE(5, 25) ", " POSE(
                    6,
                    35) "], "
                        "\"events\": [{\"name\": \"triggerdown\", \"timestamp\": 16}, "
                        "{\"name\": \"buttonup\", \"detail\": {\"id\": 1}, \"timestamp\": 30}]}}",
    };
    char wrapped[2048];
    snprintf(wrapped, sizeof wrapped, "\n {\"recording\": %s}", texts[0]);
    for (int i = 0; i < 2; i++) {
        read_text(i ? wrapped : texts[0], "");
        good();
        assert_int_equal(all.count, 5);
        ROW(0, 0, "head", 1, 2, 3, h * s, h * c, -h * s, h * c);
        ROW(1, 5000000, "right", 4, 2, 3, h * s, h * c, -h * s, h * c);
        ROW(2, 10000000, "head", 2, 2, 3, h * s, h * c, -h * s, h * c);
        ROW(3, 15000000, "right", 5, 2, 3, h * s, h * c, -h * s, h * c);
        assert_true(all.rows[3].select && all.rows[3].trigger == 1 && !all.rows[1].select);
        assert_false(all.rows[4].select);
    }
    read_text("{\"camera\": {\"poses\": [" POSE(
                  1, 10) ", {\"position\": null, \"timestamp\": 11}, " POSE(1, 12) "]}}",
              "");
    bad(AP_INPUT, "/camera/poses/1/position: expected an object with x, y and z");
    read_text("{\"camera\": {\"poses\": [" POSE(1, 10) ", " POSE(1, 9) "]}}", "");
    bad(AP_INPUT, "/camera/poses/1: expected a time not before the pose before");
    read_text("{\"camera\": {}}", "");
    bad(AP_INPUT, "expected a motion capture");
    read_text("{\"a b\": {\"poses\": [" POSE(1, 10) "]}}", "");
    bad(AP_INPUT, "with names as in CSV");
}

// BSOR as its specification says, byte by byte.
struct bsor {
    unsigned char bytes[4096];
    size_t len;
};

static void put(struct bsor *b, const void *bytes, size_t len) {
    assert_true(b->len + len <= sizeof b->bytes);
    memcpy(b->bytes + b->len, bytes, len);
    b->len += len;
}

static void put_int(struct bsor *b, int32_t v) {
    for (int i = 0; i < 4; i++)
        put(b, &(unsigned char){(unsigned char)((uint32_t)v >> 8 * i)}, 1);
}

static void put_float(struct bsor *b, float v) {
    int32_t bits;
    memcpy(&bits, &v, 4);
    put_int(b, bits);
}

static void put_string(struct bsor *b, const char *text, int lie) {
    put_int(b, (int32_t)strlen(text) + lie);
    put(b, text, strlen(text));
}

static void bsor_begin(struct bsor *b, int lie) {
    b->len = 0;
    put_int(b, 0x442d3d69);
    put(b, "\1\0", 2);
    for (int i = 0; i < 13; i++)
        put_string(b, i == 4 ? "Somebody" : "text", i == 4 ? lie : 0);
    put_int(b, 123456);
    for (int i = 0; i < 3; i++)
        put_string(b, "", 0);
    put_float(b, 18);
    put(b, "\0", 1);
    for (int i = 0; i < 4; i++)
        put_float(b, 1.7f);
    put(b, "\1", 1);
}

static void bsor_frame(struct bsor *b, float t_s, float x, float w) {
    put_float(b, t_s);
    put_int(b, 90);
    for (int k = 0; k < 3; k++) {
        const float v[7] = {x, 2, 3, 0, 0.6f * w, 0, 0.8f * w};
        for (int i = 0; i < 7; i++)
            put_float(b, k == 1 ? 0 : v[i]); // the left one is not tracked
    }
}

static void test_bsor(void **unused) {
    (void)unused;
    struct bsor b;
    for (int lie = -3; lie <= 3; lie += 3) { // a name's length may be wrong
        bsor_begin(&b, lie);
        put_int(&b, 3);
        bsor_frame(&b, 0, 0, 0); // all zeros
        bsor_frame(&b, 0, 1, 1); // once more at 0: passed over
        bsor_frame(&b, 0.5f, 2, 1);
        put(&b, "\2\0\0\0\0", 5);
        read_bytes(b.bytes, b.len, "", "", false);
        good();
        assert_int_equal(all.count, 2);
        ROW(0, 500000000, "head", 2, 2, -3, 0, -0.6, 0, 0.8);
        ROW(1, 500000000, "right", 2, 2, -3, 0, -0.6, 0, 0.8);
    }
    // Sizes that lie, a quaternion that is none, a time that goes back.
    bsor_begin(&b, 0);
    put_int(&b, 0x7fffffff);
    bsor_frame(&b, 1, 1, 1);
    bsor_frame(&b, 2, 1, 1);
    read_bytes(b.bytes, b.len - 1, "", "", false);
    bad(AP_INPUT, "expected 2147483647 frames as it says; it ends after 1");
    read_bytes(b.bytes, b.len, "", "", true);
    good();
    assert_int_equal(all.count, 4);
    assert_int_equal(all.skipped, 1);
    bsor_begin(&b, 0);
    put_int(&b, 6);
    for (int i = 0; i < 4; i++)
        bsor_frame(&b, (float)i, 1, 1);
    bsor_frame(&b, 2, 1, 1);
    bsor_frame(&b, 4, 1, 0.5f);
    read_bytes(b.bytes, b.len, "", "", false);
    bad(AP_INPUT, "frame 4: expected a time in seconds not before the frame before");
    read_bytes(b.bytes, b.len, "", "", true);
    good();
    assert_int_equal(all.count, 8);
    assert_int_equal(all.skipped, 2);
    for (size_t len = 0; len < b.len; len += 7) { // cut anywhere
        read_bytes(b.bytes, len, "", "", false);
        assert_int_equal(all.status, AP_INPUT);
    }
    b.bytes[4] = 2;
    read_bytes(b.bytes, b.len, "", "", false);
    bad(AP_INPUT, "expected version 1 of BSOR");
}

// A sensor that lies on its side and turns about the vertical, its x axis up.
static void test_imu(void **unused) {
    (void)unused;
    char text[65536] = "#timestamp [ns],w_x,w_y,w_z,a_x,a_y,a_z\r\n";
    size_t n = strlen(text);
    for (int i = 0; i <= 400; i++)
        n += (size_t)snprintf(text + n, sizeof text - n, "%d,%s,0,0,9.81,0,0\r\n", i * 5000000,
                              i > 200 ? "0.8" : "0");
    read_text(text, ",axes=yxz"); // a mirror, so what turns left turns right
    good();
    assert_int_equal(all.count, 401 - 8);
    assert_int_equal(all.rows[0].t_ns, 40000000);
    struct ap_vec3 up = ap_quat_rotate(all.rows[392].pose.q, (struct ap_vec3){0, 1, 0});
    if (!(up.y > 0.99999))
        fail_msg("up is (%g %g %g)", up.x, up.y, up.z);
    double turned = apart_deg(all.rows[0].pose.q, all.rows[392].pose.q);
    if (!(fabs(turned - 0.8 / DEGREE) < 0.3)) // some of it is taken for a bias
        fail_msg("turned by %g degrees, expected %g within 0.3", turned, 0.8 / DEGREE);
    assert_true(all.rows[392].pose.q.y < all.rows[0].pose.q.y); // to the right
    assert_true(all.rows[392].pose.p.y > 1.5);                  // a head
    read_bytes(text, n, "left=", "", false);
    good();
    assert_string_equal(all.names[0], "left");
    assert_true(all.rows[0].pose.p.y < 1.5);
    n += (size_t)snprintf(text + n, sizeof text - n, "2100000000,300,0,0,9.81,0,0\n");
    read_text(text, "");
    bad(AP_INPUT, ":403:12: expected rates below 200 rad/s");
    snprintf(text + n, sizeof text - n, "2100000000,3,0,0,9.81,0\n");
    read_bytes(text, strlen(text), "", "", true);
    good();
    assert_int_equal(all.skipped, 2);
    snprintf(text + n, sizeof text - n, "86402100000000,0,0,0,9.81,0,0\n"); // a day later
    read_bytes(text, strlen(text), "", "", true);
    good();
    assert_true(all.rows[all.count - 1].reset);
}

static void test_named(void **unused) {
    (void)unused;
    static const char head[] =
        "delta_time_ms,note,hmd_pos_x,hmd_pos_y,hmd_pos_z,hmd_rot_x,hmd_rot_y,hmd_rot_z,hmd_rot_w,"
        "left_controller_pos_x,left_controller_pos_y,left_controller_pos_z,left_controller_rot_x,"
        "left_controller_rot_y,left_controller_rot_z,left_controller_rot_w\n";
    char text[1024];
    snprintf(text, sizeof text,
             "%s0,a,100,150,-20,0,0.6,0,0.8,,,,,,,\n"
             "11.25,b,1,2,3,0,0,0,1,10,20,30,1,0,0,0\n",
             head);
    read_text(text, "");
    good();
    assert_int_equal(all.count, 3);
    ROW(0, 0, "head", 1, 1.5, -0.2, 0, 0.6, 0, 0.8); // centimetres
    ROW(1, 11250000, "head", 0.01, 0.02, 0.03, 0, 0, 0, 1);
    ROW(2, 11250000, "left", 0.1, 0.2, 0.3, 1, 0, 0, 0);
    read_text(text, ",scale=1,hand=left");
    good();
    ROW(0, 0, "head", 100, 150, 20, 0, -0.6, 0, 0.8);
    snprintf(text, sizeof text, "%s0,a,100,150,-20,0,0.6,0,,,,,,,,\n", head);
    read_text(text, "");
    bad(AP_INPUT, ":2:5: expected seven numbers of head, or none");
    snprintf(text, sizeof text, "%s0,a,100\n", head);
    read_text(text, "");
    bad(AP_INPUT, ":2:8: expected 16 fields as in the header, not 3");
    read_text("t_ms,pen_pos_x,pen_pos_y\n", "");
    bad(AP_INPUT, ":1:6: expected columns pen_pos_x, _y, _z and pen_rot_x");
    read_text("x,pen_pos_x,pen_pos_y\n", "");
    bad(AP_INPUT, "expected a column of times");
    read_text("time_s,Pen_pos_x,Pen_pos_y,Pen_pos_z,Pen_rot_w,Pen_rot_x,Pen_rot_y,Pen_rot_z\n"
              "1.5,1,2,3,0.8,0,0,0.6\n",
              "");
    good();
    ROW(0, 1500000000, "Pen", 1, 2, 3, 0, 0, 0.6, 0.8);
}

static void test_options(void **unused) {
    (void)unused;
    static const char tum[] = "1 1 2 3 0 0 0.6 0.8\n2 1 2 3 0 0 0 1\n";
    read_text(tum, ",offset=-0.25");
    ROW(0, 750000000, "head", 1, 2, 3, 0, 0, 0.6, 0.8);
    read_text(tum, ",time-scale=0.001,offset=1"); // its times are milliseconds
    ROW(0, 1001000000, "head", 1, 2, 3, 0, 0, 0.6, 0.8);
    read_text(tum, ",scale=0.01,up=z");
    const double h = sqrt(0.5);
    ROW(0, 1000000000, "head", 0.01, 0.03, -0.02, -h * 0.8, h * 0.6, h * 0.6, h * 0.8);
    read_text(tum, ",axes=xz-y"); // the world's and the device's: another vector, the same angle
    ROW(0, 1000000000, "head", 1, 3, -2, 0, 0.6, 0, 0.8);
    read_text(tum, ",hand=left");
    ROW(0, 1000000000, "head", 1, 2, -3, 0, 0, 0.6, 0.8);
    read_text(tum, ",invert=yes");
    ROW(0, 1000000000, "head", -(1 * 0.28 + 2 * 0.96), -(-1 * 0.96 + 2 * 0.28), -3, 0, 0, -0.6,
        0.8);
    read_text(tum, ",frame=optical");
    ROW(0, 1000000000, "head", 1, 2, 3, 0.8, 0.6, 0, 0);
    read_bytes(tum, sizeof tum - 1, "pen=", ",frame=optical,offset=1", false);
    ROW(0, 2000000000, "pen", 1, 2, 3, 0.8, 0.6, 0, 0);
    static const struct {
        const char *options, *error;
    } wrong[] = {{",offset=soon", "offset: expected seconds"},
                 {",scale=0", "scale: expected metres of a unit"},
                 {",scale=nan", "scale: expected metres"},
                 {",time-scale=-1", "time-scale: expected a factor"},
                 {",axes=xxy", "axes: expected its axes"},
                 {",axes=xyzx", "axes: expected its axes"},
                 {",axes=", "axes: expected its axes"},
                 {",hand=both", "hand: expected left or right"},
                 {",up=x", "up: expected y or z"},
                 {",frame=left", "frame: expected head or optical"},
                 {",up=z,invert=1,offset=2", "invert: expected yes or no"}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        read_text(tum, wrong[i].options);
        bad(AP_USAGE, wrong[i].error);
    }
    read_text(tum, ",ofset=1");
    bad(AP_INPUT, "options are offset, time-scale, scale, axes, hand, up, frame and invert");
    read_text("4000000000 1 2 3 0 0 0 1\n", ",offset=1");
    bad(AP_INPUT, ":1:1: expected a time of at most 4e18 ns");
    read_text("1 1e9 2 3 0 0 0 1\n", ",scale=2");
    bad(AP_INPUT, "a place of at most 1e9 m");
}

// Files with commas in their names stay reachable.
static void test_commas(void **unused) {
    (void)unused;
    static const struct {
        const char *name, *argument;
    } files[] = {{"a,b.tum", "a,b.tum"},
                 {"a,up=x=y.tum,", "a,up=x=y.tum,,"},
                 {"a,up=z", "a,up=z,"},
                 {"a,up=z", "a,up=z,,offset=0"},
                 {"a,offset=3,b=c", "a,offset=3,b=c"}};
    char folder[] = "/tmp/antipode-commas-XXXXXX";
    assert_non_null(mkdtemp(folder));
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char path[128], source[160];
        snprintf(path, sizeof path, "%s/%s", folder, files[i].name);
        snprintf(source, sizeof source, "left=%s/%s", folder, files[i].argument);
        FILE *file = fopen(path, "w");
        assert_non_null(file);
        fputs("1 1 2 3 0 0 0 1\n", file);
        fclose(file);
        read_log(source, false);
        good();
        ROW(0, 1000000000, "left", 1, 2, 3, 0, 0, 0, 1);
        unlink(path);
    }
    rmdir(folder);
}

// A tracker that only knows how it is turned: its axes and direction are seen to before the body's
// model puts it somewhere, and scales are none of its.
static void test_recording_options(void **unused) {
    (void)unused;
    static const char hid[] = "D: 0\nR: 12 05 20 0a 83 04 75 10 95 04 81 02 00\nI: 5 054c 0df0\n"
                              "E: 000001.000000 8 00 00 00 00 82 5a 82 5a\n";
    const double h = sqrt(0.5);
    read_text(hid, "");
    good();
    ROW(0, 1000000000, "head", -0.08, 1.58, 0, 0, h, 0, h);
    read_text(hid, ",invert=yes,offset=1");
    ROW(0, 2000000000, "head", 0.08, 1.58, 0, 0, -h, 0, h);
    read_text(hid, ",axes=xz-y,scale=5");
    ROW(0, 1000000000, "head", 0.08, 1.5, -0.08, 0, 0, -h, h);
    read_text(hid, ",hand=left");
    ROW(0, 1000000000, "head", 0.08, 1.58, 0, 0, -h, 0, h);
    read_bytes(hid, sizeof hid - 1, "right=", ",invert=yes", false);
    ROW(0, 1000000000, "right", 0.2 + 0.35, 1.05, 0, 0, -h, 0, h);
}

static void check_in(const char *argument, const char *want) {
    char *got = ap_log_argument_in(argument, "/base");
    assert_string_equal(got, want);
    free(got);
}

// Who passes arguments on to another folder's reader.
static void test_folders(void **unused) {
    (void)unused;
    check_in("a.csv", "/base/a.csv");
    check_in("left=a.csv,up=z", "left=/base/a.csv,up=z");
    check_in("left=/a.csv,up=z", "left=/a.csv,up=z");
    check_in("a,up=z,", "/base/a,up=z,");
    check_in("-,up=z", "-,up=z");
    assert_true(ap_log_argument_is_stdin("-") && ap_log_argument_is_stdin("head=-,offset=1"));
    assert_false(ap_log_argument_is_stdin("-x") || ap_log_argument_is_stdin("a=-b") ||
                 ap_log_argument_is_stdin("./-"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_recordings), cmocka_unit_test(test_iwer),
        cmocka_unit_test(test_aframe),     cmocka_unit_test(test_bsor),
        cmocka_unit_test(test_imu),        cmocka_unit_test(test_named),
        cmocka_unit_test(test_options),    cmocka_unit_test(test_commas),
        cmocka_unit_test(test_folders),    cmocka_unit_test(test_recording_options),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
