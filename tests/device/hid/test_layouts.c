#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "src/device/drivers/spacemouse/spacemouse.h"
#include "src/device/hid/driver.h"

// Devices that nobody has built: descriptors whose report ids, order, widths, ranges, exponents and
// padding are drawn, and reports written by those descriptors with a packer of the test's own. The
// drivers that go by the descriptor must read what was written, to the width's last bit.

enum { DEVICES = 1500 };
static const double PI = 3.14159265358979323846;

static uint64_t seed;

static uint32_t draw(uint32_t below) {
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(seed >> 33) % below;
}

static double draw_unit(void) {
    return draw(1u << 30) / (double)(1u << 29) - 1;
}

// --- a descriptor and a report of it

static struct {
    uint8_t bytes[1024];
    size_t len;
    uint32_t at; // the next field's bit in the report
    uint8_t report[128];
    int id;
} made;

// An item with as many bytes as its number needs; a signed one sometimes with more (a usage of four
// bytes would have its page in it).
static void item(unsigned prefix, int64_t value, bool is_signed) {
    unsigned size = 0;
    int64_t low = is_signed ? -128 : 0, high = is_signed ? 127 : 255;
    for (size = 1; size < 4 && (value < low || value > high); size *= 2) {
        low = is_signed ? (size == 1 ? INT16_MIN : INT32_MIN) : 0;
        high =
            size == 1 ? (is_signed ? INT16_MAX : UINT16_MAX) : (is_signed ? INT32_MAX : UINT32_MAX);
    }
    if (is_signed && size < 4 && draw(4) == 0)
        size *= 2;
    made.bytes[made.len++] = (uint8_t)(prefix | (size == 4 ? 3 : size));
    for (unsigned i = 0; i < size; i++)
        made.bytes[made.len++] = (uint8_t)((uint64_t)value >> 8 * i);
}

static void byte_item(unsigned prefix, unsigned value) {
    made.bytes[made.len++] = (uint8_t)(prefix | 1);
    made.bytes[made.len++] = (uint8_t)value;
}

static void begin(unsigned page, unsigned usage) {
    memset(&made, 0, sizeof made);
    byte_item(0x04, page);
    byte_item(0x08, usage);
    byte_item(0xa0, 1);
    if (draw(4) > 0) {
        made.id = 1 + (int)draw(255);
        byte_item(0x84, (unsigned)made.id);
        made.report[0] = (uint8_t)made.id;
        made.at = 8;
    }
}

static void end(void) {
    made.bytes[made.len++] = 0xc0;
}

// Bits that mean nothing, with something in them.
static void pad(uint32_t bits) {
    byte_item(0x74, 1);
    byte_item(0x94, bits);
    byte_item(0x80, 3);
    for (uint32_t i = 0; i < bits; i++, made.at++)
        made.report[made.at / 8] |= (uint8_t)(draw(2) << made.at % 8);
}

struct range {
    unsigned bits;
    int64_t lmin, lmax, pmin, pmax;
    int exponent;
};

static void limits(const struct range *r) {
    item(0x14, r->lmin, true);
    item(0x24, r->lmax, r->lmin < 0);
    item(0x34, r->pmin, true);
    item(0x44, r->pmax, r->pmin < 0);
    // As a nibble or as a signed byte.
    byte_item(0x54, r->exponent < 0 && r->exponent >= -8 && draw(2)
                        ? (unsigned)(r->exponent & 15)
                        : (unsigned)(r->exponent & 255));
    byte_item(0x74, r->bits);
}

static void field(unsigned page, unsigned usage, const struct range *r, const int64_t *raw,
                  int count) {
    if (draw(3) == 0)
        pad(1 + draw(9));
    limits(r);
    if (draw(3) == 0)
        item(0x08, (int64_t)page << 16 | usage, false); // its page with it
    else {
        byte_item(0x04, page);
        item(0x08, usage, false);
    }
    byte_item(0x94, (unsigned)count);
    byte_item(0x80, 2);
    for (int k = 0; k < count; k++)
        for (unsigned i = 0; i < r->bits; i++, made.at++)
            made.report[made.at / 8] |= (uint8_t)(((uint64_t)raw[k] >> i & 1) << made.at % 8);
}

