#include <libusb-1.0/libusb.h>
#include <stdlib.h>

#include "tests/vm/reading.h"

// Reads a USB device that no kernel driver has taken with libusb, four transfers in flight.
//
//   read_usb VENDOR:PRODUCT COUNT RECORDING [SENT-LOG]

enum { TRANSFERS = 4 };

static struct reading reading;
static int in_flight;
static bool gone;

static void LIBUSB_CALL on_report(struct libusb_transfer *t) {
    in_flight--;
    if (t->status != LIBUSB_TRANSFER_COMPLETED) {
        gone = true;
        return;
    }
    reading_add(&reading, t->buffer, (size_t)t->actual_length);
    if (reading.count < reading.wanted && libusb_submit_transfer(t) == 0)
        in_flight++;
}

static libusb_device_handle *open_device(unsigned vendor, unsigned product) {
    // Without udevd libusb sees what was there when it was initialised, and nothing new.
    for (int64_t end = player_now_ns() + 5000000000; player_now_ns() < end;) {
        if (libusb_init(NULL) != 0)
            player_die("no libusb");
        libusb_device_handle *h =
            libusb_open_device_with_vid_pid(NULL, (uint16_t)vendor, (uint16_t)product);
        if (h)
            return h;
        libusb_exit(NULL);
        player_poll(-1, player_now_ns() + 5000000);
    }
    player_die("no device %04x:%04x", vendor, product);
}

int main(int argc, char **argv) {
    static uint8_t buffers[TRANSFERS][PLAYER_REPORT_MAX];
    struct libusb_transfer *transfers[TRANSFERS] = {NULL};
    unsigned vendor, product;
    if (argc < 4 || sscanf(argv[1], "%x:%x", &vendor, &product) != 2)
        player_die("see read_usb.c for the arguments");
    reading_open(&reading, argv[3], atoll(argv[2]));
    reading.sent_log = argc > 4 ? argv[4] : NULL;
    libusb_device_handle *h = open_device(vendor, product);
    if (libusb_claim_interface(h, 0) != 0)
        player_die("the interface is somebody else's");
    for (int i = 0; i < TRANSFERS; i++) {
        transfers[i] = libusb_alloc_transfer(0);
        libusb_fill_interrupt_transfer(transfers[i], h, 0x81, buffers[i], 512, on_report, NULL, 0);
        if (libusb_submit_transfer(transfers[i]) == 0)
            in_flight++;
    }
    while (in_flight > 0)
        libusb_handle_events_timeout(NULL, &(struct timeval){.tv_sec = 1});
    if (gone)
        printf("gone ");
    reading_tell(&reading);
    for (int i = 0; i < TRANSFERS; i++)
        libusb_free_transfer(transfers[i]);
    libusb_close(h);
    libusb_exit(NULL);
    return 0;
}
