#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "src/device/drivers/bytes.h"
#include "src/device/log/poselog_document.h"
#include "src/device/unit_quat.h"

// Replays of Beat Saber as BeatLeader keeps them (BSOR, version 1), little-endian: magic, version;
// a section 0 with what was played; a section 1 with a number of frames and 92 bytes for each: time
// in seconds, frames a second, and of head, left and right three numbers of a place and four of a
// quaternion (x, y, z, w), all of 32 bits. What follows is not looked at. Axes are left-handed, z
// forward.

enum { HEAD = 5, FRAME = 92, POSE = 28, STRINGS_FIRST = 13, STRINGS_THEN = 3, TRIED = 4 };

struct reader {
    const unsigned char *bytes;
    size_t len, at;
    bool ok;
};

static const unsigned char *take(struct reader *r, size_t n) {
    const unsigned char *at = r->bytes + r->at;
    r->ok = r->ok && n <= r->len - r->at;
    r->at += r->ok ? n : 0;
    return r->ok ? at : NULL;
}

static void pass_strings(struct reader *r, int count) {
    for (int i = 0; i < count && r->ok; i++) {
        const unsigned char *size = take(r, 4);
        if (size)
            take(r, ap_u32le(size));
    }
}

static double f32le(const unsigned char *b) {
    uint32_t bits = ap_u32le(b);
    float value;
    memcpy(&value, &bits, sizeof value);
    return (double)value;
}

// As a pose in our axes. *there = false for a device that was not tracked (zeros).
static bool read_pose(const unsigned char *b, struct ap_pose *pose, bool *there) {
    double v[7], size = 0;
    for (int i = 0; i < 7; i++) {
        v[i] = f32le(b + 4 * i);
        if (!(fabs(v[i]) <= 1e6))
            return false;
        size += i < 3 ? 0 : fabs(v[i]);
    }
    *there = size > 0;
    *pose = (struct ap_pose){{v[0], v[1], -v[2]}, {-v[3], -v[4], v[5], v[6]}};
    return !*there || ap_quat_make_unit(&pose->q);
}

// Whether a section of frames could begin here: the numbers are some that frames have.
static bool looks_like_frames(const unsigned char *bytes, size_t len, size_t at) {
    if (len - at < 5 || bytes[at] != 1)
        return false;
    uint64_t count = ap_u32le(bytes + at + 1);
    size_t frames = (len - at - 5) / FRAME;
    if (count == 0 || frames == 0 || count > INT32_MAX)
        return false;
    for (size_t i = 0; i < TRIED && i < frames && i < count; i++) {
        const unsigned char *b = bytes + at + 5 + i * FRAME;
        double t_s = f32le(b);
        if (!(t_s >= 0 && t_s < 1e6) || ap_u32le(b + 4) > 10000)
            return false;
        for (int k = 0; k < 3; k++) {
            struct ap_pose pose;
            bool there;
            if (!read_pose(b + 8 + k * POSE, &pose, &there))
                return false;
        }
    }
    return true;
}

// Behind the first section; names in it may be longer than they say (a known fault of one version
// of the game's plugin), then the first place that looks like frames is it.
static bool find_frames(const unsigned char *bytes, size_t len, size_t *at) {
    struct reader r = {.bytes = bytes, .len = len, .at = HEAD, .ok = true};
    const unsigned char *section = take(&r, 1);
    if (!section || *section != 0)
        return false;
    pass_strings(&r, STRINGS_FIRST);
    take(&r, 4); // score
    pass_strings(&r, STRINGS_THEN);
    take(&r, 4 + 1 + 4 * 4); // distance, which hand, height, start, fail, speed
    if (r.ok && looks_like_frames(bytes, len, r.at)) {
        *at = r.at;
        return true;
    }
    for (size_t i = HEAD + 1; i < len; i++)
        if (looks_like_frames(bytes, len, i)) {
            *at = i;
            return true;
        }
    return false;
}

static enum ap_status take_frame(struct ap_error *err, struct ap_document *d,
                                 const unsigned char *b, int64_t frame, int64_t *last_t_ns) {
    static const char *const names[3] = {"head", "left", "right"};
    struct ap_error why;
    double t_s = f32le(b);
    int64_t t_ns = t_s >= 0 && t_s < 1e6 ? llround(t_s * 1e9) : -1;
    if (t_ns < 0 || t_ns < *last_t_ns) {
        ap_fail(&why, AP_INPUT,
                "%s: frame %" PRId64 ": expected a time in seconds not before the frame before",
                d->file, frame);
        return ap_document_reject(err, d, &why);
    }
    if (t_ns == *last_t_ns) // recorders repeat the first one
        return AP_OK;
    struct ap_pose poses[3];
    bool there[3];
    for (int k = 0; k < 3; k++)
        if (!read_pose(b + 8 + k * POSE, &poses[k], &there[k])) {
            ap_fail(&why, AP_INPUT, "%s: frame %" PRId64 ": expected a unit quaternion of %s",
                    d->file, frame, names[k]);
            return ap_document_reject(err, d, &why);
        }
    *last_t_ns = t_ns;
    enum ap_status st = AP_OK;
    for (int k = 0; k < 3 && !st; k++)
        if (there[k])
            st = ap_document_add(
                err, d, names[k],
                (struct ap_table_row){.t_ns = t_ns, .frame = frame, .pose = poses[k]});
    return st;
}

enum ap_status ap_bsor_read(struct ap_error *err, struct ap_document *d, const char *text,
                            size_t len) {
    const unsigned char *bytes = (const unsigned char *)text;
    size_t at;
    if (len < HEAD || bytes[4] != 1)
        return ap_fail(err, AP_INPUT, "%s: expected version 1 of BSOR", d->file);
    if (!find_frames(bytes, len, &at))
        return ap_fail(err, AP_INPUT, "%s: expected frames in this BSOR replay", d->file);
    uint64_t count = ap_u32le(bytes + at + 1), whole = (len - at - 5) / FRAME;
    if (count > whole) {
        struct ap_error why;
        ap_fail(&why, AP_INPUT,
                "%s: expected %" PRIu64 " frames as it says; it ends after %" PRIu64, d->file,
                count, whole);
        enum ap_status st = ap_document_reject(err, d, &why);
        if (st)
            return st;
        count = whole;
    }
    enum ap_status st = AP_OK;
    int64_t last_t_ns = -1;
    for (uint64_t i = 0; i < count && !st; i++)
        st = take_frame(err, d, bytes + at + 5 + i * FRAME, (int64_t)i, &last_t_ns);
    return st;
}
