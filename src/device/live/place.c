#include "src/device/live/place.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

// A small file of sysfs; the number of bytes, 0 where it cannot be read.
static size_t read_file(int dir, const char *name, void *bytes, size_t size) {
    int fd = openat(dir, name, O_RDONLY | O_CLOEXEC);
    if (fd < 0)
        return 0;
    ssize_t n = read(fd, bytes, size);
    close(fd);
    return n > 0 ? (size_t)n : 0;
}

// The value of "KEY=value" in uevent's lines, cut to fit, control characters replaced.
static void find_value(const char *text, const char *key, char *out, size_t size) {
    size_t key_len = strlen(key), n = 0;
    for (const char *line = text; line && *line; line = strchr(line, '\n')) {
        line += *line == '\n';
        if (strncmp(line, key, key_len) != 0 || line[key_len] != '=')
            continue;
        for (const char *c = line + key_len + 1; *c && *c != '\n' && n + 1 < size; c++)
            out[n++] = (unsigned char)*c < 0x20 || *c == 0x7f ? '?' : *c;
        break;
    }
    out[n] = '\0';
}

static bool read_place(int dir, const char *node, const char *root, struct ap_live_place *place) {
    char uevent[2048], id[64], name[64], number[16] = "";
    snprintf(name, sizeof name, "%s/device/uevent", node);
    size_t n = read_file(dir, name, uevent, sizeof uevent - 1);
    uevent[n] = '\0';
    unsigned bus, vendor, product;
    find_value(uevent, "HID_ID", id, sizeof id);
    if (sscanf(id, "%x:%x:%x", &bus, &vendor, &product) != 3)
        return false;
    memset(place, 0, sizeof *place);
    place->bus = (uint16_t)bus;
    place->vendor = (uint16_t)vendor;
    place->product = (uint16_t)product;
    find_value(uevent, "HID_NAME", place->name, sizeof place->name);
    find_value(uevent, "HID_PHYS", place->port, sizeof place->port);
    find_value(uevent, "HID_UNIQ", place->serial, sizeof place->serial);
    snprintf(name, sizeof name, "%s/device/report_descriptor", node);
    place->descriptor_len = read_file(dir, name, place->descriptor, sizeof place->descriptor);
    // The HID device's parent is the USB interface.
    snprintf(name, sizeof name, "%s/device/../bInterfaceNumber", node);
    place->interface_number =
        read_file(dir, name, number, sizeof number - 1) ? (int)strtol(number, NULL, 16) : -1;
    snprintf(place->path, sizeof place->path, "%s/dev/%s", root, node);
    if (access(place->path, F_OK) != 0)
        return false;
    place->denied = access(place->path, R_OK | W_OK) != 0;
    return true;
}

bool live_hidraw_place(const char *root, const char *node, struct ap_live_place *place) {
    char path[LIVE_ROOT_MAX + 32];
    snprintf(path, sizeof path, "%s/sys/class/hidraw", root);
    int dir = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (dir < 0)
        return false;
    bool got = read_place(dir, node, root, place);
    close(dir);
    return got;
}

bool live_is_hidraw_node(const char *path) {
    struct stat s;
    char link[64], target[256];
    if (stat(path, &s) != 0 || !S_ISCHR(s.st_mode))
        return false;
    snprintf(link, sizeof link, "/sys/dev/char/%u:%u/subsystem", major(s.st_rdev),
             minor(s.st_rdev));
    ssize_t n = readlink(link, target, sizeof target - 1);
    target[n > 0 ? n : 0] = '\0';
    const char *slash = strrchr(target, '/');
    return slash && strcmp(slash, "/hidraw") == 0;
}

bool live_is_wanted(const struct ap_live_place *place) {
    static _Thread_local struct ap_device_info info;
    memset(&info, 0, sizeof info);
    info.bus = place->bus;
    info.vendor = place->vendor;
    info.product = place->product;
    info.interface_known = place->interface_number >= 0;
    info.interface_number = place->interface_number;
    for (int i = 0; i < ap_driver_count(); i++)
        if (ap_driver_names(ap_driver_at(i), &info))
            return true;
    return place->descriptor_len &&
           !ap_hid_parse_descriptor(NULL, place->descriptor, place->descriptor_len,
                                    &info.descriptor) &&
           ap_driver_find(&info);
}
