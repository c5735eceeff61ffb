#ifndef ANTIPODE_SIM_HMD_CORE_LAYERS_H
#define ANTIPODE_SIM_HMD_CORE_LAYERS_H

#include "sim_hmd/compose/frame.h"
#include "sim_hmd/core/session.h"

// Verifies what xrEndFrame was given and resolves it.
XrResult sim_layers_resolve(struct sim_session *session, const XrFrameEndInfo *info,
                            struct sim_frame *frame);

#endif
