#ifndef ANTIPODE_DEVICE_HID_DESCRIPTOR_H
#define ANTIPODE_DEVICE_HID_DESCRIPTOR_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "src/base/status.h"

// HID report descriptors (USB HID 1.11, section 6.2.2): bytes to a flat table of fields, and fields
// to values. Pure; nothing is allocated, so what a hostile descriptor can cost is fixed.

enum {
    AP_HID_DESCRIPTOR_MAX = 4096, // bytes; the Linux kernel's limit, too
    AP_HID_REPORT_MAX = 16384,    // bytes of one report, its id included
    AP_HID_FIELDS_MAX = 256,
    AP_HID_USAGES_MAX = 1024, // ranges of usages, of all fields together
    AP_HID_COLLECTIONS_MAX = 128,
    AP_HID_DEPTH_MAX = 32, // collections in collections
    AP_HID_STACK_MAX = 8,  // pushes
};

// A usage: its page in the upper 16 bits.
#define AP_HID_USAGE(page, id) ((uint32_t)(page) << 16 | (uint32_t)(id))

enum ap_hid_kind { AP_HID_INPUT, AP_HID_OUTPUT, AP_HID_FEATURE };

struct ap_hid_range {
    uint32_t min, max;
};

// `count` values of `size_bits` each, one after the other, from bit `bit_offset` of the report as
// hidraw and hidapi give it: a numbered one begins with the byte of its id.
struct ap_hid_field {
    enum ap_hid_kind kind;
    uint8_t report_id; // 0: reports are not numbered
    bool is_variable;  // false: an array, whose values say which usage is meant
    bool is_constant, is_relative;
    int collection; // the innermost one it lies in; −1: none
    uint32_t bit_offset, size_bits, count;
    uint32_t first_usage, usage_ranges; // into the descriptor's usages
    int64_t logical_min, logical_max, physical_min, physical_max;
    int exponent; // of ten
    uint32_t unit;
};

struct ap_hid_collection {
    uint8_t type; // 0 physical, 1 application, 2 logical, …
    uint32_t usage;
    int parent; // −1: none
};

struct ap_hid_descriptor {
    bool is_numbered;
    int field_count, collection_count;
    uint32_t usage_count;
    uint32_t report_bits[3][256]; // by kind and id, the id's byte included; 0: no such report
    struct ap_hid_field fields[AP_HID_FIELDS_MAX];
    struct ap_hid_collection collections[AP_HID_COLLECTIONS_MAX];
    struct ap_hid_range usages[AP_HID_USAGES_MAX];
};

// Padding (constants without a usage) gives no field. AP_INPUT with the byte's number. On failure
// *descriptor is empty.
enum ap_status ap_hid_parse_descriptor(struct ap_error *err, const uint8_t *bytes, size_t len,
                                       struct ap_hid_descriptor *descriptor);

// The length of a report as hidraw gives it; 0: there is none with that id.
size_t ap_hid_report_bytes(const struct ap_hid_descriptor *d, enum ap_hid_kind kind, uint8_t id);

// How long an input report that begins so is to be.
static inline size_t ap_hid_input_bytes(const struct ap_hid_descriptor *d, const uint8_t *report) {
    return ap_hid_report_bytes(d, AP_HID_INPUT, d->is_numbered ? report[0] : 0);
}

// The usage of value `index` of a variable field, or of the choice `index` of an array; 0: none.
uint32_t ap_hid_usage_at(const struct ap_hid_descriptor *d, const struct ap_hid_field *field,
                         uint32_t index);

// The first field of that kind, from number `from`, one of whose usages this is, and the index of
// the usage in it (as ap_hid_usage_at counts); −1: none.
int ap_hid_find(const struct ap_hid_descriptor *d, enum ap_hid_kind kind, uint32_t usage, int from,
                uint32_t *index);

// Whether the collection, or one around it, has this usage.
bool ap_hid_is_within(const struct ap_hid_descriptor *d, int collection, uint32_t usage);

// Whether there is an application collection of this usage.
bool ap_hid_has_application(const struct ap_hid_descriptor *d, uint32_t usage);

struct ap_hid_value {
    int64_t raw; // signed where the logical minimum is negative
    // (pmin + (raw − lmin)/(lmax − lmin)·(pmax − pmin))·10^exponent; raw·10^exponent where the
    // descriptor gives no physical range. Not clamped: devices go beyond what they declare.
    double physical;
};

// Value `index` of the field. False where the report is another one or too short, or the value has
// more than 32 bits.
bool ap_hid_extract(const struct ap_hid_field *field, const uint8_t *report, size_t len,
                    uint32_t index, struct ap_hid_value *value);

// Writes the lowest bits of `raw`, under the same conditions (the id's byte is the caller's).
bool ap_hid_insert(const struct ap_hid_field *field, uint8_t *report, size_t len, uint32_t index,
                   int64_t raw);

// The raw value nearest to a physical one, within the logical range.
int64_t ap_hid_raw_from_physical(const struct ap_hid_field *field, double physical);

#endif
