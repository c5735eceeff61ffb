#include "tests/vm/reading.h"

#include <stdlib.h>
#include <string.h>

void reading_open(struct reading *r, const char *recording, int64_t wanted) {
    player_load(&r->player, recording);
    r->wanted = wanted;
    r->next = -1;
    r->index = calloc((size_t)wanted, sizeof *r->index);
    r->t_ns = calloc((size_t)wanted, sizeof *r->t_ns);
    if (!r->index || !r->t_ns)
        player_die("no memory for %lld reports", (long long)wanted);
}

// The recording is played again and again: index k is its report k modulo their number.
static int64_t find(const struct reading *r, const uint8_t *bytes, size_t len) {
    const struct player_device *d = &r->player.devices[0];
    int64_t n = (int64_t)d->report_count, from = r->next < 0 ? 0 : r->next;
    for (int64_t k = from; k < from + n; k++) {
        const struct player_report *p = &d->reports[k % n];
        if (p->len == len && memcmp(p->bytes, bytes, len) == 0)
            return k;
    }
    return -1;
}

void reading_add(struct reading *r, const uint8_t *bytes, size_t len) {
    int64_t now = player_now_ns(), k = find(r, bytes, len);
    if (k < 0) {
        r->strange++;
        return;
    }
    if (r->next >= 0)
        r->lost += k - r->next;
    r->next = k + 1;
    if (r->count < r->wanted) {
        r->index[r->count] = k;
        r->t_ns[r->count++] = now;
    }
}

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void tell_latency(const struct reading *r) {
    FILE *file = r->sent_log ? fopen(r->sent_log, "r") : NULL;
    double *us = calloc((size_t)r->count + 1, sizeof *us);
    long long index, t_ns;
    int64_t at = 0, n = 0;
    char end; // a line that is not yet written to its end is none
    while (file && us && at < r->count && fscanf(file, "%lld %lld%c", &index, &t_ns, &end) == 3 &&
           end == '\n')
        if (index == r->index[at])
            us[n++] = (double)(r->t_ns[at++] - t_ns) / 1e3;
    if (n > 0) {
        qsort(us, (size_t)n, sizeof *us, compare);
        printf(" latency median %.0f p99 %.0f max %.0f us", us[n / 2], us[n * 99 / 100], us[n - 1]);
    }
    free(us);
    if (file)
        fclose(file);
}

void reading_tell(const struct reading *r) {
    printf("read %lld lost %lld strange %lld first %lld", (long long)r->count, (long long)r->lost,
           (long long)r->strange, r->count ? (long long)r->index[0] : -1LL);
    tell_latency(r);
    putchar('\n');
}
