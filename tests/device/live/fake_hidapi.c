#include "tests/device/live/fake_hidapi.h"

#include <hidapi.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

struct hid_device_ {
    int number; // in fake_hid
    bool is_open, busy;
};

static struct {
    bool plugged;
    int head, tail;
    uint8_t bytes[FAKE_HID_QUEUE][64];
    size_t len[FAKE_HID_QUEUE];
} state[FAKE_HID_DEVICES];

struct fake_hid fake_hid[FAKE_HID_DEVICES];
static struct hid_device_ handles[2 * FAKE_HID_DEVICES];
static struct hid_device_info infos[3 * FAKE_HID_DEVICES];
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t changed = PTHREAD_COND_INITIALIZER;
static bool held, is_started;

void fake_hid_reset(void) {
    memset(fake_hid, 0, sizeof fake_hid);
    memset(state, 0, sizeof state);
    held = false;
}

void fake_hid_plug(int device, bool plugged) {
    pthread_mutex_lock(&lock);
    state[device].plugged = plugged;
    pthread_cond_broadcast(&changed);
    pthread_mutex_unlock(&lock);
}

void fake_hid_report(int device, const uint8_t *bytes, size_t len) {
    pthread_mutex_lock(&lock);
    int at = state[device].head++ % FAKE_HID_QUEUE;
    memcpy(state[device].bytes[at], bytes, len);
    state[device].len[at] = len;
    pthread_cond_broadcast(&changed);
    pthread_mutex_unlock(&lock);
}

void fake_hid_hold(bool is_held) {
    pthread_mutex_lock(&lock);
    held = is_held;
    pthread_cond_broadcast(&changed);
    pthread_mutex_unlock(&lock);
}

int fake_hid_users(void) {
    return is_started;
}

// Twice is once, as in the library.
int hid_init(void) {
    is_started = true;
    return 0;
}

int hid_exit(void) {
    is_started = false;
    return 0;
}

struct hid_device_info *hid_enumerate(unsigned short vendor, unsigned short product) {
    struct hid_device_info *first = NULL;
    int n = 0;
    (void)vendor, (void)product;
    pthread_mutex_lock(&lock);
    for (int i = 0; i < FAKE_HID_DEVICES; i++)
        for (int k = 0; state[i].plugged && k < fake_hid[i].collections; k++) {
            infos[n] = (struct hid_device_info){.path = (char *)(uintptr_t)fake_hid[i].path,
                                                .vendor_id = fake_hid[i].vendor,
                                                .product_id = fake_hid[i].product,
                                                .serial_number = fake_hid[i].serial,
                                                .product_string = fake_hid[i].name,
                                                .usage_page = fake_hid[i].usage_page,
                                                .usage = fake_hid[i].usage,
                                                .interface_number = -1,
                                                .bus_type = HID_API_BUS_USB,
                                                .next = first};
            first = &infos[n++];
        }
    pthread_mutex_unlock(&lock);
    return first;
}

void hid_free_enumeration(struct hid_device_info *devices) {
    (void)devices;
}

// hidapi 0.13.1 ends the program here for a path that is no hidraw node.
hid_device *hid_open_path(const char *path) {
    hid_device *device = NULL;
    if (path[0] == '/')
        abort();
    pthread_mutex_lock(&lock);
    for (int i = 0; i < FAKE_HID_DEVICES; i++)
        if (state[i].plugged && fake_hid[i].path && strcmp(fake_hid[i].path, path) == 0) {
            for (device = handles; device->is_open;)
                device++; // the tests open none more than twice
            *device = (struct hid_device_){.number = i, .is_open = true};
            fake_hid[i].opened++;
            break;
        }
    pthread_mutex_unlock(&lock);
    return device;
}

void hid_close(hid_device *device) {
    pthread_mutex_lock(&lock);
    fake_hid[device->number].closed++;
    device->is_open = false;
    pthread_mutex_unlock(&lock);
}

static void begin(hid_device *device) {
    pthread_mutex_lock(&lock);
    if (device->busy) {
        fprintf(stderr, "two calls at a time about %s\n", fake_hid[device->number].path);
        abort();
    }
    device->busy = true;
}

static int end(hid_device *device, int result) {
    device->busy = false;
    pthread_mutex_unlock(&lock);
    return result;
}

int hid_read_timeout(hid_device *device, unsigned char *bytes, size_t size, int milliseconds) {
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_nsec += (long)milliseconds * 1000000;
    until.tv_sec += until.tv_nsec / 1000000000;
    until.tv_nsec %= 1000000000;
    begin(device);
    int i = device->number, timed_out = 0;
    while (state[i].plugged && (held || state[i].head == state[i].tail) && !timed_out)
        timed_out = pthread_cond_timedwait(&changed, &lock, &until);
    bool is_empty = state[i].head == state[i].tail;
    if (!state[i].plugged && (milliseconds >= 0 || is_empty))
        return end(device, -1);
    if (is_empty || (held && state[i].plugged))
        return end(device, 0);
    int at = state[i].tail++ % FAKE_HID_QUEUE;
    size_t n = state[i].len[at] < size ? state[i].len[at] : size;
    memcpy(bytes, state[i].bytes[at], n);
    return end(device, (int)n);
}

static int keep(hid_device *device, const unsigned char *bytes, size_t len) {
    begin(device);
    struct fake_hid *f = &fake_hid[device->number];
    memcpy(f->sent[f->sent_count++ % 8], bytes, len < 64 ? len : 64);
    return end(device, (int)len);
}

int hid_write(hid_device *device, const unsigned char *bytes, size_t len) {
    return keep(device, bytes, len);
}

int hid_send_feature_report(hid_device *device, const unsigned char *bytes, size_t len) {
    return keep(device, bytes, len);
}

// Each report holds its own number and nothing else.
int hid_get_feature_report(hid_device *device, unsigned char *bytes, size_t len) {
    begin(device);
    memset(bytes + 1, 0, len - 1);
    return end(device, (int)len);
}

int hid_get_report_descriptor(hid_device *device, unsigned char *bytes, size_t size);
int hid_get_report_descriptor(hid_device *device, unsigned char *bytes, size_t size) {
    begin(device);
    const struct fake_hid *f = &fake_hid[device->number];
    size_t n = f->descriptor_len < size ? f->descriptor_len : size;
    if (n)
        memcpy(bytes, f->descriptor, n);
    return end(device, n ? (int)n : -1);
}
