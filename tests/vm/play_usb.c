#include <arpa/inet.h>
#include <errno.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/vm/player.h"

// A real USB device of the kernel: the player is the far end of vhci-hcd (USB/IP, whose messages
// the kernel's Documentation/usb/usbip_protocol.rst describes), so usbhid, hidraw and libusb see a
// device on a bus. Each device of the hid-recorder files is an interface of it with one interrupt
// endpoint; feature reports are answered as by play_uhid. The device is there while the program
// runs.
//
//   play_usb [--rate HZ] [--count N] [--wait] [--serial TEXT] [--maker TEXT] [--after S] [--hold S]
//            [--bare] [--fail N] [--late I --late-for S] [--sent FILE] RECORDING…

#define VHCI "/sys/devices/platform/vhci_hcd.0/"

enum {
    CMD_SUBMIT = 1,
    CMD_UNLINK = 2,
    RET_SUBMIT = 3,
    RET_UNLINK = 4,
    PENDING_MAX = 64,
    QUEUE_MAX = 8, // reports that the device keeps for a host that does not ask; the oldest go
    HIGH_SPEED = 3,
};

// Big endian.
struct message {
    uint32_t command, seqnum, device, direction, endpoint;
    uint32_t flags_or_status, length, start_frame, packets, interval;
    uint8_t setup[8];
};

struct interface {
    struct player_device *device;
    uint32_t pending[PENDING_MAX], pending_len[PENDING_MAX]; // the host's requests
    int pending_count;
    const struct player_report *queue[QUEUE_MAX];
    int queue_count;
    bool started;
    int64_t start_ns, sent, delivered, dropped;
};

static struct player player;
static struct interface interfaces[PLAYER_DEVICES_MAX];
static int kernel; // the socket

static void send_all(const void *data, size_t len) {
    for (const uint8_t *at = data; len > 0 && !player_stop;) {
        ssize_t n = send(kernel, at, len, MSG_NOSIGNAL);
        if (n <= 0)
            player_stop = 1;
        at += n > 0 ? n : 0;
        len -= n > 0 ? (size_t)n : 0;
    }
}

static bool receive_all(void *data, size_t len) {
    return len == 0 || recv(kernel, data, len, MSG_WAITALL) == (ssize_t)len;
}

// `data` NULL: nothing but the header.
static void answer(uint32_t command, uint32_t seqnum, int status, const void *data, size_t len) {
    uint8_t bytes[sizeof(struct message) + 8192];
    struct message m = {.command = htonl(command),
                        .seqnum = htonl(seqnum),
                        .flags_or_status = htonl((uint32_t)status),
                        .length = htonl((uint32_t)len)};
    memcpy(bytes, &m, sizeof m);
    if (data && len > 0)
        memcpy(bytes + sizeof m, data, len);
    send_all(bytes, sizeof m + (data ? len : 0));
}

static void forget_pending(struct interface *f, int k) {
    f->pending_count--;
    for (int i = k; i < f->pending_count; i++) {
        f->pending[i] = f->pending[i + 1];
        f->pending_len[i] = f->pending_len[i + 1];
    }
}

static void forget_oldest(struct interface *f) {
    f->queue_count--;
    memmove(f->queue, f->queue + 1, (size_t)f->queue_count * sizeof *f->queue);
}

// Hands reports to requests as long as there are both.
static void deliver(struct interface *f) {
    while (f->pending_count > 0 && f->queue_count > 0) {
        const struct player_report *r = f->queue[0];
        size_t len = r->len < f->pending_len[0] ? r->len : f->pending_len[0];
        if (f->delivered == player.fail_after) {
            player.fail_after = -1;
            answer(RET_SUBMIT, f->pending[0], -EPROTO, NULL, 0);
        } else {
            answer(RET_SUBMIT, f->pending[0], 0, r->bytes, len);
            f->delivered++;
        }
        forget_pending(f, 0);
        forget_oldest(f);
    }
}

static size_t put_bytes(uint8_t *out, const uint8_t *bytes) {
    memcpy(out, bytes, bytes[0]); // a USB descriptor begins with its length
    return bytes[0];
}

static size_t hid_descriptor(const struct player_device *d, uint8_t *out) {
    size_t n = d->descriptor_len;
    return put_bytes(
        out, (const uint8_t[9]){9, 0x21, 0x11, 0x01, 0, 1, 0x22, (uint8_t)n, (uint8_t)(n >> 8)});
}

