#ifndef ANTIPODE_TESTS_RENDER_CLOSED_WORLD_H
#define ANTIPODE_TESTS_RENDER_CLOSED_WORLD_H

#include "src/scene/scene.h"

// A world of cells by its name, whose walls have no windows and are grey, before white: from inside
// of a cell nothing else is seen. Ends the process where it cannot be made.
struct ap_scene *closed_world(const char *name);

#endif
