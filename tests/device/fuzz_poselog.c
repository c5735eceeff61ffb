#include <math.h>

#include "src/device/timeline.h"
#include "tests/device/memory_file.h"
#include "tests/device/mutate.h"

static void require(bool ok, const char *what) {
    if (ok)
        return;
    fprintf(stderr, "broken: %s\n", what);
    abort();
}

// What every sample that comes out promises to everybody behind.
static void check_sample(const struct ap_sample *s, int64_t before) {
    double q = sqrt(s->pose.q.x * s->pose.q.x + s->pose.q.y * s->pose.q.y +
                    s->pose.q.z * s->pose.q.z + s->pose.q.w * s->pose.q.w);
    require(fabs(q - 1) < 1e-14, "unit quaternion");
    require(isfinite(s->pose.p.x) && isfinite(s->pose.p.y) && isfinite(s->pose.p.z), "finite");
    require(s->trigger >= 0 && s->trigger <= 1 && s->squeeze >= 0 && s->squeeze <= 1, "0 to 1");
    require(s->t_ns >= before, "order of times");
}

static void read_log(const struct ap_poselog_params *params) {
    struct ap_error err = {""};
    struct ap_poselog *log = NULL;
    if (ap_poselog_open(&err, params, &log)) {
        require(err.text[0] && !log, "a sentence with the error");
        return;
    }
    int64_t before = INT64_MIN;
    bool got = true;
    while (got) {
        struct ap_sample sample;
        if (ap_poselog_next(&err, log, &sample, &got)) {
            require(err.text[0], "a sentence with the error");
            break;
        }
        if (!got)
            break;
        check_sample(&sample, before);
        before = sample.t_ns;
        require(sample.device < ap_poselog_device_count(log), "device");
        const char *text;
        size_t len;
        if (ap_poselog_column(log, "note", &text, &len))
            require(!memchr(text, ',', len), "column text");
    }
    ap_poselog_close(log);
}

static void read_timeline(const struct ap_poselog_params *params) {
    struct ap_poselog *log = NULL;
    struct ap_timeline *t = NULL;
    if (!ap_poselog_open(NULL, params, &log) && !ap_timeline_load(NULL, log, &t)) {
        int64_t start = ap_timeline_start_ns(t), frames = ap_timeline_frame_count(t, 90);
        require(frames >= 1 && ap_frame_time_ns(start, frames, 90) > ap_timeline_end_ns(t),
                "number of frames");
        for (int i = 0; i < 8; i++) {
            struct ap_sample sample = {.pose = AP_POSE_IDENTITY};
            int64_t t_ns = ap_frame_time_ns(start, frames * i / 8, 90);
            ap_timeline_at(t, i % 3, t_ns, &sample);
            check_sample(&sample, INT64_MIN);
        }
    }
    ap_timeline_destroy(t);
    ap_poselog_close(log);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len) {
    struct memory_file file = memory_file(bytes, len);
    char hand[96];
    snprintf(hand, sizeof hand, "left=%s,offset=1.5,axes=xz-y,invert=yes", file.path);
    const char *sources[] = {file.path, hand};
    struct ap_poselog_params params = {.sources = sources, .source_count = 1};
    read_log(&params);
    params.skip_bad = true;
    read_timeline(&params);
    params.source_count = 2;
    params.z_up = true;
    params.head_frame = AP_HEAD_FRAME_OPTICAL;
    params.has_table = true;
    params.table_x_m = 1;
    params.table_yaw_rad = 1;
    read_log(&params);
    close(file.fd);
    return 0;
}

#ifndef ANTIPODE_LIBFUZZER
#include "tests/device/log_seeds.h"

