#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Writes a recording in hid-recorder's format whose reports are all different, for the players:
// what the protocols' pages say, encoded; it knows nothing of the drivers.
//
//   make_recording numbered|slimevr|android|garbage COUNT HZ [YAW]
//
// numbered: 32 bytes, the number of the report at byte 1; an output and a feature report.
// slimevr: one tracker, which turns by 0.1 mrad a report about the vertical (YAW rad to begin
// with). android: Android's head tracker, the same way; two feature reports.

static void put_hex(const char *key, const uint8_t *bytes, size_t len) {
    printf("%s %zu", key, len);
    for (size_t i = 0; i < len; i++)
        printf(" %02x", bytes[i]);
    putchar('\n');
}

static void put_text(const char *key, const char *hex) {
    uint8_t bytes[512];
    size_t n = 0;
    for (char *end; n < sizeof bytes; n++, hex = end) {
        unsigned long v = strtoul(hex, &end, 16);
        if (end == hex)
            break;
        bytes[n] = (uint8_t)v;
    }
    put_hex(key, bytes, n);
}

static void put_report(long i, double hz, const uint8_t *bytes, size_t len) {
    char key[64];
    long long us = llround((double)i * 1e6 / hz);
    snprintf(key, sizeof key, "E: %06lld.%06lld", us / 1000000, us % 1000000);
    put_hex(key, bytes, len);
}

static void put_i16(uint8_t *at, double value) {
    uint16_t v = (uint16_t)(int16_t)lround(value);
    at[0] = (uint8_t)v;
    at[1] = (uint8_t)(v >> 8);
}

static void numbered(long count, double hz) {
    put_text("R:", "06 00 ff 09 01 a1 01 15 00 26 ff 00 75 08 85 01 95 1f 09 01 81 02 "
                   "85 02 95 07 09 02 91 02 85 03 95 07 09 03 b1 02 c0");
    printf("N: Numbered reports\nI: 3 1209 0001\n");
    put_text("# F:", "03 01 02 03 04 05 06 07");
    for (long i = 0; i < count; i++) {
        uint8_t report[32] = {1};
        for (int k = 0; k < 4; k++)
            report[1 + k] = (uint8_t)(i >> 8 * k);
        for (int k = 5; k < 32; k++)
            report[k] = (uint8_t)(i + k);
        put_report(i, hz, report, sizeof report);
    }
}

static void head_of_slimevr(void) {
    put_text("R:", "05 01 09 00 a1 01 15 00 26 ff 00 75 08 95 40 09 01 81 02 95 40 09 01 91 02 c0");
    printf("N: SlimeVR Receiver\nI: 3 1209 7690\n");
}

static void garbage(long count, double hz) {
    uint32_t state = 1;
    head_of_slimevr();
    for (long i = 0; i < count; i++) {
        uint8_t report[64];
        for (size_t k = 0; k < sizeof report; k++) {
            state = state * 1664525 + 1013904223;
            report[k] = (uint8_t)(state >> 24);
        }
        if (i % 2) { // a tracker, turned by nothing at all
            const uint8_t registered[16] = {255, 7, 1};
            memcpy(report, registered, sizeof registered);
            memset(report + 16, 0, 16);
            report[16] = 1;
            report[17] = 7;
        }
        put_report(i, hz, report, i % 4 ? sizeof report : 1 + report[0] % sizeof report);
    }
}

static void slimevr(long count, double hz, double yaw) {
    head_of_slimevr();
    for (long i = 0; i < count; i++) {
        uint8_t report[64] = {255, 0, 1, 2, 3, 4, 5, 6};
        double half = 0.5 * (yaw + 1e-3 * (double)i);
        // Four packets: who the tracker is, and three times where (the firmware repeats itself).
        // Its world has z up, and worn upright it is turned by a quarter about x there.
        double c = 32767 * sqrt(0.5) * cos(half), s = 32767 * sqrt(0.5) * sin(half);
        for (int k = 1; k < 4; k++) {
            uint8_t *p = report + 16 * k;
            p[0] = 1;
            put_i16(p + 2, c);
            put_i16(p + 4, s);
            put_i16(p + 6, s);
            put_i16(p + 8, c);
            put_i16(p + 14, 9.81 * 128);
        }
        put_report(i, hz, report, sizeof report);
    }
}

static void android(long count, double hz, double yaw) {
    put_text("R:", "05 20 09 e1 a1 01 85 02 0a 08 03 15 00 26 ff 00 75 08 95 17 b1 03 0a 02 03 "
                   "95 10 b1 03 85 01 0a 16 03 15 00 25 01 75 01 95 01 a1 02 0a 40 08 0a 41 08 "
                   "b1 00 c0 0a 19 03 a1 02 0a 55 08 0a 51 08 b1 00 c0 0a 0e 03 15 00 25 3f 35 "
                   "0a 45 64 75 06 95 01 66 01 10 55 0d b1 02 0a 44 05 16 01 80 26 ff 7f 37 60 "
                   "4f 46 ed 47 a1 b0 b9 12 55 08 75 10 95 03 81 02 0a 45 05 16 01 80 26 ff 7f "
                   "35 e0 45 20 55 00 75 10 95 03 81 02 0a 46 05 15 00 26 ff 00 35 00 45 00 55 "
                   "00 75 08 95 01 81 02 c0");
    printf("N: Head tracker\nI: 5 054c 0e41\n");
    uint8_t about[40] = {2};
    memcpy(about + 1, "#AndroidHeadTracker#1.0", 23);
    memcpy(about + 32, "BT\x01\x02\x03\x04\x05\x06", 8);
    put_hex("# F:", about, sizeof about);
    put_text("# F:", "01 00");
    for (long i = 0; i < count; i++) {
        uint8_t report[14] = {1};
        double turn = yaw + 1e-4 * (double)i;
        put_i16(report + 5, 32767 / 3.14159265 * remainder(turn, 2 * 3.14159265));
        put_i16(report + 11, 32767 / 32.0 * 1e-4 * hz);
        put_report(i, hz, report, sizeof report);
    }
}

int main(int argc, char **argv) {
    const char *kind = argc > 3 ? argv[1] : "";
    long count = argc > 3 ? atol(argv[2]) : 0;
    double hz = argc > 3 ? atof(argv[3]) : 0, yaw = argc > 4 ? atof(argv[4]) : 0;
    if (count > 0 && hz > 0 && strcmp(kind, "numbered") == 0)
        numbered(count, hz);
    else if (count > 0 && hz > 0 && strcmp(kind, "slimevr") == 0)
        slimevr(count, hz, yaw);
    else if (count > 0 && hz > 0 && strcmp(kind, "android") == 0)
        android(count, hz, yaw);
    else if (count > 0 && hz > 0 && strcmp(kind, "garbage") == 0)
        garbage(count, hz);
    else {
        fprintf(stderr, "usage: make_recording numbered|slimevr|android|garbage COUNT HZ [YAW]\n");
        return 2;
    }
    return fflush(stdout) == 0 ? 0 : 1;
}
