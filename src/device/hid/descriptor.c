#include "src/device/hid/descriptor.h"

#include <string.h>

enum { TYPE_MAIN, TYPE_GLOBAL, TYPE_LOCAL, TYPE_RESERVED };

enum {
    MAIN_INPUT = 8,
    MAIN_OUTPUT = 9,
    MAIN_COLLECTION = 10,
    MAIN_FEATURE = 11,
    MAIN_END_COLLECTION = 12,
};

enum {
    GLOBAL_USAGE_PAGE,
    GLOBAL_LOGICAL_MIN,
    GLOBAL_LOGICAL_MAX,
    GLOBAL_PHYSICAL_MIN,
    GLOBAL_PHYSICAL_MAX,
    GLOBAL_EXPONENT,
    GLOBAL_UNIT,
    GLOBAL_REPORT_SIZE,
    GLOBAL_REPORT_ID,
    GLOBAL_REPORT_COUNT,
    GLOBAL_PUSH,
    GLOBAL_POP,
};

enum { LOCAL_USAGE, LOCAL_USAGE_MIN, LOCAL_USAGE_MAX, LOCAL_DELIMITER = 10 };

enum { FLAG_CONSTANT = 1, FLAG_VARIABLE = 2, FLAG_RELATIVE = 4 };

static const char *const kind_names[] = {"input", "output", "feature"};

// An item's data: what it is as a number depends on what it is for.
struct item {
    size_t at; // of its first byte, for messages
    unsigned type, tag, size;
    uint32_t bits;
};

struct globals {
    uint32_t page, unit, report_size, report_count;
    struct item logical_min, logical_max, physical_min, physical_max;
    int exponent;
    uint8_t report_id;
};

struct parser {
    struct ap_hid_descriptor *d;
    struct ap_error *err;
    struct globals g, stack[AP_HID_STACK_MAX];
    int stack_depth;
    int collection, depth; // the innermost open one
    // Usages of the main item to come stand at the end of the pool until it takes or drops them.
    uint32_t local_ranges;
    bool has_min, has_max;
    uint32_t local_min, local_max;
    unsigned delimiter; // 0: outside a set, 1: its first usage is to come, 2: it was there
};

static int64_t as_signed(struct item i) {
    if (i.size == 1)
        return (int8_t)i.bits;
    return i.size == 2 ? (int16_t)i.bits : (int32_t)i.bits;
}

// A maximum is signed only where its minimum is negative: 25 FF is 255 after 15 00.
static int64_t as_maximum(struct item i, int64_t min) {
    return min < 0 ? as_signed(i) : (int64_t)i.bits;
}

static enum ap_status bad(struct parser *p, const struct item *i, const char *what) {
    return ap_fail(p->err, AP_INPUT, "report descriptor, byte %zu: %s", i->at, what);
}

static enum ap_status add_range(struct parser *p, const struct item *i, uint32_t min,
                                uint32_t max) {
    struct ap_hid_descriptor *d = p->d;
    if (d->usage_count + p->local_ranges == AP_HID_USAGES_MAX)
        return bad(p, i, "more than 1024 usages");
    if (max < min)
        return bad(p, i, "a usage range that ends before it begins");
    d->usages[d->usage_count + p->local_ranges++] = (struct ap_hid_range){min, max};
    return AP_OK;
}

static uint32_t full_usage(const struct parser *p, const struct item *i) {
    return i->size == 4 ? i->bits : AP_HID_USAGE(p->g.page & 0xffff, i->bits);
}

static enum ap_status local_item(struct parser *p, const struct item *i) {
    switch (i->tag) {
    case LOCAL_USAGE:
        // Of a set of alternative usages the first is the preferred one.
        if (p->delimiter == 2)
            return AP_OK;
        p->delimiter = p->delimiter ? 2 : 0;
        return add_range(p, i, full_usage(p, i), full_usage(p, i));
    case LOCAL_USAGE_MIN:
        p->local_min = full_usage(p, i);
        p->has_min = true;
        break;
    case LOCAL_USAGE_MAX:
        p->local_max = full_usage(p, i);
        p->has_max = true;
        break;
    case LOCAL_DELIMITER:
        p->delimiter = i->bits & 1;
        return AP_OK;
    default:
        return AP_OK;
    }
    if (!p->has_min || !p->has_max)
        return AP_OK;
    p->has_min = p->has_max = false;
    return add_range(p, i, p->local_min, p->local_max);
}

