#include <math.h>

#include "src/device/handlog.h"
#include "tests/device/memory_file.h"
#include "tests/device/mutate.h"

static void require(bool ok, const char *what) {
    if (ok)
        return;
    fprintf(stderr, "broken: %s\n", what);
    abort();
}

// What every hand that comes out promises to everybody behind.
static void check_hand(const struct ap_hand *hand) {
    for (int j = 0; j < AP_JOINT_COUNT; j++) {
        const struct ap_hand_joint *joint = &hand->joint[j];
        struct ap_quat q = joint->pose.q;
        double length = sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
        require(fabs(length - 1) < 1e-14, "unit quaternion");
        require(isfinite(joint->pose.p.x) && isfinite(joint->pose.p.y) && isfinite(joint->pose.p.z),
                "finite");
        require(joint->radius_m >= 0 && joint->radius_m <= 1, "radius");
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len) {
    struct memory_file file = memory_file(bytes, len);
    struct ap_error err = {""};
    struct ap_handlog *log = NULL;
    if (ap_handlog_read(&err, file.path, &log)) {
        require(err.text[0] && !log, "a sentence with the error");
    } else {
        require(ap_handlog_count(log, 0) + ap_handlog_count(log, 1) > 0, "a hand");
        for (int hand = 0; hand < AP_HAND_COUNT; hand++)
            for (int64_t t = -20000000; t < 40000000; t += 5000000) {
                struct ap_hand h;
                if (ap_handlog_at(log, hand, t, &h))
                    check_hand(&h);
            }
    }
    ap_handlog_destroy(log);
    close(file.fd);
    return 0;
}

#ifndef ANTIPODE_LIBFUZZER
int main(int argc, char **argv) {
    static char csv[MUTATE_MAX], json[MUTATE_MAX];
    size_t at = (size_t)sprintf(csv, "t_ns,hand,joint,px,py,pz,qx,qy,qz,qw,radius\n");
    for (int t = 0; t < 2; t++)
        for (int j = 0; j < AP_JOINT_COUNT; j++)
            at += (size_t)sprintf(csv + at, "%d,left,%s,0.1,1,-0.2,0,0.6,0,0.8,0.01\n", 9000000 * t,
                                  ap_joint_name(j));
    at = (size_t)sprintf(json, "{\"schema\":[[2,{\"handedness\":\"left\",\"hasHand\":true}]],"
                               "\"frames\":[");
    for (int t = 0; t < 2; t++) {
        at += (size_t)sprintf(json + at, "%s[%d,0,0,0,0,0,0,1,[2,0,1,0,0,0,0,1,[", t ? "," : "",
                              11 * t);
        for (int j = 0; j < 25; j++)
            at += (size_t)sprintf(json + at, "%s0.1,0,0,0,0,0,1,0.01", j ? "," : "");
        at += (size_t)sprintf(json + at, "]]]");
    }
    sprintf(json + at, "]}");
    const char *const seeds[] = {csv, json, " {", ""};
    static const char *const words[] = {"\n",
                                        ",",
                                        "[",
                                        "]",
                                        "{",
                                        "}",
                                        "nan",
                                        "1e308",
                                        "-",
                                        "0",
                                        "1",
                                        "null",
                                        "left",
                                        "right",
                                        "wrist",
                                        "palm",
                                        "99999999999999999999",
                                        "\"",
                                        "\"hasGrip\":true,",
                                        "1e-400"};
    return mutate_run(seeds, sizeof seeds / sizeof *seeds, words, sizeof words / sizeof *words,
                      argc > 1 ? atoi(argv[1]) : 4000);
}
#endif
