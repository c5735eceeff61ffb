#ifndef ANTIPODE_APP_PLAY_BODY_H
#define ANTIPODE_APP_PLAY_BODY_H

#include "src/app/play/settings.h"
#include "src/app/room.h"
#include "src/render/renderer.h"
#include "src/track/chaperone.h"
#include "src/track/travel.h"

// From a frame's devices in the room to head and hands in the world: the tracker, going where the
// room does not reach, and what is drawn of both (the geodesic that a hand points along, the fence
// at the room's end).
struct ap_body {
    struct ap_room *room;
    struct ap_travel travel;
    struct ap_chaperone chaperone;
    bool fence;
    size_t first_dot, first_rail; // of the scene's parts
    bool head_known, has_begun;
    int64_t refused;       // poses that were not finite, or too far away to be told
    double fade, vignette; // to be shown in this frame
};

// Adds its parts to the room's scene: before a renderer is made of it. bounds: of the stage, 0
// where the runtime does not say.
enum ap_status ap_body_init(struct ap_error *err, struct ap_room *room, struct ap_body *body);
void ap_body_settle(struct ap_body *body, const struct ap_play_settings *settings, double width_m,
                    double depth_m);

// Places everything; in a world of cells the head is in the middle of one at first. still: sticks
// belong to the menu or the cue, nothing is carried. A pose that is not finite, or too far away to
// be told, is that of a device that is lost.
enum ap_status ap_body_step(struct ap_error *err, struct ap_body *body,
                            const struct ap_xr_frame *frame, bool still,
                            struct ap_frame_input *input);

#endif
