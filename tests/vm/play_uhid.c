#include <errno.h>
#include <fcntl.h>
#include <linux/uhid.h>
#include <string.h>
#include <unistd.h>

#include "tests/vm/player.h"

// A real HID device of the kernel, made through /dev/uhid: plays the first device of a hid-recorder
// file and answers to feature reports with the file's ("# F:"), or with what the host has set
// since. Everything the host sends is printed. The device is there while the program runs.
//
//   play_uhid [--rate HZ] [--count N] [--wait] [--serial TEXT] [--after S] [--hold S]
//             [--late I --late-for S]
//             [--sent FILE] [--polite] RECORDING
//
// --polite: behind everybody else who wants the processor.

static struct player player;
static int readers;

static void put(int fd, const struct uhid_event *event) {
    if (write(fd, event, sizeof *event) < 0)
        player_die("cannot write to /dev/uhid: %s", strerror(errno));
}

static void answer_get(int fd, const struct uhid_get_report_req *request) {
    const struct player_feature *f = &player.features[request->rnum];
    struct uhid_event reply = {.type = UHID_GET_REPORT_REPLY};
    reply.u.get_report_reply.id = request->id;
    if (request->rtype == UHID_FEATURE_REPORT && f->len > 0) {
        reply.u.get_report_reply.size = (uint16_t)f->len;
        memcpy(reply.u.get_report_reply.data, f->bytes, f->len);
    } else {
        reply.u.get_report_reply.err = EIO;
    }
    put(fd, &reply);
}

static void answer_set(int fd, const struct uhid_set_report_req *request) {
    struct player_feature *f = &player.features[request->rnum];
    bool feature = request->rtype == UHID_FEATURE_REPORT;
    player_print(feature ? "feature" : "output", request->rnum, request->data, request->size);
    if (feature && request->size <= sizeof f->bytes) {
        f->len = request->size;
        memcpy(f->bytes, request->data, request->size);
    }
    struct uhid_event reply = {.type = UHID_SET_REPORT_REPLY};
    reply.u.set_report_reply.id = request->id;
    put(fd, &reply);
}

static void serve(int fd) {
    static struct uhid_event event;
    if (read(fd, &event, sizeof event) <= 0)
        return;
    if (event.type == UHID_OPEN)
        readers++;
    else if (event.type == UHID_CLOSE)
        readers--;
    else if (event.type == UHID_OUTPUT)
        player_print("output", event.u.output.data[0], event.u.output.data, event.u.output.size);
    else if (event.type == UHID_GET_REPORT)
        answer_get(fd, &event.u.get_report);
    else if (event.type == UHID_SET_REPORT)
        answer_set(fd, &event.u.set_report);
}

static void serve_until(int fd, int64_t t_ns) {
    while (!player_stop && player_now_ns() < t_ns)
        if (player_poll(fd, t_ns))
            serve(fd);
}

static void plug(int fd, const struct player_device *d) {
    static struct uhid_event event = {.type = UHID_CREATE2};
    struct uhid_create2_req *r = &event.u.create2;
    snprintf((char *)r->name, sizeof r->name, "%s", d->name);
    snprintf((char *)r->uniq, sizeof r->uniq, "%s", player.serial);
    r->bus = d->bus;
    r->vendor = d->vendor;
    r->product = d->product;
    r->rd_size = (uint16_t)d->descriptor_len;
    memcpy(r->rd_data, d->descriptor, d->descriptor_len);
    put(fd, &event);
    printf("plugged %04x:%04x\n", d->vendor, d->product);
}

static int64_t play(int fd, const struct player_device *d) {
    static struct uhid_event event = {.type = UHID_INPUT2};
    int64_t start = player_now_ns(), total = player_total(&player, d), i = 0;
    for (; i < total; i++) {
        const struct player_report *r = &d->reports[i % (int64_t)d->report_count];
        serve_until(fd, start + player_due_ns(&player, d, i));
        if (player_stop)
            break;
        event.u.input2.size = (uint16_t)r->len;
        memcpy(event.u.input2.data, r->bytes, r->len);
        player_log_sent(&player, i);
        put(fd, &event);
    }
    return i;
}

int main(int argc, char **argv) {
    player_open(&player, "play_uhid", argc, argv);
    const struct player_device *d = &player.devices[0];
    int fd = open("/dev/uhid", O_RDWR | O_CLOEXEC);
    if (fd < 0)
        player_die("/dev/uhid: %s", strerror(errno));
    plug(fd, d);
    while (player.wait && readers <= 0 && !player_stop)
        serve_until(fd, player_now_ns() + 1000000);
    serve_until(fd, player_now_ns() + player.after_ns);
    int64_t sent = play(fd, d);
    printf("sent %lld reports\n", (long long)sent);
    if (player.sent_log)
        fclose(player.sent_log);
    serve_until(fd, player_now_ns() + player.hold_ns);
    printf("unplugged at %lld\n", (long long)player_now_ns());
    put(fd, &(struct uhid_event){.type = UHID_DESTROY});
    return 0;
}
