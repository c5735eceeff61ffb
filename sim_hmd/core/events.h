#ifndef ANTIPODE_SIM_HMD_CORE_EVENTS_H
#define ANTIPODE_SIM_HMD_CORE_EVENTS_H

#include "sim_hmd/core/api.h"

// What waits for xrPollEvent.

enum { SIM_MAX_EVENTS = 128 };

struct sim_events {
    XrEventDataBuffer queue[SIM_MAX_EVENTS];
    XrSession session[SIM_MAX_EVENTS]; // whom it is about
    uint32_t first, count, lost;
};

void sim_events_push(struct sim_events *events, XrSession session, const void *event, size_t size);
bool sim_events_pop(struct sim_events *events, XrEventDataBuffer *event);
void sim_events_forget(struct sim_events *events, XrSession session);

#endif
