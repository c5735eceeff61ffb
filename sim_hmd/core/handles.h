#ifndef ANTIPODE_SIM_HMD_CORE_HANDLES_H
#define ANTIPODE_SIM_HMD_CORE_HANDLES_H

#include <stdbool.h>
#include <stdint.h>

#include "sim_hmd/core/hot.h"

// OpenXR handles. A handle is not a pointer but a place in a table, the generation of that place
// and the type, so that a destroyed, foreign or random one is told from a live one without touching
// memory that is not ours. Everything here is called with the runtime's lock held.

enum sim_type {
    SIM_INSTANCE = 1,
    SIM_SESSION,
    SIM_SPACE,
    SIM_SWAPCHAIN,
    SIM_ACTION_SET,
    SIM_ACTION,
    SIM_HAND_TRACKER,
    SIM_DEBUG_MESSENGER,
};

// The first member of every object.
struct sim_object {
    enum sim_type type;
    uint64_t handle;
    struct sim_object *parent, *first_child, *next; // next: among the parent's children
    void (*free)(struct sim_object *object);
};

// False where the table is full or memory ran out; then nothing has changed.
bool sim_object_add(struct sim_object *object, enum sim_type type, struct sim_object *parent,
                    void (*free)(struct sim_object *object));

// NULL where the handle is not that of a live object of this type.
void *sim_object_get(uint64_t handle, enum sim_type type);

// Children first, each freed by its own function.
void sim_object_destroy(struct sim_object *object);

// Live objects, for tests of leaks.
int sim_object_count(void);

// The runtime's one lock. SIM_LOCKED holds it to the end of the block it stands in.
void sim_lock(void);
void sim_unlock(void);
// Called, where it is not NULL, each time that the lock was given up.
extern void (*_Atomic sim_after_unlock)(void);
int sim_lock_scope(void);
void sim_unlock_scope(int *scope);
#define SIM_LOCKED                                                                                 \
    __attribute__((cleanup(sim_unlock_scope), unused)) int sim_locked = sim_lock_scope()

// Both give the lock up; every object may be gone afterwards.
// Waits for the next sim_wake.
void sim_wait(void);
void sim_wake(void);
// Waits until the machine's monotonic clock reaches t_ns.
void sim_sleep_until(int64_t t_ns);

#endif
