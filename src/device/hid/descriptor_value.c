#include <math.h>

#include "src/device/hid/descriptor.h"

// What a parsed descriptor says about reports.

size_t ap_hid_report_bytes(const struct ap_hid_descriptor *d, enum ap_hid_kind kind, uint8_t id) {
    return (d->report_bits[kind][id] + 7) / 8;
}

uint32_t ap_hid_usage_at(const struct ap_hid_descriptor *d, const struct ap_hid_field *field,
                         uint32_t index) {
    const struct ap_hid_range *r = &d->usages[field->first_usage];
    for (uint32_t i = 0; i < field->usage_ranges; i++) {
        uint32_t more = r[i].max - r[i].min; // after the first
        if (index <= more)
            return r[i].min + index;
        index -= more + 1;
    }
    // A variable field with more values than usages repeats the last one.
    return field->is_variable && field->usage_ranges ? r[field->usage_ranges - 1].max : 0;
}

static bool find_usage(const struct ap_hid_descriptor *d, const struct ap_hid_field *field,
                       uint32_t usage, uint32_t *index) {
    uint64_t before = 0;
    for (uint32_t i = 0; i < field->usage_ranges; i++) {
        struct ap_hid_range r = d->usages[field->first_usage + i];
        if (usage >= r.min && usage <= r.max) {
            uint64_t at = before + (usage - r.min);
            *index = (uint32_t)at;
            return at <= UINT32_MAX && (!field->is_variable || at < field->count);
        }
        before += (uint64_t)(r.max - r.min) + 1;
    }
    return false;
}

int ap_hid_find(const struct ap_hid_descriptor *d, enum ap_hid_kind kind, uint32_t usage, int from,
                uint32_t *index) {
    for (int i = from; i < d->field_count; i++)
        if (d->fields[i].kind == kind && find_usage(d, &d->fields[i], usage, index))
            return i;
    return -1;
}

bool ap_hid_is_within(const struct ap_hid_descriptor *d, int collection, uint32_t usage) {
    for (; collection >= 0; collection = d->collections[collection].parent)
        if (d->collections[collection].usage == usage)
            return true;
    return false;
}

bool ap_hid_has_application(const struct ap_hid_descriptor *d, uint32_t usage) {
    for (int i = 0; i < d->collection_count; i++)
        if (d->collections[i].type == 1 && d->collections[i].usage == usage)
            return true;
    return false;
}

// Where the value's first bit stands; false where it does not lie within the report.
static bool locate(const struct ap_hid_field *f, const uint8_t *report, size_t len, uint32_t index,
                   uint64_t *bit) {
    if (index >= f->count || f->size_bits < 1 || f->size_bits > 32)
        return false;
    if (len == 0 || (f->report_id && report[0] != f->report_id))
        return false;
    *bit = f->bit_offset + (uint64_t)index * f->size_bits;
    return *bit + f->size_bits <= (uint64_t)len * 8;
}

static double to_physical(const struct ap_hid_field *f, double raw) {
    double v = raw;
    double pmin = (double)f->physical_min, pmax = (double)f->physical_max;
    double lmin = (double)f->logical_min, lmax = (double)f->logical_max;
    if ((pmin != 0 || pmax != 0) && lmax != lmin)
        v = pmin + (raw - lmin) / (lmax - lmin) * (pmax - pmin);
    return f->exponent ? v * pow(10, f->exponent) : v;
}

bool ap_hid_extract(const struct ap_hid_field *f, const uint8_t *report, size_t len, uint32_t index,
                    struct ap_hid_value *value) {
    uint64_t bit;
    if (!locate(f, report, len, index, &bit))
        return false;
    uint64_t bits = 0; // at most 32 bits from within 5 bytes
    size_t first = (size_t)(bit / 8), last = (size_t)((bit + f->size_bits - 1) / 8);
    for (size_t i = first; i <= last; i++)
        bits |= (uint64_t)report[i] << (8 * (i - first));
    bits = bits >> (bit % 8) & ((UINT64_C(1) << f->size_bits) - 1);
    value->raw = (int64_t)bits;
    if (f->logical_min < 0 && bits >> (f->size_bits - 1))
        value->raw -= INT64_C(1) << f->size_bits;
    value->physical = to_physical(f, (double)value->raw);
    return true;
}

bool ap_hid_insert(const struct ap_hid_field *f, uint8_t *report, size_t len, uint32_t index,
                   int64_t raw) {
    uint64_t bit;
    if (!locate(f, report, len, index, &bit))
        return false;
    for (uint32_t k = 0; k < f->size_bits; k++) {
        uint8_t mask = (uint8_t)(1u << ((bit + k) % 8));
        uint8_t *byte = &report[(bit + k) / 8];
        *byte = (uint8_t)(((uint64_t)raw >> k & 1) ? *byte | mask : *byte & ~mask);
    }
    return true;
}

int64_t ap_hid_raw_from_physical(const struct ap_hid_field *f, double physical) {
    double lmin = (double)f->logical_min, lmax = (double)f->logical_max;
    double at_min = to_physical(f, lmin), at_max = to_physical(f, lmax);
    if (at_max == at_min || !isfinite(physical))
        return f->logical_min;
    double raw = lmin + round((physical - at_min) / (at_max - at_min) * (lmax - lmin));
    return (int64_t)(raw < lmin ? lmin : raw > lmax ? lmax : raw);
}
