#ifndef ANTIPODE_RENDER_PASS_KIND_H
#define ANTIPODE_RENDER_PASS_KIND_H

#include <stdbool.h>

#include "src/render/pass/pass.h"
#include "src/scene/scene.h"

// Which pipeline draws what. Pure.

// What draws a part that needs no guard. plain: without finishes (ap_frame_input).
enum ap_pipeline_kind ap_pipeline_for(const struct ap_part *part, bool plain);
// The same with every fragment looked at; unless one_sided, backs of what is closed, too.
enum ap_pipeline_kind ap_pipeline_looked_at(enum ap_pipeline_kind pipeline, bool one_sided);
// The same with its depth taken from the surface.
enum ap_pipeline_kind ap_pipeline_exact(enum ap_pipeline_kind pipeline);

bool ap_pipeline_is_guarded(enum ap_pipeline_kind pipeline);
// It does not draw back faces.
bool ap_pipeline_is_closed(enum ap_pipeline_kind pipeline);

#endif