static enum ap_status global_item(struct parser *p, const struct item *i) {
    struct globals *g = &p->g;
    switch (i->tag) {
    case GLOBAL_USAGE_PAGE:
        g->page = i->bits;
        break;
    case GLOBAL_LOGICAL_MIN:
        g->logical_min = *i;
        break;
    case GLOBAL_LOGICAL_MAX:
        g->logical_max = *i;
        break;
    case GLOBAL_PHYSICAL_MIN:
        g->physical_min = *i;
        break;
    case GLOBAL_PHYSICAL_MAX:
        g->physical_max = *i;
        break;
    case GLOBAL_EXPONENT: {
        // A nibble by the standard; some devices write a whole signed byte.
        int64_t e = as_signed(*i);
        g->exponent = e >= 8 && e < 16 ? (int)e - 16 : (int)e;
        if (e < -128 || e > 15)
            return bad(p, i, "a unit exponent that no unit has");
        break;
    }
    case GLOBAL_UNIT:
        g->unit = i->bits;
        break;
    case GLOBAL_REPORT_SIZE:
        g->report_size = i->bits;
        break;
    case GLOBAL_REPORT_COUNT:
        g->report_count = i->bits;
        break;
    case GLOBAL_REPORT_ID:
        if (i->bits == 0 || i->bits > 255)
            return bad(p, i, "a report id that is not 1 to 255");
        g->report_id = (uint8_t)i->bits;
        p->d->is_numbered = true;
        break;
    case GLOBAL_PUSH:
        if (p->stack_depth == AP_HID_STACK_MAX)
            return bad(p, i, "more than 8 pushes");
        p->stack[p->stack_depth++] = *g;
        break;
    case GLOBAL_POP:
        if (p->stack_depth == 0)
            return bad(p, i, "a pop without a push");
        *g = p->stack[--p->stack_depth];
        break;
    default:
        break;
    }
    return AP_OK;
}

static enum ap_status open_collection(struct parser *p, const struct item *i) {
    struct ap_hid_descriptor *d = p->d;
    if (p->depth == AP_HID_DEPTH_MAX)
        return bad(p, i, "more than 32 collections in one another");
    if (d->collection_count == AP_HID_COLLECTIONS_MAX)
        return bad(p, i, "more than 128 collections");
    d->collections[d->collection_count] = (struct ap_hid_collection){
        .type = (uint8_t)i->bits,
        .usage = p->local_ranges ? d->usages[d->usage_count].min : 0,
        .parent = p->collection,
    };
    p->collection = d->collection_count++;
    p->depth++;
    return AP_OK;
}

static enum ap_status close_collection(struct parser *p, const struct item *i) {
    if (p->collection < 0)
        return bad(p, i, "the end of a collection that was not begun");
    p->collection = p->d->collections[p->collection].parent;
    p->depth--;
    return AP_OK;
}

