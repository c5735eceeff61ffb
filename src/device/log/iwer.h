#ifndef ANTIPODE_DEVICE_LOG_IWER_H
#define ANTIPODE_DEVICE_LOG_IWER_H

#include "src/base/json.h"
#include "src/device/log/line_reader.h"
#include "src/geom/pose.h"

// The recorder of IWER (WebXR's emulator): {"schema": [[index, {what an input source has}] …],
// "frames": [[t_ms, head 7, source …] …]} with source = [index, ray 7, then what its schema says it
// has: grip [7], hand [25 joints of 7 and a radius], gamepad [buttons…, axes…]]. Poses are [px, py,
// pz, qx, qy, qz, qw], rounded to 1e-3. Time 0 is the first frame. Hands, inputs and poses are read
// from it by different readers; what is the same for all stands here.

enum { AP_IWER_RAY = 1, AP_IWER_HEAD = 1, AP_IWER_SOURCES_MAX = 64, AP_IWER_BUTTONS_MAX = 64 };

// What a schema says: where the parts of a source stand, 0 for one that it does not have.
struct ap_iwer_source {
    json_int_t index;
    const char *device; // "left", "right"; NULL: in no hand
    size_t grip, hand, gamepad;
    size_t buttons, axes; // of the gamepad
};

// Called for what is in a frame; a status other than AP_OK ends the reading. NULL: not wanted.
struct ap_iwer_visitor {
    void *user;
    enum ap_status (*schema)(struct ap_error *err, void *user, const struct ap_json_at *source,
                             const struct ap_iwer_source *what);
    enum ap_status (*frame)(struct ap_error *err, void *user, int64_t t_ns,
                            const struct ap_json_at *frame);
    enum ap_status (*source)(struct ap_error *err, void *user, const struct ap_iwer_source *what,
                             const struct ap_json_at *source);
    // Something in a frame is bad, for the reason in `why`: AP_OK passes over the frame's rest.
    enum ap_status (*bad)(struct ap_error *err, void *user, const struct ap_error *why);
};

// AP_INPUT with the place in the document: a schema or a frame that is none, a time before the one
// before it.
enum ap_status ap_iwer_visit(struct ap_error *err, const struct ap_json_at *root,
                             const struct ap_iwer_visitor *visitor);

// Reads what is left of a file and visits it.
enum ap_status ap_iwer_read(struct ap_error *err, struct ap_line_reader *reader,
                            const struct ap_iwer_visitor *visitor);

// Numbers of an array from a place on, each at most a kilometre.
enum ap_status ap_iwer_numbers(struct ap_error *err, const struct ap_json_at *array, size_t first,
                               size_t count, double *values);
// Seven of them, with a quaternion that is made unit.
enum ap_status ap_iwer_pose(struct ap_error *err, const struct ap_json_at *array, size_t first,
                            struct ap_pose *pose);

// Button number i: [pressed, touched, value], each from 0 to 1; *there = false for null, zeros
// then.
enum ap_status ap_iwer_button(struct ap_error *err, const struct ap_json_at *gamepad, size_t i,
                              double values[3], bool *there);

#endif
