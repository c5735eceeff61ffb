#ifndef ANTIPODE_TESTS_VM_READING_H
#define ANTIPODE_TESTS_VM_READING_H

#include "tests/vm/player.h"

// What the readers share: every report that arrives is looked for in the recording that is played,
// from the one before on, so that loss, order and repetition are seen, and the time since it was
// sent.
struct reading {
    struct player player; // its recording
    int64_t wanted;       // how many to read
    const char *sent_log; // the player's, or NULL
    int64_t next;         // the index that is due
    int64_t count, lost, strange;
    int64_t *index, *t_ns; // of each report that was read
};

void reading_open(struct reading *r, const char *recording, int64_t wanted);

// A report has arrived. The first may be any of the recording.
void reading_add(struct reading *r, const uint8_t *bytes, size_t len);

// One line: "read N lost L strange S first F latency median … p99 … us" (without a sent log: no
// latency).
void reading_tell(const struct reading *r);

#endif
