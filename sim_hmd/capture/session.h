#ifndef ANTIPODE_SIM_HMD_CAPTURE_SESSION_H
#define ANTIPODE_SIM_HMD_CAPTURE_SESSION_H

#include "sim_hmd/compose/frame.h"
#include "sim_hmd/core/session.h"

// What is captured beside the composed pictures; nothing where the settings ask
// for none. The flush makes all of it whole.
enum ap_status sim_session_capture_open(struct ap_error *err, struct sim_session *session);
enum ap_status sim_session_capture_frame(struct ap_error *err, struct sim_session *session,
                                         const XrFrameEndInfo *info, const struct sim_frame *frame,
                                         bool captured);
enum ap_status sim_session_capture_flush(struct ap_error *err, struct sim_session *session);
void sim_session_capture_close(struct sim_session *session);

#endif
