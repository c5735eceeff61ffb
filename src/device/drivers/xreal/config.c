#include "src/device/drivers/xreal/config.h"

#include <math.h>
#include <string.h>

#include "src/base/number.h"

enum { RATES = 1, FORCES = 2, BOTH = 1 << RATES | 1 << FORCES };

static const char *const path[] = {"IMU", "device_1"};
enum { PATH = sizeof path / sizeof *path, IN_VECTOR = PATH + 2 };

static bool is_text(const struct ap_xreal_config *c, const char *word) {
    return c->length == strlen(word) && memcmp(c->text, word, c->length) == 0;
}

static void add(struct ap_xreal_config *c, char byte) {
    if (c->length < sizeof c->text)
        c->text[c->length] = byte;
    c->length += c->length <= sizeof c->text;
}

static void read_string(struct ap_xreal_config *c, char byte) {
    if (!c->is_escaped && byte == '"')
        c->in_string = false;
    else
        add(c, byte);
    c->is_escaped = !c->is_escaped && byte == '\\';
}

// The colon behind a key.
static void take_key(struct ap_xreal_config *c) {
    bool is_here = c->depth == c->matched + 1;
    c->is_next = is_here && c->matched < PATH && is_text(c, path[c->matched]);
    c->vector = 0;
    if (is_here && c->matched == PATH)
        c->vector = is_text(c, "gyro_bias") ? RATES : is_text(c, "accel_bias") ? FORCES : 0;
    c->index = c->length = 0;
}

// A comma or a bracket behind a number of a vector.
static void take_number(struct ap_xreal_config *c) {
    double value;
    bool is_ours = c->vector && c->depth == IN_VECTOR && c->length > 0;
    if (is_ours && c->index < 3 && c->length <= sizeof c->text &&
        ap_parse_double(c->text, c->length, &value))
        c->value[c->vector][c->index++] = value;
    else if (is_ours)
        c->vector = 0;
    c->length = 0;
}

static void close(struct ap_xreal_config *c, char byte) {
    take_number(c);
    if (byte == ']' && c->vector && c->depth == IN_VECTOR && c->index == 3)
        c->found |= 1u << c->vector;
    if (c->depth == c->matched + 1 && c->matched > 0)
        c->matched--;
    if (c->depth > 0)
        c->depth--;
    c->vector = 0;
}

static void read_byte(struct ap_xreal_config *c, char byte) {
    if (c->in_string) {
        read_string(c, byte);
    } else if (byte == '"') {
        c->in_string = true;
        c->length = 0;
    } else if (byte == ':') {
        take_key(c);
    } else if (byte == '{' || byte == '[') {
        c->depth++;
        c->matched += c->is_next && byte == '{';
        c->is_next = false;
        c->length = 0;
    } else if (byte == '}' || byte == ']') {
        close(c, byte);
    } else if (byte == ',') {
        take_number(c);
        if (c->depth != IN_VECTOR)
            c->vector = 0;
        c->is_next = false;
    } else if (byte > ' ') {
        add(c, byte);
    }
}

void ap_xreal_config_read(struct ap_xreal_config *config, const char *text, size_t len) {
    for (size_t i = 0; i < len; i++)
        read_byte(config, text[i]);
}

static bool is_small(const double v[3], double most) {
    return fabs(v[0]) <= most && fabs(v[1]) <= most && fabs(v[2]) <= most;
}

// Theirs: y down and z ahead.
static struct ap_vec3 turned(const double v[3]) {
    return (struct ap_vec3){v[0], -v[1], -v[2]};
}

bool ap_xreal_config_bias(const struct ap_xreal_config *c, struct ap_imu_bias *bias) {
    static const double MOST_RAD_S = 0.2, MOST_M_S2 = 2; // more is no bias
    if ((c->found & BOTH) != BOTH || !is_small(c->value[RATES], MOST_RAD_S) ||
        !is_small(c->value[FORCES], MOST_M_S2))
        return false;
    *bias = (struct ap_imu_bias){.gyr_rad_s = turned(c->value[RATES]),
                                 .acc_m_s2 = turned(c->value[FORCES])};
    return true;
}