static size_t configuration(uint8_t *out) {
    size_t n = 9;
    for (int i = 0; i < player.device_count; i++) {
        uint8_t class = player.bare ? 0xff : 3;
        n += put_bytes(out + n, (const uint8_t[9]){9, 4, (uint8_t)i, 0, 1, class, 0, 0, 0});
        if (!player.bare)
            n += hid_descriptor(&player.devices[i], out + n);
        // Asked every millisecond: 2^(4-1) microframes.
        n += put_bytes(out + n, (const uint8_t[7]){7, 5, (uint8_t)(0x81 + i), 3, 0, 2, 4});
    }
    put_bytes(out, (const uint8_t[9]){9, 2, (uint8_t)n, (uint8_t)(n >> 8),
                                      (uint8_t)player.device_count, 1, 0, 0x80, 50});
    return n;
}

static int text_descriptor(unsigned index, uint8_t *out) {
    const char *const texts[] = {NULL, player.maker, player.devices[0].name, player.serial};
    if (index == 0)
        return (int)put_bytes(out, (const uint8_t[4]){4, 3, 0x09, 0x04});
    if (index > 3)
        return -EPIPE;
    size_t len = strnlen(texts[index], 126);
    out[0] = (uint8_t)(2 + 2 * len);
    out[1] = 3;
    for (size_t i = 0; i < len; i++) {
        out[2 + 2 * i] = (uint8_t)texts[index][i];
        out[3 + 2 * i] = 0;
    }
    return out[0];
}

static int device_descriptor(uint8_t *out) {
    uint16_t v = player.devices[0].vendor, p = player.devices[0].product;
    return (int)put_bytes(out, (const uint8_t[18]){18, 1, 0, 2, 0, 0, 0, 64, (uint8_t)v,
                                                   (uint8_t)(v >> 8), (uint8_t)p, (uint8_t)(p >> 8),
                                                   0, 1, 1, 2, *player.serial ? 3 : 0, 1});
}

static int descriptor(unsigned value, uint8_t *out) {
    switch (value >> 8) {
    case 1:
        return device_descriptor(out);
    case 2:
        return (int)configuration(out);
    case 3:
        return text_descriptor(value & 0xff, out);
    default:
        return -EPIPE;
    }
}

static int interface_descriptor(unsigned value, const struct player_device *d, uint8_t *out) {
    if (value >> 8 == 0x21)
        return (int)hid_descriptor(d, out);
    if (value >> 8 != 0x22)
        return -EPIPE;
    memcpy(out, d->descriptor, d->descriptor_len);
    return (int)d->descriptor_len;
}

static int get_report(unsigned value, uint8_t *out) {
    const struct player_feature *f = &player.features[value & 0xff];
    if (value >> 8 != 3 || f->len == 0)
        return -EPIPE;
    // A report that is not numbered has no byte for its number on the wire.
    size_t skip = (value & 0xff) == 0 ? 1 : 0;
    memcpy(out, f->bytes + skip, f->len - skip);
    return (int)(f->len - skip);
}

static int set_report(unsigned value, const uint8_t *data, size_t len) {
    struct player_feature *f = &player.features[value & 0xff];
    player_print(value >> 8 == 3 ? "feature" : "output", value & 0xff, data, len);
    if (value >> 8 == 3 && (value & 0xff) != 0 && len <= sizeof f->bytes) {
        f->len = len;
        memcpy(f->bytes, data, len);
    }
    return 0;
}

// A control transfer: the length of the answer, or −EPIPE where the device stalls.
static int control(const uint8_t *setup, const uint8_t *data, size_t len, uint8_t *out) {
    unsigned value = setup[2] | setup[3] << 8, index = setup[4] | setup[5] << 8;
    const struct player_device *d =
        &player.devices[index < (unsigned)player.device_count ? index : 0];
    switch (setup[0] << 8 | setup[1]) {
    case 0x8006: // GET_DESCRIPTOR
        return descriptor(value, out);
    case 0x8106:
        return interface_descriptor(value, d, out);
    case 0x8000: // GET_STATUS
    case 0x8100:
    case 0x8200:
        out[0] = out[1] = 0;
        return 2;
    case 0xa101:
        return get_report(value, out);
    case 0x2109:
        return set_report(value, data, len);
    case 0x0009: // SET_CONFIGURATION, SET_INTERFACE, CLEAR_FEATURE, SET_IDLE, SET_PROTOCOL
    case 0x010b:
    case 0x0201:
    case 0x210a:
    case 0x210b:
        return 0;
    default:
        return -EPIPE;
    }
}

static void unlink_request(uint32_t seqnum, uint32_t victim) {
    int status = 0;
    for (int i = 0; i < player.device_count; i++)
        for (int k = 0; k < interfaces[i].pending_count; k++)
            if (interfaces[i].pending[k] == victim) {
                forget_pending(&interfaces[i], k);
                status = -ECONNRESET;
                break;
            }
    answer(RET_UNLINK, seqnum, status, NULL, 0);
}

