#ifndef ANTIPODE_TESTS_VM_PLAYER_H
#define ANTIPODE_TESTS_VM_PLAYER_H

#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

// What the players of virtual devices share: a hid-recorder file in memory, the command line and
// the clock. They are programs for the virtual machine; a bad file or option ends them with a line.

enum { PLAYER_DEVICES_MAX = 8, PLAYER_REPORT_MAX = 1024 };

struct player_report {
    int64_t t_ns;
    size_t len;
    uint8_t *bytes;
};

struct player_feature {
    size_t len; // 0: the device has none of that id
    uint8_t bytes[256];
};

struct player_device {
    char name[128];
    uint16_t bus, vendor, product;
    uint8_t descriptor[4096];
    size_t descriptor_len, report_count;
    struct player_report *reports;
};

struct player {
    struct player_device devices[PLAYER_DEVICES_MAX];
    int device_count;
    struct player_feature features[256]; // by id, of all the devices together
    const char *serial, *maker;
    double rate_hz;     // 0: the recorded times
    int64_t count;      // reports of each device; −1: the recording once, 0: for ever
    int64_t after_ns;   // how long it says nothing once somebody reads
    int64_t hold_ns;    // how long the device stays after the last one
    int64_t fail_after; // USB: one transfer fails after so many; −1: none
    int64_t late_at;    // before this report the device says nothing …
    int64_t late_ns;    // … for so long; then what was missed comes at once
    bool wait;          // for somebody to read
    bool bare;          // USB: no kernel driver binds (vendor class)
    FILE *sent_log;     // a line "index t_ns" for each report, t_ns of CLOCK_MONOTONIC, or NULL
};

// Adds the devices of a hid-recorder file.
void player_load(struct player *p, const char *path);

// Ends the program where it cannot.
void player_open(struct player *p, const char *program, int argc, char **argv);

// SIGINT or SIGTERM has come.
extern volatile sig_atomic_t player_stop;

int64_t player_now_ns(void);

// When report i of the device is due, counted from the first.
int64_t player_due_ns(const struct player *p, const struct player_device *d, int64_t i);

// How many reports the device sends.
int64_t player_total(const struct player *p, const struct player_device *d);

void player_log_sent(const struct player *p, int64_t i);

// "WHAT ID: bytes" on standard output: what the host sent.
void player_print(const char *what, unsigned id, const uint8_t *bytes, size_t len);

// ppoll() until t_ns (or a signal); true where the file can be read.
bool player_poll(int fd, int64_t t_ns);

// A sentence and exit status 1.
_Noreturn void player_die(const char *format, ...) __attribute__((format(printf, 1, 2)));

#endif
