#include "src/base/utf8.h"

#include <stdbool.h>

int ap_utf8_length(const char *text) {
    const unsigned char *t = (const unsigned char *)text;
    if (t[0] < 0x80)
        return 1;
    int n = t[0] >= 0xf0 ? 4 : t[0] >= 0xe0 ? 3 : 2;
    if (t[0] < 0xc2 || t[0] > 0xf4)
        return 0;
    for (int i = 1; i < n; i++)
        if ((t[i] & 0xc0) != 0x80)
            return 0;
    bool overlong = (t[0] == 0xe0 && t[1] < 0xa0) || (t[0] == 0xf0 && t[1] < 0x90);
    bool outside = (t[0] == 0xed && t[1] >= 0xa0) || (t[0] == 0xf4 && t[1] >= 0x90);
    return overlong || outside ? 0 : n;
}

void ap_utf8_tidy(char *text) {
    char *to = text;
    while (*text) {
        const unsigned char *t = (const unsigned char *)text;
        int n = ap_utf8_length(text);
        if (n == 0 || t[0] < 0x20 || t[0] == 0x7f || (t[0] == 0xc2 && t[1] < 0xa0)) {
            *to++ = '?';
            text += n ? n : 1;
            continue;
        }
        while (n--)
            *to++ = *text++;
    }
    *to = '\0';
}
