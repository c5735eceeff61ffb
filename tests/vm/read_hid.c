#include <hidapi/hidapi.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <wchar.h>

#include "tests/vm/reading.h"

// Reads a device with hidapi (this file is linked with each of its two backends), so that a fault
// of the players or the machine is told from one of ours.
//
//   read_hid VENDOR:PRODUCT SERIAL|- COUNT RECORDING [SENT-LOG|- [FEATURE-ID [PAUSE-S]]]
//
// With a feature id the report is read and, its second byte 5a, set. PAUSE-S: nothing is read for
// so long in the middle.

static hid_device *open_device(unsigned vendor, unsigned product, const char *serial) {
    wchar_t wide[128];
    mbstowcs(wide, serial, 127);
    wide[127] = 0;
    for (int64_t end = player_now_ns() + 5000000000; player_now_ns() < end;) {
        hid_device *device = hid_open((unsigned short)vendor, (unsigned short)product,
                                      strcmp(serial, "-") == 0 ? NULL : wide);
        if (device)
            return device;
        hid_exit(); // libusb, without udevd, sees nothing new until it is initialised again
        nanosleep(&(struct timespec){.tv_nsec = 5000000}, NULL);
    }
    player_die("no device %04x:%04x with the serial %s", vendor, product, serial);
}

static void use_feature(hid_device *device, int id) {
    uint8_t bytes[256] = {(uint8_t)id};
    int n = hid_get_feature_report(device, bytes, sizeof bytes);
    if (n < 2)
        player_die("feature report %d cannot be read", id);
    player_print("got feature", bytes[0], bytes, (size_t)n);
    bytes[1] = 0x5a;
    if (hid_send_feature_report(device, bytes, (size_t)n) != n)
        player_die("feature report %d cannot be set", id);
}

int main(int argc, char **argv) {
    static struct reading reading;
    unsigned vendor, product;
    if (argc < 5 || sscanf(argv[1], "%x:%x", &vendor, &product) != 2)
        player_die("see read_hid.c for the arguments");
    reading_open(&reading, argv[4], atoll(argv[3]));
    reading.sent_log = argc > 5 && strcmp(argv[5], "-") != 0 ? argv[5] : NULL;
    double pause_s = argc > 7 ? atof(argv[7]) : 0;
    hid_device *device = open_device(vendor, product, argv[2]);
    if (argc > 6)
        use_feature(device, atoi(argv[6]));
    const char *end = "";
    while (reading.count < reading.wanted && !*end) {
        uint8_t bytes[PLAYER_REPORT_MAX];
        int n = hid_read_timeout(device, bytes, sizeof bytes, 1000);
        if (n > 0)
            reading_add(&reading, bytes, (size_t)n);
        else
            end = n < 0 ? "gone" : "silent";
        if (pause_s > 0 && reading.count == reading.wanted / 2) {
            nanosleep(&(struct timespec){.tv_nsec = (long)(1e9 * pause_s)}, NULL);
            pause_s = 0;
        }
    }
    if (*end)
        printf("%s ", end);
    reading_tell(&reading);
    hid_close(device);
    hid_exit();
    return 0;
}
