#include <math.h>

#include "src/device/drivers/fused.h"
#include "src/device/hid/driver.h"
#include "tests/device/hid/bytes_of.h"
#include "tests/device/mutate.h"

// Devices as text: "VENDOR PRODUCT BUS / descriptor / report / …" in hexadecimal; a report that
// begins with "F" is a feature report. Every driver is asked, and the one that says yes is fed.

static void require(bool ok, const char *what) {
    if (ok)
        return;
    fprintf(stderr, "broken: %s\n", what);
    abort();
}

static void check_samples(const struct ap_driver_samples *samples) {
    require(samples->count >= 0 && samples->count <= AP_DRIVER_SAMPLES_MAX, "number of samples");
    for (int i = 0; i < samples->count; i++) {
        const struct ap_driver_sample *s = &samples->at[i];
        struct ap_quat q = s->pose.q;
        double square = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
        require(fabs(square - 1) < 1e-12, "unit quaternion");
        require(isfinite(s->pose.p.x + s->pose.p.y + s->pose.p.z), "finite place");
        require(isfinite(s->angular_velocity_rad_s.x + s->angular_velocity_rad_s.y), "finite rate");
        require(s->tracker >= 0 && s->tracker < 256, "tracker");
        require(s->trigger >= 0 && s->trigger <= 1, "trigger");
        require(s->battery >= 0 && s->battery <= 1, "battery");
    }
}

// What a parsed descriptor promises, and every field of it read from these bytes.
static void walk_fields(const struct ap_hid_descriptor *d, const uint8_t *bytes, size_t len) {
    uint8_t copy[256];
    size_t n = len < sizeof copy ? len : sizeof copy;
    memcpy(copy, bytes, n);
    require(d->field_count <= AP_HID_FIELDS_MAX && d->usage_count <= AP_HID_USAGES_MAX, "bounds");
    for (int i = 0; i < d->field_count; i++) {
        const struct ap_hid_field *f = &d->fields[i];
        uint64_t end = f->bit_offset + (uint64_t)f->size_bits * f->count;
        require(end <= d->report_bits[f->kind][f->report_id], "field within its report");
        require(f->first_usage + f->usage_ranges <= d->usage_count, "usages within the table");
        require(f->collection < d->collection_count, "collection");
        for (uint32_t k = 0; k < 3; k++) {
            struct ap_hid_value v;
            uint32_t at;
            uint32_t usage = ap_hid_usage_at(d, f, k);
            if (usage && k < f->count)
                require(ap_hid_find(d, f->kind, usage, 0, &at) >= 0, "usage found again");
            if (!ap_hid_extract(f, copy, n, k, &v))
                continue;
            require(isfinite(v.physical), "finite value");
            require(ap_hid_insert(f, copy, n, k, v.raw), "inserted");
        }
    }
    // The id's byte may be of a field of descriptors that begin to number late.
    require(memcmp(copy, bytes, n) == 0, "what was read and written again has not changed");
}

static struct ap_device_info info;
static union {
    max_align_t align;
    unsigned char bytes[AP_DRIVER_STATE_MAX];
} state;

// By driver, so that one that is never reached is seen.
static long reached[32];

static void count_samples(const struct ap_driver *driver) {
    for (int i = 0; i < ap_driver_count() && i < 32; i++)
        reached[i] += ap_driver_at(i) == driver;
}

