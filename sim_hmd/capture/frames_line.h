#ifndef ANTIPODE_SIM_HMD_CAPTURE_FRAMES_LINE_H
#define ANTIPODE_SIM_HMD_CAPTURE_FRAMES_LINE_H

#include "sim_hmd/capture/frames_log.h"

// One line of frames.jsonl as text that grows.
struct sim_line {
    char *text;
    size_t len, room;
    bool failed; // no memory
};

// Replaces what the line holds; ends in a newline.
void sim_line_write(struct sim_line *line, const struct sim_settings *settings,
                    const struct sim_logged_frame *logged);

#endif
