#ifndef ANTIPODE_TESTS_APP_PAGE_SYNTH_H
#define ANTIPODE_TESTS_APP_PAGE_SYNTH_H

#include "src/app/capture_dir.h"
#include "src/image/image.h"

// Captures made without a renderer: pictures whose discs are right to a hundredth of a pixel,
// because each pixel on an edge is sampled 64 times by following its own sight line through the
// space (nothing of src/view/silhouette is used).

// An empty folder under /tmp; the caller removes it with synth_remove and frees the name.
char *synth_folder(void);
void synth_remove(char *dir);

// A headset of 300 by 280 pixels, with uneven, canted eyes.
struct ap_headset_profile synth_headset(void);

// A capture of `frames` frames (every second is captured) with a head that turns and sways at
// 0.8 m above the base point, hands, and no targets.
struct ap_capture synth_capture(const char *dir, struct ap_space space, enum ap_view_mode view,
                                int frames);

// Adds a target at `nose_m`, tangent space of the first frame's nose (image 1 in s3: |nose_m| may
// exceed pi·rho, the place is the same point).
void synth_target(struct ap_capture *capture, const char *name, const uint8_t color[3],
                  struct ap_vec3 nose_m, double radius_m);

// Writes capture.json, frames.csv and the pictures of every captured frame.
void synth_write(const struct ap_capture *capture);

// As an eye sees the target, on what is there already. linear light.
void synth_draw(const struct ap_capture *capture, size_t frame, int eye, const uint8_t color[3],
                struct ap_vec4 at, double radius_m, struct ap_image *image);

char *synth_path(const char *dir, const char *name);
void synth_write_text(const char *dir, const char *name, const char *text);
char *synth_read_text(const char *dir, const char *name);

#endif