static void start(struct interface *f) {
    if (!f->started)
        f->start_ns = player_now_ns() + player.after_ns;
    f->started = true;
}

static void serve(void) {
    static uint8_t data[65536], out[8192];
    struct message m;
    if (!receive_all(&m, sizeof m)) {
        player_stop = 1;
        return;
    }
    uint32_t seqnum = ntohl(m.seqnum), len = ntohl(m.length), endpoint = ntohl(m.endpoint);
    bool in = ntohl(m.direction) == 1;
    if (ntohl(m.command) == CMD_UNLINK) {
        unlink_request(seqnum, ntohl(m.flags_or_status));
        return;
    }
    if (!in && (len > sizeof data || !receive_all(data, len))) {
        player_stop = 1;
    } else if (endpoint == 0) {
        int n = control(m.setup, data, in ? 0 : len, out);
        size_t given = n < 0 ? 0 : in ? ((uint32_t)n < len ? (uint32_t)n : len) : len;
        answer(RET_SUBMIT, seqnum, n < 0 ? n : 0, in && n >= 0 ? out : NULL, given);
    } else if (in && endpoint <= (uint32_t)player.device_count &&
               interfaces[endpoint - 1].pending_count < PENDING_MAX) {
        struct interface *f = &interfaces[endpoint - 1];
        f->pending[f->pending_count] = seqnum;
        f->pending_len[f->pending_count++] = len;
        start(f);
        deliver(f);
    } else {
        answer(RET_SUBMIT, seqnum, -EPIPE, NULL, 0);
    }
}

// Gives the other end of a socket pair to the kernel; the port of its hub.
static int attach(int fd) {
    char line[256];
    int port = -1;
    FILE *file = fopen(VHCI "status", "r");
    while (file && port < 0 && fgets(line, sizeof line, file)) {
        int p, status;
        if (sscanf(line, "hs %d %d", &p, &status) == 2 && status == 4) // 4: nothing there
            port = p;
    }
    if (file)
        fclose(file);
    file = fopen(VHCI "attach", "w");
    if (port < 0 || !file)
        player_die("no free port of vhci-hcd");
    fprintf(file, "%d %d %d %d", port, fd, 1 + port, HIGH_SPEED);
    if (fclose(file) != 0)
        player_die("the kernel does not take the device: %s", strerror(errno));
    return port;
}

static void detach(int port) {
    FILE *file = fopen(VHCI "detach", "w");
    if (!file)
        return;
    fprintf(file, "%d", port);
    fclose(file);
}

// What is due is queued and delivered; when the next is due, INT64_MAX where nothing is left.
static int64_t play_interface(struct interface *f, int64_t now) {
    int64_t total = player_total(&player, f->device);
    while (f->started && f->sent < total) {
        int64_t due = f->start_ns + player_due_ns(&player, f->device, f->sent);
        if (due > now)
            return due;
        if (f->queue_count == QUEUE_MAX) {
            forget_oldest(f);
            f->dropped++;
        }
        f->queue[f->queue_count++] =
            &f->device->reports[f->sent % (int64_t)f->device->report_count];
        player_log_sent(&player, f->sent);
        f->sent++;
        deliver(f);
    }
    return f->sent < total ? now + 100000000 : INT64_MAX;
}

static void play(void) {
    int64_t end = INT64_MAX;
    while (!player_stop) {
        int64_t now = player_now_ns(), next = INT64_MAX;
        for (int i = 0; i < player.device_count; i++) {
            int64_t due = play_interface(&interfaces[i], now);
            next = due < next ? due : next;
        }
        if (next == INT64_MAX && end == INT64_MAX)
            end = now + player.hold_ns;
        if (now >= end)
            break;
        if (player_poll(kernel, next < end ? next : end))
            serve();
    }
}

int main(int argc, char **argv) {
    int pair[2];
    player_open(&player, "play_usb", argc, argv);
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair) != 0)
        player_die("no socket: %s", strerror(errno));
    kernel = pair[0];
    int port = attach(pair[1]);
    close(pair[1]);
    printf("plugged %04x:%04x at port %d\n", player.devices[0].vendor, player.devices[0].product,
           port);
    for (int i = 0; i < player.device_count; i++) {
        interfaces[i].device = &player.devices[i];
        if (!player.wait)
            start(&interfaces[i]);
    }
    play();
    for (int i = 0; i < player.device_count; i++)
        printf("interface %d: sent %lld reports, %lld dropped before a read\n", i,
               (long long)interfaces[i].sent, (long long)interfaces[i].dropped);
    if (player.sent_log)
        fclose(player.sent_log);
    printf("unplugged at %lld\n", (long long)player_now_ns());
    detach(port);
    return 0;
}
