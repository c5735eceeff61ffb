#include "src/device/hid/body_model.h"

#include <string.h>

static const struct ap_vec3 NECK_M = {0, 1.5, 0};      // the pivot
static const struct ap_vec3 EYES_M = {0, 0.08, -0.08}; // from it
static const struct ap_vec3 ELBOW_M = {0.2, 1.05, 0};  // the right one
static const struct ap_vec3 FOREARM_M = {0, 0, -0.35}; // from it to the grip
static const struct ap_vec3 ELSEWHERE_M = {0, 1, 0};

enum ap_body_part ap_body_part_of(const char *role, size_t len) {
    static const char *const names[] = {"head", "left", "right"};
    for (int i = 0; i < 3; i++)
        if (strlen(names[i]) == len && memcmp(names[i], role, len) == 0)
            return (enum ap_body_part)i;
    return AP_BODY_OTHER;
}

struct ap_vec3 ap_body_place(enum ap_body_part part, struct ap_quat q) {
    struct ap_vec3 elbow = ELBOW_M;
    switch (part) {
    case AP_BODY_HEAD:
        return ap_vec3_add(NECK_M, ap_quat_rotate(q, EYES_M));
    case AP_BODY_LEFT_HAND:
        elbow.x = -elbow.x;
        return ap_vec3_add(elbow, ap_quat_rotate(q, FOREARM_M));
    case AP_BODY_RIGHT_HAND:
        return ap_vec3_add(elbow, ap_quat_rotate(q, FOREARM_M));
    case AP_BODY_OTHER:
        break;
    }
    return ELSEWHERE_M;
}
