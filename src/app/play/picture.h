#ifndef ANTIPODE_APP_PLAY_PICTURE_H
#define ANTIPODE_APP_PLAY_PICTURE_H

#include "src/gpu/gpu.h"

// A picture of both eyes as they were drawn, onto disk: antipode-NNN-left.png, -right.png, -sbs.png
// in a folder, by the first number that is free.
struct ap_play_picture {
    VkImage image[2];
    uint32_t layer[2];
    VkFormat format;
    uint32_t width_px, height_px;
};

// Reads the images back (COLOR_ATTACHMENT_OPTIMAL before and after, TRANSFER_SRC usage) and waits
// for it. name: what was written, for people, at most 64 bytes.
enum ap_status ap_play_picture_write(struct ap_error *err, const struct ap_gpu *gpu,
                                     const struct ap_play_picture *picture, const char *folder,
                                     char name[64]);

#endif
