#include <math.h>

#include "src/device/headset.h"
#include "tests/device/memory_file.h"
#include "tests/device/mutate.h"

static void require(bool ok, const char *what) {
    if (ok)
        return;
    fprintf(stderr, "broken: %s\n", what);
    abort();
}

static void check_profile(const struct ap_headset_profile *p) {
    require(p->refresh_hz > 0 && isfinite(p->refresh_hz) && p->ipd_m > 0 && p->ipd_m <= 1, "rate");
    require(p->name[0] && memchr(p->name, 0, sizeof p->name), "name");
    for (int i = 0; i < 2; i++) {
        const struct ap_eye_profile *e = &p->eye[i];
        require(e->width_px >= 1 && e->width_px <= 16384, "width");
        require(e->height_px >= 1 && e->height_px <= 16384, "height");
        require(e->left_rad < e->right_rad && e->down_rad < e->up_rad, "order of angles");
        require(e->left_rad > -M_PI_2 && e->right_rad < M_PI_2, "angles across");
        require(e->down_rad > -M_PI_2 && e->up_rad < M_PI_2, "angles up");
    }
    // What was taken is written and taken again, the same.
    json_t *json = ap_headset_to_json(p);
    require(json != NULL, "json");
    struct ap_json_at at = ap_json_root(json, "again");
    struct ap_headset_profile again;
    memset(&again, 0, sizeof again);
    require(!ap_headset_parse(NULL, &at, &again), "taken again");
    require(memcmp(again.eye, p->eye, sizeof p->eye) == 0, "the same eyes");
    require(memcmp(&again.grip_from_aim, &p->grip_from_aim, sizeof p->grip_from_aim) == 0, "aim");
    json_decref(json);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len) {
    struct memory_file file = memory_file(bytes, len);
    struct ap_error err = {""};
    struct ap_headset_profile profile;
    if (ap_headset_read(&err, file.path, &profile))
        require(err.text[0], "a sentence with the error");
    else
        check_profile(&profile);
    close(file.fd);
    return 0;
}

#ifndef ANTIPODE_LIBFUZZER
int main(int argc, char **argv) {
    static const char eye[] = "{\"resolution_px\": [1440, 1600], \"fov_rad\": {\"left\": -0.9, "
                              "\"right\": 0.8, \"up\": 0.85, \"down\": -0.85}, \"yaw_rad\": 0.1, "
                              "\"hidden_area\": {\"outside_ellipse\": [0.1, 0, 1, 0.9]}}";
    static char seed[1024];
    snprintf(seed, sizeof seed,
             "{\"name\": \"x\", \"refresh_hz\": 90, \"ipd_m\": 0.064, \"eyes\": {\"left\": %s, "
             "\"right\": %s}, \"grip_from_aim\": {\"position_m\": [0, 0, -0.05], "
             "\"rotate\": [0, 0, 0.6, 0.8]}}",
             eye, eye);
    const char *const seeds[] = {seed};
    static const char *const words[] = {"0", "1", "-",  "e308", ".5",   "{",   "}",     "[",   "]",
                                        ",", ":", "\"", "null", "true", "9e9", "16385", "1e-9"};
    return mutate_run(seeds, 1, words, sizeof words / sizeof *words,
                      argc > 1 ? atoi(argv[1]) : 30000);
}
#endif
