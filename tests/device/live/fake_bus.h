#ifndef ANTIPODE_TESTS_DEVICE_LIVE_FAKE_BUS_H
#define ANTIPODE_TESTS_DEVICE_LIVE_FAKE_BUS_H

#include <pthread.h>
#include <stdbool.h>

#include "src/device/live/io.h"

// The way to devices without devices: the test plugs them in, sends their reports, sets the clock
// and says what fails.

enum { FAKE_DEVICES = 80, FAKE_QUEUE = 63, FAKE_SENT = 64 };

struct fake_report {
    size_t len;
    uint8_t bytes[128];
};

struct fake_device {
    bool plugged, dying, open, refuses_open, refuses_features;
    int tag, opened_count;
    struct ap_live_place place;
    struct fake_report queue[FAKE_QUEUE]; // as hidraw's: what does not fit is dropped
    int queued, dropped;
    int feature_count;
    struct fake_report features[8];
    int sent_count; // feature and output reports that were sent to it
    struct fake_report sent[FAKE_SENT];
    int64_t sent_ns[FAKE_SENT];
};

struct fake_bus {
    pthread_mutex_t lock;
    pthread_cond_t changed;
    int64_t now_ns;
    bool woken, roused, destroyed;
    bool held;   // reads wait: the reader is elsewhere
    int waiting; // readers with nothing to do, since anybody was last roused
    int watching;
    struct fake_device devices[FAKE_DEVICES];
};

struct fake_bus *fake_bus_create(int64_t now_ns);
void fake_bus_free(struct fake_bus *fake); // after ap_live_close
struct ap_live_bus fake_way(struct fake_bus *fake);

// `descriptor` in hexadecimal. The device's number.
int fake_plug(struct fake_bus *fake, const char *serial, uint16_t bus, uint16_t vendor,
              uint16_t product, const char *name, const char *descriptor);
// A copy of a place that was made by hand.
int fake_plug_place(struct fake_bus *fake, const struct ap_live_place *place);
void fake_unplug(struct fake_bus *fake, int device);
// As the kernel does it: reads fail, and its node, which does not open any more, is listed until
// fake_unplug.
void fake_begin_unplug(struct fake_bus *fake, int device);
void fake_replug(struct fake_bus *fake, int device, const char *path);
void fake_feature(struct fake_bus *fake, int device, const uint8_t *bytes, size_t len);
void fake_send(struct fake_bus *fake, int device, const uint8_t *bytes, size_t len);
void fake_set_now(struct fake_bus *fake, int64_t now_ns);
// The reader does not look, as if the machine had something better to do.
void fake_hold(struct fake_bus *fake, bool held);
// Until the reader has read everything and the keeper has nothing to do; false after 5 s.
bool fake_settle(struct fake_bus *fake);

#endif
