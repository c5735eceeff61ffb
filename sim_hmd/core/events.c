#include <string.h>

#include "sim_hmd/core/events.h"

static uint32_t place(const struct sim_events *events, uint32_t i) {
    return (events->first + i) % SIM_MAX_EVENTS;
}

void sim_events_push(struct sim_events *events, XrSession session, const void *event, size_t size) {
    if (events->count == SIM_MAX_EVENTS) { // nobody polls: the oldest goes
        events->first = place(events, 1);
        events->count--;
        events->lost++;
    }
    uint32_t at = place(events, events->count++);
    memset(&events->queue[at], 0, sizeof events->queue[at]);
    memcpy(&events->queue[at], event, size);
    events->session[at] = session;
}

bool sim_events_pop(struct sim_events *events, XrEventDataBuffer *event) {
    if (events->lost) {
        XrEventDataEventsLost lost = {.type = XR_TYPE_EVENT_DATA_EVENTS_LOST,
                                      .lostEventCount = events->lost};
        memcpy(event, &lost, sizeof lost);
        events->lost = 0;
        return true;
    }
    if (!events->count)
        return false;
    *event = events->queue[events->first];
    events->first = place(events, 1);
    events->count--;
    return true;
}

void sim_events_forget(struct sim_events *events, XrSession session) {
    uint32_t kept = 0;
    for (uint32_t i = 0; i < events->count; i++) {
        uint32_t from = place(events, i), to = place(events, kept);
        if (events->session[from] == session)
            continue;
        events->queue[to] = events->queue[from];
        events->session[to] = events->session[from];
        kept++;
    }
    events->count = kept;
}
