#ifndef ANTIPODE_DEVICE_LIVE_QUEUE_H
#define ANTIPODE_DEVICE_LIVE_QUEUE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// Reports that have come and that nobody has read yet, each with its time. When it is full the
// oldest goes. No lock of its own.
struct live_queue {
    unsigned head, tail; // written, read
    unsigned count;      // of places
    size_t report_max;   // bytes; what is longer is cut
    struct live_queue_report *reports;
    uint8_t *bytes;
};

// False without memory; finish is due all the same.
bool live_queue_init(struct live_queue *queue, unsigned count, size_t report_max);
void live_queue_finish(struct live_queue *queue);

static inline bool live_queue_is_empty(const struct live_queue *queue) {
    return queue->tail == queue->head;
}

void live_queue_push(struct live_queue *queue, int64_t t_ns, const uint8_t *bytes, size_t len);
// False where it is empty. What does not fit into `size` is cut.
bool live_queue_pop(struct live_queue *queue, uint8_t *bytes, size_t size, size_t *len,
                    int64_t *t_ns);

#endif
