#include "src/device/live/queue.h"

#include <stdlib.h>
#include <string.h>

struct live_queue_report {
    int64_t t_ns;
    size_t len;
};

bool live_queue_init(struct live_queue *queue, unsigned count, size_t report_max) {
    *queue = (struct live_queue){.count = count, .report_max = report_max};
    queue->reports = calloc(count, sizeof *queue->reports);
    queue->bytes = report_max ? calloc(count, report_max) : NULL;
    return queue->reports && queue->bytes;
}

void live_queue_finish(struct live_queue *queue) {
    free(queue->reports);
    free(queue->bytes);
    *queue = (struct live_queue){.count = 0};
}

void live_queue_push(struct live_queue *queue, int64_t t_ns, const uint8_t *bytes, size_t len) {
    unsigned at = queue->head++ % queue->count;
    size_t n = len < queue->report_max ? len : queue->report_max;
    queue->reports[at] = (struct live_queue_report){t_ns, n};
    memcpy(queue->bytes + at * queue->report_max, bytes, n);
    if (queue->head - queue->tail > queue->count)
        queue->tail = queue->head - queue->count;
}

bool live_queue_pop(struct live_queue *queue, uint8_t *bytes, size_t size, size_t *len,
                    int64_t *t_ns) {
    if (live_queue_is_empty(queue))
        return false;
    unsigned at = queue->tail++ % queue->count;
    const struct live_queue_report *r = &queue->reports[at];
    *len = r->len < size ? r->len : size;
    *t_ns = r->t_ns;
    memcpy(bytes, queue->bytes + at * queue->report_max, *len);
    return true;
}