int main(int argc, char **argv) {
    static const char *const texts[] = {
        "t_ns,device,px,py,pz,qx,qy,qz,qw,trigger,squeeze,select,note\n"
        "0,head,0.1,1.6,-0.2,0,0,0,1,,,,a\n0,left,0.1,1.1,-0.2,0,1,0,0,0.5,1,1,b\n"
        "11111111,head,0.1,1.6,-0.2,0,0.6,0,0.8,0,0,0,c\n",
        "# TUM\n1311868163.8697 -0.1357 -1.4217 1.4764 0.6453 -0.5498 0.3363 -0.4101\n"
        "1311868163.8731 -0.1357 -1.4218 1.4764 0.6454 -0.5497 0.3361 -0.4102\r\n",
        "#timestamp,p_x\n1403636580838555648,4.6,-1.7,0.8,0.53,-0.15,-0.82,-0.08,0.1,0.2\n"
        "1403636580843555328,4.6,-1.7,0.8,0.53,-0.15,-0.82,-0.08,0.1,0.2\n",
        "\xef\xbb\xbf\r\n",
        "D: 0\nR: 2 05 01\nE: 000000.000000 1 00\n",
        "# F: 2 01 1f\nD: 0\nR: 12 05 20 0a 83 04 75 10 95 04 81 02 00\nN: a b\nP: \nI: 5 054c "
        "0df0\nE: 000000.000000 8 00 00 00 00 00 00 ff 7f\nE: 000000.010000 8 00 00 00 00 82 5a "
        "82 5a\nD: 1\nI: 3 1209 7690\nE: 000000.010000 32 ff 00 01 00 00 ee ff c0 00 00 00 00 00 "
        "00 00 00 01 00 00 00 00 00 82 5a 82 5a 00 00 00 00 00 00\n",
        "",
        "#timestamp,w_x,w_y,w_z,a_x,a_y,a_z\n0,0,0,0,0,9.8,0\n5000000,0,1,0,0,9.8,0\n"
        "10000000,0,1,0,0,9.8,0\n15000000,0,1,0,0,9.8,0\n20000000,0,1,0,0,9.8,0\n"
        "25000000,0,1,0,0,9.8,0\n30000000,0,1,0,0,9.8,0\n35000000,0,1,0,0,9.8,0\n"
        "40000000,0,1,0,0,9.8,0\n45000000,0,1,0,0,9.8,0\n50000000,0,1,0,0,9.8,0\n",
        "delta_time_ms,hmd_pos_x,hmd_pos_y,hmd_pos_z,hmd_rot_x,hmd_rot_y,hmd_rot_z,hmd_rot_w,"
        "left_hand_pos_x,left_hand_pos_y,left_hand_pos_z,left_hand_rot_x,left_hand_rot_y,"
        "left_hand_rot_z,left_hand_rot_w\n0,1,150,2,0,0,0,1,,,,,,,\n11,1,2,3,0,0.6,0,0.8,"
        "1,2,3,0,0,1,0\n",
        "{\"schema\":[[0,{\"handedness\":\"left\",\"hasGrip\":true,\"hasGamepad\":true,"
        "\"numButtons\":2,\"numAxes\":2}],[3,{\"handedness\":\"right\"}]],\"frames\":"
        "[[5,1,2,3,0,0,0,1,[0,1,2,3,0,0,0,1,[1,2,3,0,0,0,1],[[1,1,1],null,0.5,0]]],"
        "[16.1,1,2,3,0,0,0,1,[3,1,2,3,0,0,0,1]]]}",
        "{\"recording\":{\"camera\":{\"poses\":[{\"position\":{\"x\":1,\"y\":2,\"z\":3},"
        "\"rotation\":{\"x\":10,\"y\":20,\"z\":30},\"timestamp\":5}]},\"leftHand\":{\"poses\":"
        "[{\"position\":{\"x\":1,\"y\":2,\"z\":3},\"rotation\":{\"x\":10,\"y\":20,\"z\":30},"
        "\"timestamp\":6}],\"events\":[{\"name\":\"buttondown\",\"detail\":{\"id\":1},"
        "\"timestamp\":5}]}}}",
    };
    static const char *const words[] = {"\n",
                                        "\r\n",
                                        ",",
                                        " ",
                                        "#",
                                        "nan",
                                        "-",
                                        "e",
                                        "1e308",
                                        "9223372036854775807",
                                        "0",
                                        "1",
                                        "head",
                                        "left",
                                        ".",
                                        "\xef\xbb\xbf",
                                        "\t",
                                        "99999999999999999999999",
                                        "1e-400",
                                        "t_ns",
                                        "D: 1",
                                        "E: 1.5 1 00",
                                        "{",
                                        "}",
                                        "[",
                                        "]",
                                        "null",
                                        "\"poses\":",
                                        "\xff\xff\xff\x7f",
                                        "\x28\xb5\x2f\xfd",
                                        "\x1f\x8b\x08",
                                        "1e999"};
    enum { TEXTS = sizeof texts / sizeof *texts };
    struct mutate_seed seeds[TEXTS + 3] = {MUTATE_SEED(bsor), MUTATE_SEED(gzipped),
                                           MUTATE_SEED(zstandard)};
    for (int i = 0; i < TEXTS; i++)
        seeds[3 + i] = (struct mutate_seed){texts[i], strlen(texts[i])};
    return mutate_run_seeds(seeds, TEXTS + 3, words, sizeof words / sizeof *words,
                            argc > 1 ? atoi(argv[1]) : 8000);
}
#endif