static void take_part(int part, const char *text, size_t len, const struct ap_driver **driver) {
    uint8_t bytes[4096];
    size_t n = bytes_of(text, len, bytes, part == 1 ? sizeof bytes : 300);
    if (part == 0 && n >= 4) {
        info.vendor = (uint16_t)(bytes[0] << 8 | bytes[1]);
        info.product = (uint16_t)(bytes[2] << 8 | bytes[3]);
        info.bus = n >= 6 ? (uint16_t)(bytes[4] << 8 | bytes[5]) : 0;
    } else if (part == 1) {
        struct ap_error err = {""};
        if (ap_hid_parse_descriptor(&err, bytes, n, &info.descriptor))
            require(err.text[0] && info.descriptor.field_count == 0, "a sentence, nothing else");
    } else if (part > 1 && len && memchr(text, 'F', len)) {
        if (n && n <= AP_DEVICE_FEATURE_BYTES && info.feature_count < AP_DEVICE_FEATURES_MAX) {
            info.features[info.feature_count].len = n;
            memcpy(info.features[info.feature_count++].bytes, bytes, n);
        }
    } else if (part > 1) {
        walk_fields(&info.descriptor, bytes, n);
        if (!*driver) {
            *driver = ap_driver_find(&info);
            if (*driver && (*driver)->init)
                (*driver)->init(&state, &info);
            struct ap_driver_step steps[AP_DRIVER_STEPS_MAX];
            int count = *driver && (*driver)->start ? (*driver)->start(&info, steps) : 0;
            require(count >= 0 && count <= AP_DRIVER_STEPS_MAX, "number of steps");
            for (int i = 0; i < count; i++)
                require(steps[i].len <= AP_DRIVER_STEP_BYTES, "length of a step");
        }
        if (!*driver)
            return;
        // Just as long as it is, so that a reader that goes beyond is seen.
        uint8_t *exact = malloc(n ? n : 1);
        require(exact, "memory");
        memcpy(exact, bytes, n);
        if (info.vendor == 0x054c && info.bus == 5 && n == 78 && part % 2) {
            // Nobody finds a check sum by chance.
            uint8_t header = 0xa1;
            uint32_t crc = ap_crc32(ap_crc32(0, &header, 1), exact, 74);
            for (int i = 0; i < 4; i++)
                exact[74 + i] = (uint8_t)(crc >> 8 * i);
        }
        struct ap_driver_samples samples;
        samples.count = 0;
        samples.why[0] = 0;
        enum ap_report_verdict verdict =
            (*driver)->parse(&state, &info, part * INT64_C(30000000), exact, n, &samples);
        require(verdict != AP_REPORT_BAD || samples.why[0], "a sentence with what is bad");
        struct ap_driver_step step;
        if ((*driver)->ask && (*driver)->ask(&state, &step))
            require(step.len <= AP_DRIVER_STEP_BYTES, "length of a question");
        if (verdict == AP_REPORT_OK)
            check_samples(&samples);
        if (verdict == AP_REPORT_OK && samples.count)
            count_samples(*driver);
        free(exact);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len) {
    const char *text = (const char *)bytes, *end = text + len;
    memset(&info, 0, sizeof info);
    memset(&state, 0, sizeof state);
    const struct ap_driver *driver = NULL;
    for (int part = 0; text <= end && part < 64; part++) {
        const char *slash = text < end ? memchr(text, '/', (size_t)(end - text)) : NULL;
        const char *to = slash ? slash : end;
        take_part(part, text, (size_t)(to - text), &driver);
        text = to + 1;
    }
    return 0;
}

#ifndef ANTIPODE_LIBFUZZER
static const char *const seeds[] = {
    "054c 0df0 /" ANDROID_DESCRIPTOR
    "/07 48e4 5f02 0000 5f00 4700 a8ff 00/07 59e4 6602 e4ff 0000 0000 0000 00/"
    "07 59e4 6602 e4ff 0000 0000 0000 01",
    "054c 0df0 /" ANDROID_DESCRIPTOR "/F 05 23 41 6e 64 72 6f 69 64/F 09 00/07 48e4 5f02",
    "256f c633 /" CAP_DESCRIPTOR "/01 10 20 30/02 81 7f 05/03 05 08/01 00 00 00",
    "8087 0ac2 /" ORIENTATION_DESCRIPTOR "/03 0000 0000 825a 825a/02 0000 0000 0000 ff7f",
    ("1209 7690 /05 01 09 00 a1 01 09 00 75 08 95 40 81 02 c0"
     "/ff 00 01 00 00 ee ff c0 00 00 00 00 00 00 00 00 01 00 9c 02 e9 c8 85 8c 7b fd 00 00 00 "
     "00 00 00/07 00 02 00 00 00 12 53 99 00 00 00 00 00 00 00"),
    ("1532 0300 //00 00 00 00 00 00 00 2a 64 00 c8 00 2c 01 ff 7f 00 00 00 00 00 00 01 00 00 00 "
     "00 ff 00 00 9c ff 00 00 00 00 00 00 ff 7f 00 00 00 00 00 00 00 00 00 00 00 00"),
    ("054c 0ce6 0003//F 05 0a 00 14 00 1e 00 98 22 68 dd 98 22 68 dd 98 22 68 dd 1c 02 1c "
     "02 64 20 64 e0 64 20 64 e0 64 20 64 e0 00 00 00 00 00 00/01 00 00 00 00 00 00 00 20 "
     "01 00 00 00 00 00 00 10 00 20 00 30 00 00 00 00 20 00 00 00 00 00 00 00 00 00 00 00 "
     "00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 08 00 00 00 00 00 00 00 00 00 00/01 "
     "00 00 00 00 00 00 00 20 01 00 00 00 00 00 00 10 00 20 00 30 00 00 00 00 20 00 00 e0 "
     "2e 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 08 00 00 00 "
     "00 00 00 00 00 00 00"),
    ("054c 0ce6 0005//31 00 00 00 00 00 00 00 00 20 00 00 00 00 00 00 00 10 00 20 00 30 00"
     " 00 00 00 20 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00"
     " 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00/31"
     " 00 00 00 00 00 00 00 00 20 00 00 00 00 00 00 00 10 00 20 00 30 00 00 00 00 20 00 00"
     " e0 2e 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00"
     " 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00"),
    ("054c 09cc 0003//01 00 00 00 00 28 00 00 00 00 00 00 00 10 00 20 00 30 00 00 00 00 20"
     " 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00"
     " 00 00 00 00 00 00 00 00 00 00 00 00 00/01 00 00 00 00 28 00 00 00 00 ee 02 00 10 00"
     " 20 00 30 00 00 00 00 20 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00"
     " 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00"),
    ("054c 05c4 0005//11 00 00 00 00 00 00 00 00 00 00 00 00 00 00 10 00 20 00 30 00 00 00"
     " 00 20 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00"
     " 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00/11"
     " 00 00 00 00 00 00 00 00 00 00 00 ee 02 00 10 00 20 00 30 00 00 00 00 20 00 00 00 00"
     " 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00"
     " 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00/11 00 00 00 00 00 00"
     " 00 00 00 00 00 dc 05 00 10 00 20 00 30 00 00 00 00 20 00 00 00 00 00 00 00 00 00 00"
     " 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00"
     " 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00"),
    ("3318 0424 0003//01 02 00 00 40 42 0f 00 00 00 00 00 d0 07 00 00 80 00 10 00 00 20 00"
     " 00 30 00 00 10 00 00 00 80 00 00 00 00 00 00 00 00 00 08 00 00 00 00 00 00 00 00 00"
     " 00 00 00 00 00 00 00 00 00 00 00 00 00/01 02 00 00 80 84 1e 00 00 00 00 00 d0 07 00"
     " 00 80 00 10 00 00 20 00 00 30 00 00 10 00 00 00 80 00 00 00 00 00 00 00 00 00 08 00"
     " 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00/aa 00"),
    // {"IMU":{"device_1":{"gyro_bias":[0,0,1],"accel_bias":[0,1]
    ("3318 0424 0003//aa 00 00 00 00 07 00 14 60 00 00 00/aa 00 00 00 00 27 00 15 7b 22 49 4d"
     " 55 22 3a 7b 22 64 65 76 69 63 65 5f 31 22 3a 7b 22 67 79 72 6f 5f 62 69 61 73 22 3a 5b"
     "/aa 00 00 00 00 1b 00 15 30 2c 30 2c 31 5d 2c 22 61 63 63 65 6c 5f 62 69 61 73 22 3a 5b"
     " 30 2c/aa 00 00 00 00 07 00 15 31 5d 7d 7d"),
    ("057e 2007 0005//21 00 00 00 00 00 00 00 00 00 00 00 00 00 10 20 60 00 00 18 00 00 00"
     " 00 00 00 00 40 00 40 00 40 00 00 00 00 00 00 3b 34 3b 34 3b 34 00 00 00 00 00/30 00"
     " 80 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 10 10 00 20 00 30 00 00 00 00 00 00"
     " 10 10 00 20 00 30 00 00 00 00 00 00 10 10 00 20 00 30 00/30 03 80 00 00 00 00 00 00"
     " 00 00 00 00 00 00 00 00 00 10 10 00 20 00 30 00 00 00 00 00 00 10 10 00 20 00 30 00"
     " 00 00 00 00 00 10 10 00 20 00 30 00/30 02 80 00 00 00 00 00 00 00 00 00 00 00 00 00"
     " 00 00 10 10 00 20 00 30 00 00 00 00 00 00 10 10 00 20 00 30 00 00 00 00 00 00 10 10"
     " 00 20 00 30 00"),
    ("2833 0001 0003//F 02 00 00 20 01 e8 03/01 03 10 00 00 00 00 00 00 00 00 0b f8 00 00 "
     "00 00 00 40 00 00 00 08 00 00 00 00 0b f8 00 00 00 00 00 00 00 00 00 00 00 00 00 00 "
     "00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00/01 03 13 00 00 00 00 00 00 "
     "00 00 0b f8 00 00 00 00 00 40 00 00 00 08 00 00 00 00 0b f8 00 00 00 00 00 00 00 00 "
     "00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00"),
    ("2833 0031 0003//0b 00 00 02 00 00 00 00 10 00 00 00 00 00 00 0b f8 00 00 00 00 00 40"
     " 00 00 00 08 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00"
     " 00 00 00 00 00 00 00 00 00 00 00 00 00/0b 00 00 02 00 00 00 00 e0 07 00 00 00 00 00"
     " 0b f8 00 00 00 00 00 40 00 00 00 08 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00"
     " 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00"),
};
static const char *const words[] = {
    "/",        "ff",    "00",          "80",          "85 01",       "a1 01",
    "c0",       "a4",    "b4",          "95 ff",       "75 20",       "96 ff ff",
    "77 ff ff", "81 02", "b1 00",       "fe 03",       "0a 83 04",    "0a 44 05",
    "15 81",    "25 7f", "17 00000080", "27 ffffff7f", "47 ffffffff", "55 0f",
    "F",        "05 20", "05 01",       "09 30",       "19 00",       "2b ffffffff"};

int main(int argc, char **argv) {
    int rounds = argc > 1 ? atoi(argv[1]) : 20000;
    int status = mutate_run(seeds, sizeof seeds / sizeof *seeds, words,
                            sizeof words / sizeof *words, rounds);
    for (int i = 0; rounds > 100 && i < ap_driver_count(); i++) {
        printf("%s: %ld reports with samples\n", ap_driver_at(i)->name, reached[i]);
        require(reached[i] > 100, "every driver is reached");
    }
    return status;
}
#endif
