#include "src/device/live/rules.h"

#include <string.h>

enum { USB = 3, BLUETOOTH = 5 };

// udev's pattern for products first…last: "*", or alternatives in 4 digits each.
static void write_products(FILE *f, const struct ap_driver_ids *id, const char *prefix,
                           const char *format, const char *suffix) {
    if (id->first_product == 0 && id->last_product == 0xffff) {
        fprintf(f, "%s*%s", prefix, suffix);
        return;
    }
    for (unsigned p = id->first_product; p <= id->last_product; p++) {
        fprintf(f, "%s%s", p == id->first_product ? "" : "|", prefix);
        fprintf(f, strcmp(format, "%04X") == 0 ? "%04X" : "%04x", p);
        fprintf(f, "%s", suffix);
    }
}

// A hidraw node's parent is named BUS:VENDOR:PRODUCT.NUMBER, in capitals.
static void write_hidraw(FILE *f, const struct ap_driver_ids *id) {
    char prefix[16];
    if (id->bus)
        snprintf(prefix, sizeof prefix, "%04X:%04X:", (unsigned)id->bus, (unsigned)id->vendor);
    else
        snprintf(prefix, sizeof prefix, "*:%04X:", (unsigned)id->vendor);
    fprintf(f, "KERNEL==\"hidraw*\", KERNELS==\"");
    write_products(f, id, prefix, "%04X", ".*");
    fprintf(f, "\", TAG+=\"uaccess\"\n");
}

static void write_usb(FILE *f, const struct ap_driver_ids *id) {
    fprintf(f,
            "SUBSYSTEM==\"usb\", ENV{DEVTYPE}==\"usb_device\", ATTR{idVendor}==\"%04x\", "
            "ATTR{idProduct}==\"",
            (unsigned)id->vendor);
    write_products(f, id, "", "%04x", "");
    fprintf(f, "\", TAG+=\"uaccess\"\n");
}

void ap_live_write_rules(FILE *f) {
    fprintf(
        f,
        "# Trackers that antipode has drivers for, for whoever sits at this machine. Made from\n"
        "# the drivers' tables. Belongs into /lib/udev/rules.d or /etc/udev/rules.d; the number\n"
        "# in its name must stay below 73, where \"uaccess\" is looked at. Afterwards:\n"
        "#   udevadm control --reload && udevadm trigger\n"
        "ACTION==\"remove\", GOTO=\"antipode_end\"\n");
    for (int i = 0; i < ap_driver_count(); i++) {
        const struct ap_driver *driver = ap_driver_at(i);
        if (driver->ids)
            fprintf(f, "\n# %s\n", driver->title);
        for (const struct ap_driver_ids *id = driver->ids; id && id->vendor; id++) {
            write_hidraw(f, id);
            if (!id->bus || id->bus == USB)
                write_usb(f, id);
        }
    }
    fprintf(f, "\nLABEL=\"antipode_end\"\n");
}

void ap_live_rule(const struct ap_live_place *place, char *text, size_t size) {
    if (strncmp(place->path, "usb:", 4) == 0)
        snprintf(text, size,
                 "SUBSYSTEM==\"usb\", ATTR{idVendor}==\"%04x\", ATTR{idProduct}==\"%04x\", "
                 "TAG+=\"uaccess\"",
                 (unsigned)place->vendor, (unsigned)place->product);
    else
        snprintf(text, size, "KERNEL==\"hidraw*\", KERNELS==\"%04X:%04X:%04X.*\", TAG+=\"uaccess\"",
                 (unsigned)place->bus, (unsigned)place->vendor, (unsigned)place->product);
}

bool ap_live_rules_cover(const struct ap_live_place *place) {
    const struct ap_device_info info = {
        .bus = place->bus, .vendor = place->vendor, .product = place->product};
    for (int i = 0; i < ap_driver_count(); i++)
        if (ap_driver_names(ap_driver_at(i), &info))
            return true;
    return false;
}

void ap_live_denied_text(const struct ap_live_place *place, const struct ap_driver *driver,
                         char *text, size_t size) {
    char rule[160];
    ap_live_rule(place, rule, sizeof rule);
    if (ap_live_rules_cover(place))
        snprintf(text, size,
                 "%s: no permission; put %s (meson install brings it) into /etc/udev/rules.d, "
                 "or this line of it: %s; then run: udevadm control --reload && udevadm trigger",
                 place->path, AP_LIVE_RULES_FILE, rule);
    else
        snprintf(text, size, "%s: no permission%s; put this line into /etc/udev/rules.d/%s: %s",
                 place->path, driver ? "" : " (and no driver)", AP_LIVE_RULES_FILE, rule);
}
