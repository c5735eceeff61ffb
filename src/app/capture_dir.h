#ifndef ANTIPODE_APP_CAPTURE_DIR_H
#define ANTIPODE_APP_CAPTURE_DIR_H

#include <stdbool.h>
#include <stdint.h>

#include "src/base/status.h"
#include "src/device/headset.h"
#include "src/scene/scene.h"
#include "src/view/view.h"

// What `replay` leaves in a folder, read back: by `vergence`, and by the page. Beside the pictures
// and tables of docs/capture.md the folder holds capture.json, which makes it self-contained:
// {"antipode_capture": 1, "space": "h3", "radius_m": …, "view": "native", "tracker": "billiards",
//  "table_edge_m": …, "table_height_m": …, "frames": {"total": N, "captured": [0, 75, …]},
//  "born": {"space": "s3", "radius_m": …},
//  "interrupted": false, "log": "name", "command": "…", "headset": {…profile…},
//  "background": "#000000",
//  "targets": [{"name", "color": "#ff2020", "at": [x,y,z,w], "radius_m": …}]}
// "born" is there where the view is native-of. `at` is the target's place in the world, metres. The
// two table members are absent where there is no table, "command" where nobody said how the run was
// started.

struct ap_capture_target {
    char name[64];
    uint8_t color[3];
    struct ap_vec4 at;
    double radius_m;
};

struct ap_capture_frame {
    int64_t frame;
    int64_t t_ns;
    struct ap_iso world_from_head;
    struct ap_pose table_from_head; // as frames.csv has it: what the tracker was fed
};

// One row of frames.csv, of any device and any frame, captured or not: the path of the walk.
struct ap_capture_step {
    int device; // index into devices
    struct ap_vec3 table_p_m;
    struct ap_vec4 world_p; // where the virtual pose puts the device, metres
};

enum { AP_CAPTURE_DEVICES_MAX = 16 };

struct ap_capture {
    char *dir;
    struct ap_space space;
    enum ap_view_mode view;
    struct ap_space born; // of AP_VIEW_BORN
    struct ap_headset_profile headset;
    struct ap_capture_target *targets;
    size_t target_count;
    struct ap_capture_frame *frames; // the captured ones that have a head row in frames.csv
    size_t frame_count;
    char tracker[16], log_name[256], command[1024];
    int64_t total_frames;
    double table_edge_m, table_height_m;
    bool has_table, interrupted;
    uint8_t background[3];
    struct ap_capture_step *steps; // in the order of the file
    size_t step_count;
    char devices[AP_CAPTURE_DEVICES_MAX][64]; // further devices leave no steps
    int device_count;
};

// AP_INPUT where DIR holds no capture, or a broken one.
enum ap_status ap_capture_read(struct ap_error *err, const char *dir, struct ap_capture *capture);
void ap_capture_finish(struct ap_capture *capture);

// Writes DIR/capture.json; the bytes depend on the capture only. frames[].frame is the list of the
// captured frames; times, poses and steps stand in frames.csv and are not written.
enum ap_status ap_capture_write(struct ap_error *err, const char *dir,
                                const struct ap_capture *capture);

// The viewer of a captured frame: its head and the profile's eyes (float32-rounded, as the runtime
// hands them out).
struct ap_viewer ap_capture_viewer(const struct ap_capture *capture, size_t frame);

// How far to the right the right eye's picture must be moved, in widths of it, to lie on the left
// eye's at what is straight ahead, distance_m away (INFINITY: parallel lines of sight). Not 0 where
// the eyes' fields of view are uneven or canted. A comfort for people; 0 where it makes no sense.
double ap_capture_eye_shift(const struct ap_capture *capture, double distance_m);

// "DIR/NNNNNN-SUFFIX", as "left.png"; malloc'ed, NULL without memory.
char *ap_capture_picture_path(const struct ap_capture *capture, int64_t frame, const char *suffix);

#endif
