#include <string.h>

#include "src/device/live/set.h"

// The ways to this machine's devices, by name.

static enum ap_status open_hidraw(struct ap_error *err, struct ap_live_bus *bus) {
    return ap_live_hidraw(err, "", bus);
}

static const struct way {
    const char *name;
    enum ap_status (*open)(struct ap_error *err, struct ap_live_bus *bus); // NULL: not built in
    bool is_nodes; // stands on the kernel's hidraw nodes
} ways[] = {
    {"hidraw", open_hidraw, true},
    {"libusb", ap_live_usb, false},
#ifdef AP_HAS_HIDAPI
    {"hidapi", ap_live_hidapi, true},
#else
    {"hidapi", NULL, true},
#endif
};

static const struct way *find(const char *name) {
    for (size_t i = 0; i < sizeof ways / sizeof *ways; i++)
        if (strcmp(ways[i].name, name) == 0)
            return &ways[i];
    return NULL;
}

enum ap_status live_ways_check(struct ap_error *err, const char *const *names, size_t count) {
    int nodes = 0;
    for (size_t i = 0; i < count; i++) {
        const struct way *way = find(names[i]);
        if (!way)
            return ap_fail(err, AP_USAGE, "bus '%s': expected hidraw, libusb or hidapi", names[i]);
        if (!way->open)
            return ap_fail(err, AP_USAGE, "bus '%s': this antipode is built without it", names[i]);
        for (size_t k = 0; k < i; k++)
            if (strcmp(names[k], names[i]) == 0)
                return ap_fail(err, AP_USAGE, "bus '%s' is there twice", names[i]);
        nodes += way->is_nodes;
    }
    if (nodes > 1)
        return ap_fail(err, AP_USAGE,
                       "bus 'hidraw' and bus 'hidapi' lead to the same devices; name one of them");
    return AP_OK;
}

// A machine without USB has no second way, which is no reason to do without the first.
static enum ap_status open_usual(struct ap_error *err, struct ap_live_bus *buses, int *count) {
    enum ap_status st = ap_live_hidraw(err, "", &buses[0]);
    if (!st)
        *count = ap_live_usb(NULL, &buses[1]) == AP_OK ? 2 : 1;
    return st;
}

enum ap_status ap_live_machine(struct ap_error *err, const char *const *names, size_t name_count,
                               struct ap_live_bus *buses, int *count) {
    if (name_count == 0)
        return open_usual(err, buses, count);
    enum ap_status st = live_ways_check(err, names, name_count);
    int opened = 0;
    for (size_t i = 0; i < name_count && !st; i++) {
        st = find(names[i])->open(err, &buses[opened]);
        opened += !st;
    }
    if (!st) {
        *count = opened;
        return AP_OK;
    }
    for (int i = 0; i < opened; i++)
        buses[i].io->destroy(buses[i].bus);
    return st;
}
