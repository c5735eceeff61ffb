#ifndef ANTIPODE_APP_PLAY_LINES_H
#define ANTIPODE_APP_PLAY_LINES_H

#include "src/game/physics.h"
#include "src/scene/scene.h"

// The path of the next shot, for practice: small balls along the exact ways of the balls' centres,
// a part's number of them, in the order of time; and one that marks where the eyes rest.
struct ap_play_lines {
    struct ap_scene *scene; // borrowed
    size_t first, mark;
};

enum { AP_PLAY_LINE_DOTS = 64 };

// Adds its parts to the scene: before a renderer is made of it.
enum ap_status ap_play_lines_init(struct ap_error *err, struct ap_scene *scene,
                                  struct ap_play_lines *lines);

// What the stroke would do, on a copy; NULL: nothing is shown. How many dots there are.
int ap_play_lines_show(struct ap_play_lines *lines, const struct ap_physics *physics,
                       const struct ap_strike *strike);

// A point of the table's plane; NULL: none.
void ap_play_lines_mark(struct ap_play_lines *lines, const struct ap_plane3 *point_m);

#endif