static struct ap_device_info info;
static struct ap_driver_samples samples;
static union {
    max_align_t align;
    unsigned char bytes[AP_DRIVER_STATE_MAX];
} state;

static const struct ap_driver_sample *read_made(const char *name, int device) {
    struct ap_error err;
    memset(&info, 0, sizeof info);
    memset(&state, 0, sizeof state);
    samples.count = 0;
    if (ap_hid_parse_descriptor(&err, made.bytes, made.len, &info.descriptor))
        fail_msg("device %d: %s", device, err.text);
    const struct ap_driver *driver = ap_driver_find(&info);
    if (!driver || strcmp(driver->name, name) != 0)
        fail_msg("device %d: the driver is %s, expected %s", device, driver ? driver->name : "none",
                 name);
    if (driver->init)
        driver->init(&state, &info);
    enum ap_report_verdict verdict =
        driver->parse(&state, &info, 0, made.report, (made.at + 7) / 8, &samples);
    if (verdict != AP_REPORT_OK || samples.count != 1)
        fail_msg("device %d: verdict %d (%s), %d samples", device, verdict, samples.why,
                 samples.count);
    return &samples.at[0];
}

static double angle_between(struct ap_quat a, struct ap_quat b) {
    struct ap_quat d = ap_quat_mul(ap_quat_conj(a), b);
    return 2 * atan2(sqrt(d.x * d.x + d.y * d.y + d.z * d.z), fabs(d.w));
}

// Symmetric or with one more below, in so many bits.
static struct range full_range(unsigned bits) {
    struct range r = {.bits = bits, .lmax = (INT64_C(1) << (bits - 1)) - 1};
    r.lmin = draw(2) ? -r.lmax : -r.lmax - 1;
    return r;
}

static int64_t raw_of(const struct range *r, double physical) {
    double scale = pow(10, -r->exponent), t = (physical * scale - (double)r->pmin);
    return llround((double)r->lmin + t / (double)(r->pmax - r->pmin) * (double)(r->lmax - r->lmin));
}

// --- the devices

static void test_head_trackers(void **unused) {
    (void)unused;
    double worst = 0;
    seed = 1;
    for (int n = 0; n < DEVICES; n++) {
        struct range turn = full_range(10 + draw(23)), rate = full_range(8 + draw(25)),
                     counter = {.bits = 4 + draw(29)};
        turn.exponent = -(int)(2 + draw(7));
        turn.pmax = (int64_t)ceil(PI * pow(10, -turn.exponent));
        turn.pmin = -turn.pmax;
        rate.pmax = 32, rate.pmin = -32;
        counter.lmax = (INT64_C(1) << counter.bits) - 1;
        double angle = PI * 0.999 * fabs(draw_unit()), a = PI * draw_unit(), b = draw_unit();
        double v[3] = {angle * cos(a) * sqrt(1 - b * b), angle * sin(a) * sqrt(1 - b * b),
                       angle * b};
        int64_t raw[3], rates[3], count = draw(16);
        for (int k = 0; k < 3; k++) {
            raw[k] = raw_of(&turn, v[k]);
            rates[k] = raw_of(&rate, v[k]);
        }
        begin(0x20, 0xe1);
        for (unsigned order = draw(6), k = 0; k < 3; k++) {
            static const char orders[6][4] = {"vrc", "vcr", "rvc", "rcv", "cvr", "crv"};
            char what = orders[order][k];
            if (what == 'v')
                field(0x20, 0x544, &turn, raw, 3);
            else if (what == 'r')
                field(0x20, 0x545, &rate, rates, 3);
            else
                field(0x20, 0x546, &counter, &count, 1);
        }
        end();
        const struct ap_driver_sample *s = read_made("android-head-tracker", n);
        // x right, y ahead, z up.
        struct ap_vec3 axis = {v[0] / angle, v[2] / angle, -v[1] / angle};
        double off = angle_between(s->pose.q, ap_quat_from_axis_angle(axis, angle));
        double step = 2 * PI / (double)(turn.lmax - turn.lmin);
        if (!(off <= step + 1e-7) || s->reset_count != (uint32_t)count)
            fail_msg("device %d (%u bits): %.9f rad off, allowed %.9f; counter %u, written %u", n,
                     turn.bits, off, step, s->reset_count, (unsigned)count);
        worst = fmax(worst, off / (step + 1e-7));
        bool is_zero = !rates[0] && !rates[1] && !rates[2]; // then none is known
        struct ap_vec3 w = {v[0], v[2], -v[1]};
        double far = ap_vec3_length(ap_vec3_sub(w, s->angular_velocity_rad_s));
        double most = 64 / (double)(rate.lmax - rate.lmin) + 1e-9;
        if (s->has_rate == is_zero || (!is_zero && !(far <= most)))
            fail_msg("device %d (%u bits): rate %.9f rad/s off, allowed %.9f", n, rate.bits, far,
                     most);
    }
    print_message("%d head trackers, at worst %.2f of the widths' last bits off\n", DEVICES, worst);
}

