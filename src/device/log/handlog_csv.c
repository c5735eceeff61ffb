#include <inttypes.h>
#include <string.h>

#include "src/base/number.h"
#include "src/device/log/handlog_format.h"
#include "src/device/log/line_reader.h"
#include "src/device/log/poselog_fields.h"

// Our own CSV: t_ns,hand,joint,px,py,pz,qx,qy,qz,qw,radius. A frame of a hand is its rows of one
// time, one after the other or mixed with the other hand's; the palm may be left out.

static const char header[] = "t_ns,hand,joint,px,py,pz,qx,qy,qz,qw,radius";
enum { FIELDS = 11 };

struct row {
    int64_t t_ns;
    int hand, joint;
    struct ap_hand_joint value;
};

// A hand's frame that is being put together.
struct pending {
    int64_t t_ns;
    uint32_t joints; // a bit for each that is there
    struct ap_hand hand;
};

struct reading {
    struct ap_line_reader *lines;
    struct ap_handlog *log;
    struct pending pending[AP_HAND_COUNT];
    bool has_header;
};

static bool is_word(struct ap_field f, const char *word) {
    return f.len == strlen(word) && memcmp(f.text, word, f.len) == 0;
}

static bool parse_joint(const char *line, struct ap_field f, int *joint, struct ap_bad_line *bad) {
    for (int j = 0; j < AP_JOINT_COUNT; j++)
        if (is_word(f, ap_joint_name(j))) {
            *joint = j;
            return true;
        }
    return ap_bad_line_at(bad, line, f.text, "a joint: palm, wrist, thumb_metacarpal … little_tip");
}

static bool parse_row(const char *line, size_t len, struct row *row, struct ap_bad_line *bad) {
    static const char *const names[FIELDS] = {"t_ns", "hand", "joint", "px", "py",    "pz",
                                              "qx",   "qy",   "qz",    "qw", "radius"};
    struct ap_field f[FIELDS];
    size_t n = ap_split_commas(line, len, f, FIELDS);
    if (n != FIELDS)
        return ap_bad_line_at(bad, line, line + len, "%d fields, not %zu", FIELDS, n);
    bool read = ap_parse_int64(f[0].text, f[0].len, &row->t_ns);
    if (!ap_field_time(line, f[0].text, read, row->t_ns, "whole nanoseconds", bad))
        return false;
    if (!is_word(f[1], "left") && !is_word(f[1], "right"))
        return ap_bad_line_at(bad, line, f[1].text, "left or right");
    row->hand = is_word(f[1], "left") ? AP_HAND_LEFT : AP_HAND_RIGHT;
    if (!parse_joint(line, f[2], &row->joint, bad))
        return false;
    double v[FIELDS];
    for (int i = 3; i < FIELDS; i++)
        if (!ap_field_number(line, f[i], names[i], &v[i], bad))
            return false;
    row->value.pose.p = (struct ap_vec3){v[3], v[4], v[5]};
    row->value.pose.q = (struct ap_quat){v[6], v[7], v[8], v[9]};
    row->value.radius_m = v[10];
    if (!(v[10] >= 0 && v[10] <= 1))
        return ap_bad_line_at(bad, line, f[10].text, "a radius from 0 to 1 m");
    return ap_field_quat(line, f[6].text, &row->value.pose.q, bad);
}

static enum ap_status reject(struct ap_error *err, const struct reading *r,
                             const struct ap_bad_line *bad) {
    return ap_fail(err, AP_INPUT, "%s:%" PRId64 ":%zu: expected %s", r->lines->name, r->lines->line,
                   bad->column, bad->expected);
}

// Hands the frame over, which ends at the line being read.
static enum ap_status flush(struct ap_error *err, struct reading *r, int hand) {
    struct pending *p = &r->pending[hand];
    if (!p->joints)
        return AP_OK;
    if (!(p->joints & 1 << AP_JOINT_PALM))
        ap_hand_derive_palm(&p->hand);
    for (int j = AP_JOINT_WRIST; j < AP_JOINT_COUNT; j++)
        if (!(p->joints & 1u << j))
            return ap_fail(err, AP_INPUT,
                           "%s:%" PRId64 ": expected all joints of the %s hand at %" PRId64
                           " ns before; there is no %s",
                           r->lines->name, r->lines->line, hand == AP_HAND_LEFT ? "left" : "right",
                           p->t_ns, ap_joint_name(j));
    p->joints = 0;
    struct ap_error why;
    enum ap_status st = ap_handlog_add(&why, r->log, hand, p->t_ns, &p->hand);
    return st ? ap_fail(err, st, "%s:%" PRId64 ": %s", r->lines->name, r->lines->line, why.text)
              : st;
}

static enum ap_status take_row(struct ap_error *err, struct reading *r, const char *line,
                               size_t len) {
    struct row row;
    struct ap_bad_line bad;
    if (!parse_row(line, len, &row, &bad))
        return reject(err, r, &bad);
    struct pending *p = &r->pending[row.hand];
    if (p->joints && p->t_ns != row.t_ns) {
        enum ap_status st = flush(err, r, row.hand);
        if (st)
            return st;
    }
    if (p->joints & 1u << row.joint) {
        ap_bad_line_at(&bad, line, line, "each joint once at a time, not %s again",
                       ap_joint_name(row.joint));
        return reject(err, r, &bad);
    }
    p->t_ns = row.t_ns;
    p->joints |= 1u << row.joint;
    p->hand.joint[row.joint] = row.value;
    return AP_OK;
}

static enum ap_status take_line(struct ap_error *err, struct reading *r, enum ap_line_kind kind,
                                const char *line, size_t len) {
    if (kind == AP_LINE_TOO_LONG)
        return ap_fail(err, AP_INPUT, "%s:%" PRId64 ": line of more than %d bytes", r->lines->name,
                       r->lines->line, AP_LINE_MAX);
    if (ap_log_line_is_empty(line, len))
        return AP_OK;
    if (r->has_header)
        return take_row(err, r, line, len);
    r->has_header = true;
    if (len == sizeof header - 1 && memcmp(line, header, len) == 0)
        return AP_OK;
    struct ap_bad_line bad;
    ap_bad_line_at(&bad, line, line, "the header %s", header);
    return reject(err, r, &bad);
}

enum ap_status ap_handlog_read_csv(struct ap_error *err, struct ap_line_reader *reader,
                                   struct ap_handlog *log) {
    struct reading r = {.log = log, .lines = reader};
    enum ap_status st = AP_OK;
    while (!st) {
        enum ap_line_kind kind;
        const char *line;
        size_t len;
        st = ap_line_reader_next(err, r.lines, &kind, &line, &len);
        if (st || kind == AP_LINE_END)
            break;
        st = take_line(err, &r, kind, line, len);
    }
    for (int hand = 0; !st && hand < AP_HAND_COUNT; hand++)
        st = flush(err, &r, hand);
    return st;
}
