#include "sim_hmd/core/handles.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdlib.h>
#include <time.h>

#include "src/base/clock.h"

// Handle: generation in the upper 32 bits, type in the next 8, place + 1 in the lower 24.
enum { MAX_OBJECTS = (1 << 24) - 2, FIRST_CAPACITY = 64 };

struct slot {
    struct sim_object *object; // NULL: free
    uint32_t generation;
    uint32_t next_free; // place + 1; 0: none
};

static struct slot *slots;
static uint32_t slot_count, slot_capacity, first_free;
static int live_count;

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t changed;
static int waiting; // threads in sim_wait

// Places are never handed out again in the order they were freed with the same generation; the
// table itself lives as long as the library, so that old handles stay recognisable.
static bool grow(void) {
    if (slot_count < slot_capacity)
        return true;
    uint32_t capacity = slot_capacity ? 2 * slot_capacity : FIRST_CAPACITY;
    if (slot_count >= MAX_OBJECTS)
        return false;
    struct slot *bigger = realloc(slots, capacity * sizeof *slots);
    if (!bigger)
        return false;
    slots = bigger;
    slot_capacity = capacity;
    return true;
}

bool sim_object_add(struct sim_object *object, enum sim_type type, struct sim_object *parent,
                    void (*free_object)(struct sim_object *object)) {
    uint32_t place;
    if (first_free) {
        place = first_free - 1;
        first_free = slots[place].next_free;
    } else {
        if (!grow())
            return false;
        place = slot_count++;
        slots[place].generation = 1;
    }
    slots[place].object = object;
    object->type = type;
    object->handle =
        (uint64_t)slots[place].generation << 32 | (uint64_t)type << 24 | (uint64_t)(place + 1);
    object->parent = parent;
    object->first_child = NULL;
    object->next = NULL;
    object->free = free_object;
    if (parent) {
        object->next = parent->first_child;
        parent->first_child = object;
    }
    live_count++;
    return true;
}

SIM_HOT void *sim_object_get(uint64_t handle, enum sim_type type) {
    uint32_t place = (uint32_t)(handle & 0xffffff);
    if (place == 0 || place > slot_count)
        return NULL;
    struct sim_object *object = slots[place - 1].object;
    return object && object->handle == handle && object->type == type ? object : NULL;
}

static void unlink_from_parent(struct sim_object *object) {
    if (!object->parent)
        return;
    struct sim_object **at = &object->parent->first_child;
    while (*at != object)
        at = &(*at)->next;
    *at = object->next;
}

void sim_object_destroy(struct sim_object *object) {
    while (object->first_child)
        sim_object_destroy(object->first_child);
    unlink_from_parent(object);
    uint32_t place = (uint32_t)(object->handle & 0xffffff) - 1;
    slots[place].object = NULL;
    slots[place].generation++;
    slots[place].next_free = first_free;
    first_free = place + 1;
    live_count--;
    object->free(object);
}

// The loader unloads the library with the instance.
__attribute__((destructor)) static void forget_slots(void) {
    free(slots);
}

int sim_object_count(void) {
    return live_count;
}

static void make_changed(void) {
    pthread_condattr_t attr;
    pthread_condattr_init(&attr);
    pthread_condattr_setclock(&attr, CLOCK_MONOTONIC);
    pthread_cond_init(&changed, &attr);
    pthread_condattr_destroy(&attr);
}

// A fork's child has the parent's memory, but neither its threads nor its device: it is left
// without handles, so that whatever it calls, at exit perhaps, touches no file of the parent's and
// waits for no thread. An instance of its own it may make.
static struct slot *volatile parents; // where a leak checker finds what is not freed

static void forget_in_child(void) {
    parents = slots;
    slots = NULL;
    slot_count = slot_capacity = first_free = 0;
    live_count = 0;
    waiting = 0;
    atomic_init(&sim_after_unlock, (void (*)(void))0);
    pthread_mutex_init(&mutex, NULL); // another thread may have held it
    make_changed();
}

// With the library, not with the first call, which would make every call ask.
__attribute__((constructor)) static void set_up(void) {
    make_changed();
    pthread_atfork(NULL, NULL, forget_in_child);
}

SIM_HOT void sim_lock(void) {
    pthread_mutex_lock(&mutex);
}

void (*_Atomic sim_after_unlock)(void);

SIM_HOT void sim_unlock(void) {
    pthread_mutex_unlock(&mutex);
    void (*then)(void) = atomic_load_explicit(&sim_after_unlock, memory_order_relaxed);
    if (then)
        then();
}

SIM_HOT int sim_lock_scope(void) {
    sim_lock();
    return 0;
}

SIM_HOT void sim_unlock_scope(int *scope) {
    (void)scope;
    sim_unlock();
}

void sim_wait(void) {
    waiting++;
    pthread_cond_wait(&changed, &mutex);
    waiting--;
}

// Not on the condition variable with a time limit, which costs a frame 3 µs more. Nobody who ends
// the session waits for this: it finds out when the display period is over.
SIM_HOT void sim_sleep_until(int64_t t_ns) {
    sim_unlock();
    ap_clock_sleep_until_ns(t_ns);
    sim_lock();
}

SIM_HOT void sim_wake(void) {
    if (waiting)
        pthread_cond_broadcast(&changed);
}
