#include "src/base/number.h"

#include <errno.h>
#include <locale.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// strtod and printf follow the host program's locale, and the runtime lives in other people's
// processes; a locale object of our own does not touch theirs.
static locale_t c_locale;
static pthread_once_t once = PTHREAD_ONCE_INIT;

static void make_locale(void) {
    c_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
}

static locale_t enter_c_locale(void) {
    pthread_once(&once, make_locale);
    return c_locale ? uselocale(c_locale) : (locale_t)0;
}

static void leave_c_locale(locale_t old) {
    if (old)
        uselocale(old);
}

static size_t digits(const char *text, size_t len, size_t i) {
    size_t n = 0;
    while (i + n < len && text[i + n] >= '0' && text[i + n] <= '9')
        n++;
    return n;
}

static bool is_decimal(const char *text, size_t len) {
    size_t i = 0;
    if (i < len && (text[i] == '+' || text[i] == '-'))
        i++;
    size_t whole = digits(text, len, i), part = 0;
    i += whole;
    if (i < len && text[i] == '.') {
        part = digits(text, len, ++i);
        i += part;
    }
    if (whole + part == 0)
        return false;
    if (i < len && (text[i] == 'e' || text[i] == 'E')) {
        i++;
        if (i < len && (text[i] == '+' || text[i] == '-'))
            i++;
        size_t n = digits(text, len, i);
        if (n == 0)
            return false;
        i += n;
    }
    return i == len;
}

bool ap_parse_double(const char *text, size_t len, double *value) {
    if (!is_decimal(text, len))
        return false;
    char small[64];
    char *copy = len < sizeof small ? small : malloc(len + 1);
    if (!copy)
        return false;
    memcpy(copy, text, len);
    copy[len] = '\0';
    locale_t old = enter_c_locale();
    double v = strtod(copy, NULL);
    leave_c_locale(old);
    if (copy != small)
        free(copy);
    if (!isfinite(v))
        return false;
    *value = v;
    return true;
}

bool ap_parse_int64(const char *text, size_t len, int64_t *value) {
    size_t i = 0;
    bool negative = false;
    if (i < len && (text[i] == '+' || text[i] == '-'))
        negative = text[i++] == '-';
    if (i == len || digits(text, len, i) != len - i)
        return false;
    int64_t v = 0;
    for (; i < len; i++) {
        int d = text[i] - '0';
        if (__builtin_mul_overflow(v, 10, &v) || __builtin_sub_overflow(v, d, &v))
            return false;
    }
    // The sum runs on the negative side, which holds one more number than the positive.
    if (!negative && __builtin_sub_overflow((int64_t)0, v, &v))
        return false;
    *value = v;
    return true;
}

size_t ap_format_double(char text[AP_DOUBLE_TEXT_MAX], double value) {
    locale_t old = enter_c_locale();
    int n = snprintf(text, AP_DOUBLE_TEXT_MAX, "%.17g", value);
    leave_c_locale(old);
    return (size_t)n;
}