static void test_orientations(void **unused) {
    (void)unused;
    seed = 2;
    for (int n = 0; n < DEVICES; n++) {
        struct range r = full_range(8 + draw(25));
        r.exponent = -(int)draw(10);
        double h = PI / 2 * draw_unit(), a = PI * draw_unit(), b = draw_unit(), c = sqrt(1 - b * b);
        double q[4] = {sin(h) * cos(a) * c, sin(h) * sin(a) * c, sin(h) * b, cos(h)};
        int64_t raw[4], acc[3] = {1, 2, 3};
        for (int k = 0; k < 4; k++)
            raw[k] = llround(q[k] * (double)r.lmax);
        begin(0x20, draw(2) ? 0x8e : 0x8a);
        if (draw(2))
            field(0x20, 0x453, &r, acc, 3);
        field(0x20, 0x483, &r, raw, 4);
        end();
        const struct ap_driver_sample *s = read_made("hid-orientation", n);
        double off = angle_between(s->pose.q, (struct ap_quat){q[0], q[2], -q[1], q[3]});
        double step = 2 / (double)r.lmax;
        if (!(off <= 1.1 * step + 1e-7))
            fail_msg("device %d (%u bits): %.9f rad off, allowed %.9f", n, r.bits, off, 1.1 * step);
    }
}

static void test_caps(void **unused) {
    (void)unused;
    seed = 3;
    for (int n = 0; n < DEVICES; n++) {
        double pushed[6];
        struct ap_spacemouse_layout layout;
        struct ap_spacemouse_report report;
        struct range ranges[6];
        begin(1, 8);
        for (unsigned k = 0, first = draw(6), step = draw(2) ? 1 : 5; k < 6; k++) {
            unsigned axis = (first + k * step) % 6;
            struct range *r = &ranges[axis];
            *r = full_range(8 + draw(9));
            if (draw(2)) // less than the width
                r->lmax = 50 + draw(70), r->lmin = -r->lmax;
            if (draw(3) == 0) // or counted from 0
                *r = (struct range){.bits = 8, .lmin = 0, .lmax = 255};
            pushed[axis] = draw_unit();
            double middle = r->lmin < 0 ? 0 : 127.5,
                   half = r->lmin < 0 ? fmax((double)r->lmax, -(double)r->lmin) : 127.5;
            int64_t raw = llround(middle + half * pushed[axis]);
            raw = raw > r->lmax ? r->lmax : raw;
            pushed[axis] = ((double)raw - middle) / half;
            field(1, 0x30 + axis, r, &raw, 1);
        }
        end();
        read_made("spacemouse", n);
        assert_true(ap_spacemouse_find(&info.descriptor, &layout));
        assert_int_equal(
            ap_spacemouse_parse(&info.descriptor, &layout, made.report, (made.at + 7) / 8, &report),
            AP_REPORT_OK);
        for (int k = 0; k < 6; k++)
            if (!report.has_axis[k] || fabs(report.axis[k] - pushed[k]) > 1e-12)
                fail_msg("device %d, axis %d (%u bits, %lld to %lld): %.9f, written %.9f", n, k,
                         ranges[k].bits, (long long)ranges[k].lmin, (long long)ranges[k].lmax,
                         report.axis[k], pushed[k]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_head_trackers),
        cmocka_unit_test(test_orientations),
        cmocka_unit_test(test_caps),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