static enum ap_status add_field(struct parser *p, const struct item *i, enum ap_hid_kind kind) {
    struct ap_hid_descriptor *d = p->d;
    const struct globals *g = &p->g;
    uint32_t *bits = &d->report_bits[kind][g->report_id];
    uint32_t at = *bits ? *bits : (g->report_id ? 8 : 0);
    uint64_t size = (uint64_t)g->report_size * g->report_count; // below 2^64
    if (size > AP_HID_REPORT_MAX * 8u - at)
        return ap_fail(p->err, AP_INPUT,
                       "report descriptor, byte %zu: %s report %d is longer than %d bytes", i->at,
                       kind_names[kind], g->report_id, AP_HID_REPORT_MAX);
    *bits = at + (uint32_t)size;
    bool constant = i->bits & FLAG_CONSTANT;
    if (size == 0 || (constant && !p->local_ranges))
        return AP_OK;
    if (d->field_count == AP_HID_FIELDS_MAX)
        return bad(p, i, "more than 256 fields");
    int64_t lmin = as_signed(g->logical_min), pmin = as_signed(g->physical_min);
    d->fields[d->field_count++] = (struct ap_hid_field){
        .kind = kind,
        .report_id = g->report_id,
        .is_variable = i->bits & FLAG_VARIABLE,
        .is_constant = constant,
        .is_relative = i->bits & FLAG_RELATIVE,
        .collection = p->collection,
        .bit_offset = at,
        .size_bits = g->report_size,
        .count = g->report_count,
        .first_usage = d->usage_count,
        .usage_ranges = p->local_ranges,
        .logical_min = lmin,
        .logical_max = as_maximum(g->logical_max, lmin),
        .physical_min = pmin,
        .physical_max = as_maximum(g->physical_max, pmin),
        .exponent = g->exponent,
        .unit = g->unit,
    };
    d->usage_count += p->local_ranges;
    return AP_OK;
}

static enum ap_status main_item(struct parser *p, const struct item *i) {
    enum ap_status st = AP_OK;
    if (i->tag == MAIN_INPUT)
        st = add_field(p, i, AP_HID_INPUT);
    else if (i->tag == MAIN_OUTPUT)
        st = add_field(p, i, AP_HID_OUTPUT);
    else if (i->tag == MAIN_FEATURE)
        st = add_field(p, i, AP_HID_FEATURE);
    else if (i->tag == MAIN_COLLECTION)
        st = open_collection(p, i);
    else if (i->tag == MAIN_END_COLLECTION)
        st = close_collection(p, i);
    p->local_ranges = 0;
    p->has_min = p->has_max = false;
    p->delimiter = 0;
    return st;
}

// The item at `at`; its length in bytes, 0 where it does not end within the descriptor. Long items
// carry nothing that anybody has defined, so they are passed over.
static size_t read_item(const uint8_t *bytes, size_t len, size_t at, struct item *item) {
    uint8_t prefix = bytes[at];
    size_t left = len - at;
    *item = (struct item){.at = at, .type = TYPE_RESERVED};
    if (prefix == 0xfe) {
        size_t total = left >= 3 ? 3 + (size_t)bytes[at + 1] : left + 1;
        return total <= left ? total : 0;
    }
    unsigned size = (prefix & 3) == 3 ? 4 : prefix & 3;
    if (left < 1 + size)
        return 0;
    item->type = prefix >> 2 & 3;
    item->tag = prefix >> 4;
    item->size = size;
    for (unsigned k = 0; k < size; k++)
        item->bits |= (uint32_t)bytes[at + 1 + k] << (8 * k);
    return 1 + size;
}

static enum ap_status parse_items(struct parser *p, const uint8_t *bytes, size_t len) {
    for (size_t at = 0; at < len;) {
        struct item item;
        size_t n = read_item(bytes, len, at, &item);
        if (n == 0)
            return bad(p, &item, "an item that goes beyond the end");
        enum ap_status st = item.type == TYPE_MAIN     ? main_item(p, &item)
                            : item.type == TYPE_GLOBAL ? global_item(p, &item)
                            : item.type == TYPE_LOCAL  ? local_item(p, &item)
                                                       : AP_OK;
        if (st)
            return st;
        at += n;
    }
    struct item end = {.at = len};
    return p->depth ? bad(p, &end, "a collection that does not end") : AP_OK;
}

enum ap_status ap_hid_parse_descriptor(struct ap_error *err, const uint8_t *bytes, size_t len,
                                       struct ap_hid_descriptor *descriptor) {
    memset(descriptor, 0, sizeof *descriptor);
    if (len == 0 || len > AP_HID_DESCRIPTOR_MAX)
        return ap_fail(err, AP_INPUT, "report descriptor: expected 1 to %d bytes, not %zu",
                       AP_HID_DESCRIPTOR_MAX, len);
    struct parser p = {.d = descriptor, .err = err, .collection = -1};
    enum ap_status st = parse_items(&p, bytes, len);
    if (st)
        memset(descriptor, 0, sizeof *descriptor);
    return st;
}
