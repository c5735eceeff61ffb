#include "src/device/hid/recording.h"

#include "src/base/number.h"
#include "src/device/log/decimal.h"
#include "src/device/log/poselog_fields.h"

// What is left of a line.
struct rest {
    const char *line, *at, *end;
};

static bool is_blank(char c) {
    return c == ' ' || c == '\t';
}

static struct ap_field next_word(struct rest *r) {
    while (r->at < r->end && is_blank(*r->at))
        r->at++;
    struct ap_field word = {r->at, 0};
    while (r->at < r->end && !is_blank(*r->at))
        r->at++;
    word.len = (size_t)(r->at - word.text);
    return word;
}

static bool parse_hex(struct ap_field word, uint32_t max, uint32_t *value) {
    uint32_t v = 0;
    if (word.len == 0 || word.len > 8)
        return false;
    for (size_t i = 0; i < word.len; i++) {
        char c = word.text[i];
        int digit = c >= '0' && c <= '9'   ? c - '0'
                    : c >= 'a' && c <= 'f' ? c - 'a' + 10
                    : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                           : -1;
        if (digit < 0)
            return false;
        v = v << 4 | (uint32_t)digit;
    }
    *value = v;
    return v <= max;
}

// "LEN hex…": the size and so many bytes.
static bool parse_bytes(struct rest *r, struct ap_hid_line *out, struct ap_bad_line *bad) {
    struct ap_field size = next_word(r);
    int64_t says;
    if (!ap_parse_int64(size.text, size.len, &says) || says < 0 || says > AP_HID_REPORT_MAX)
        return ap_bad_line_at(bad, r->line, size.text, "a number of bytes, 0 to %d",
                              AP_HID_REPORT_MAX);
    size_t n = 0;
    for (struct ap_field word = next_word(r); word.len; word = next_word(r), n++) {
        uint32_t byte;
        if (n == 0)
            out->bytes_column = (size_t)(word.text - r->line) + 1;
        if (n == (size_t)says)
            return ap_bad_line_at(bad, r->line, word.text, "the line to end after %zu bytes", n);
        if (!parse_hex(word, 0xff, &byte))
            return ap_bad_line_at(bad, r->line, word.text, "a byte in hexadecimal");
        out->bytes[n] = (uint8_t)byte;
    }
    if (n != (size_t)says)
        return ap_bad_line_at(bad, r->line, r->end, "%d bytes as the line says, not %zu", (int)says,
                              n);
    out->byte_count = n;
    return true;
}

static bool parse_report(struct rest *r, struct ap_hid_line *out, struct ap_bad_line *bad) {
    struct ap_field time = next_word(r);
    bool read = ap_decimal_seconds_ns(time.text, time.len, &out->t_ns);
    out->t_column = (size_t)(time.text - r->line) + 1;
    return ap_field_time(r->line, time.text, read, out->t_ns, "decimal seconds", bad) &&
           parse_bytes(r, out, bad);
}

static bool parse_ids(struct rest *r, struct ap_hid_line *out, struct ap_bad_line *bad) {
    uint16_t *const ids[3] = {&out->bus, &out->vendor, &out->product};
    for (int i = 0; i < 3; i++) {
        struct ap_field word = next_word(r);
        uint32_t id;
        if (!parse_hex(word, 0xffff, &id))
            return ap_bad_line_at(bad, r->line, word.text,
                                  "bus, vendor and product, each in hexadecimal");
        *ids[i] = (uint16_t)id;
    }
    return true;
}

static bool parse_device(struct rest *r, struct ap_hid_line *out, struct ap_bad_line *bad) {
    struct ap_field word = next_word(r);
    if (ap_parse_int64(word.text, word.len, &out->device) && out->device >= 0)
        return true;
    return ap_bad_line_at(bad, r->line, word.text, "the number of a device");
}

static void parse_name(struct rest *r, struct ap_hid_line *out) {
    while (r->at < r->end && is_blank(*r->at))
        r->at++;
    out->text = (struct ap_field){r->at, (size_t)(r->end - r->at)};
}

// Behind "#": the letter F, or nothing.
static struct rest comment_of(const char *line, size_t len) {
    struct rest r = {line, line, line + len};
    while (r.at < r.end && (is_blank(*r.at) || *r.at == '#'))
        r.at++;
    return r;
}

bool ap_hid_line_is_feature(const char *line, size_t len) {
    struct rest r = comment_of(line, len);
    return ap_log_line_is_empty(line, len) && r.end - r.at >= 2 && r.at[0] == 'F' && r.at[1] == ':';
}

bool ap_hid_parse_line(const char *line, size_t len, struct ap_hid_line *out,
                       struct ap_bad_line *bad) {
    out->kind = AP_HID_LINE_NOTHING;
    out->byte_count = 0;
    if (ap_hid_line_is_feature(line, len)) {
        struct rest r = comment_of(line, len);
        r.at += 2;
        out->kind = AP_HID_LINE_FEATURE;
        return parse_bytes(&r, out, bad);
    }
    if (ap_log_line_is_empty(line, len))
        return true;
    struct rest r = {line, line, line + len};
    struct ap_field key = next_word(&r);
    if (key.len < 2 || key.text[1] != ':')
        return ap_bad_line_at(bad, line, key.text, "a letter and a colon, as in E:");
    r.at = key.text + 2;
    switch (key.text[0]) {
    case 'D':
        out->kind = AP_HID_LINE_DEVICE;
        return parse_device(&r, out, bad);
    case 'R':
        out->kind = AP_HID_LINE_DESCRIPTOR;
        return parse_bytes(&r, out, bad);
    case 'I':
        out->kind = AP_HID_LINE_IDS;
        return parse_ids(&r, out, bad);
    case 'E':
        out->kind = AP_HID_LINE_REPORT;
        return parse_report(&r, out, bad);
    case 'N':
        out->kind = AP_HID_LINE_NAME;
        parse_name(&r, out);
        return true;
    default:
        return true;
    }
}
