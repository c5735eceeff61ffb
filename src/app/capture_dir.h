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
//  "interrupted": false, "log": "name", "headset": {…profile…}, "background": "#000000",
//  "targets": [{"name", "color": "#ff2020", "at": [x,y,z,w], "radius_m": …}]}
// `at` is the target's place in the world, metres.

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
};

struct ap_capture {
    char *dir;
    struct ap_space space;
    enum ap_view_mode view;
    struct ap_headset_profile headset;
    struct ap_capture_target *targets;
    size_t target_count;
    struct ap_capture_frame *frames; // the captured ones that have a head row in frames.csv
    size_t frame_count;
    char tracker[16], log_name[256];
    int64_t total_frames;
    double table_edge_m, table_height_m;
    bool has_table, interrupted;
};

// AP_INPUT where DIR holds no capture, or a broken one.
enum ap_status ap_capture_read(struct ap_error *err, const char *dir, struct ap_capture *capture);
void ap_capture_finish(struct ap_capture *capture);

// The viewer of a captured frame: its head and the profile's eyes (float32-rounded, as the runtime
// hands them out).
struct ap_viewer ap_capture_viewer(const struct ap_capture *capture, size_t frame);

#endif
