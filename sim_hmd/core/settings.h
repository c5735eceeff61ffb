#ifndef ANTIPODE_SIM_HMD_CORE_SETTINGS_H
#define ANTIPODE_SIM_HMD_CORE_SETTINGS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "src/base/range.h"
#include "src/base/status.h"
#include "src/device/headset.h"
#include "src/device/poselog.h"
#include "src/device/walk.h"

// The simulated headset's settings: README.md's table. Read once, at xrCreateInstance.

enum sim_poses { SIM_POSES_WALK, SIM_POSES_LOGS, SIM_POSES_WINDOW, SIM_POSES_DEVICES };
enum { SIM_MAX_RATES = 16, SIM_MAX_RECENTRE_TIMES = 64 };
enum sim_clock { SIM_CLOCK_REAL, SIM_CLOCK_VIRTUAL };

// What of the two eyes the window shows.
enum sim_layout {
    SIM_LAYOUT_PAIR, // side by side
    SIM_LAYOUT_LEFT, // one eye only; the other is not composed for it
    SIM_LAYOUT_RIGHT,
    SIM_LAYOUT_CROSS,    // side by side, for crossed eyes
    SIM_LAYOUT_ANAGLYPH, // red and cyan
    SIM_LAYOUT_COUNT
};

struct sim_texts {
    char **text;
    size_t count;
};

// poses {"devices": …}: src/device/live/live.h says what they mean.
struct sim_device_settings {
    struct sim_texts assign, position, replay, bus;
    char *calibration; // the folder; NULL: none
    bool stats;
};

struct sim_settings {
    struct ap_headset_profile profile; // refresh_hz already overridden
    double rates_hz[SIM_MAX_RATES];    // that a program may ask for, rising; the profile's is one
    size_t rate_count;
    enum sim_poses poses;
    enum sim_clock clock;
    char **logs; // "[role=]PATH", paths made absolute or relative to the process
    size_t log_count;
    struct sim_device_settings devices;
    char *hands;   // recorded bare hands; NULL: none
    char **inputs; // input logs
    size_t input_count;
    double recentre_s[SIM_MAX_RECENTRE_TIMES]; // after the first frame, rising
    size_t recentre_count;
    int controllers; // of sim_profiles: what the hands hold where the program knows it
    bool z_up, skip_bad, has_table;
    enum ap_head_frame head_frame;
    double table_x_m, table_z_m, table_yaw_rad;
    struct ap_walk_params walk;
    int64_t frames;    // 0: no limit
    char *capture_dir; // NULL: no capture
    // What of a captured frame is written: the composed picture, through the lens or not; what the
    // program submitted; a line of frames.jsonl for frames that are not captured, too.
    bool capture_composed, capture_lens, capture_layers, capture_log_all;
    bool capture_raw; // PAM, not PNG
    struct ap_range capture_frames;
    bool draw_all; // on the virtual clock, too, frames that nobody looks at have shouldRender
    bool window;
    enum sim_layout window_layout;
    bool strict;         // a lint for the program: strict/strict.h
    char *strict_report; // NULL: standard error only
};

// path NULL: the defaults. AP_INPUT with the place in the file.
enum ap_status sim_settings_read(struct ap_error *err, const char *path,
                                 struct sim_settings *settings);
void sim_settings_finish(struct sim_settings *settings);

// True where the settings ask for this frame's pictures.
bool sim_settings_captures(const struct sim_settings *settings, int64_t frame);

#endif
