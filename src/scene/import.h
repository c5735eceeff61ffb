#ifndef ANTIPODE_SCENE_IMPORT_H
#define ANTIPODE_SCENE_IMPORT_H

#include "src/scene/build.h"

enum { AP_MODEL_MAX_VERTICES = 5000000 };

// Reads and adds the model in this process, which a hostile file may end: ap_build_model calls it
// in another one.
enum ap_status ap_import_model(struct ap_error *err, struct ap_scene_build *build,
                               const struct ap_model_request *request);

// How far from its place a model's vertices may be, metres.
double ap_model_reach(struct ap_space space);

#endif
