#include "tests/vm/player.h"

#include <errno.h>
#include <getopt.h>
#include <poll.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "src/device/hid/recording.h"

volatile sig_atomic_t player_stop;

static const char *program_name = "player";

static void on_signal(int number) {
    (void)number;
    player_stop = 1;
}

void player_die(const char *format, ...) {
    va_list args;
    va_start(args, format);
    fprintf(stderr, "%s: ", program_name);
    vfprintf(stderr, format, args);
    fputc('\n', stderr);
    va_end(args);
    exit(1);
}

int64_t player_now_ns(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

static void add_report(struct player_device *d, const struct ap_hid_line *line) {
    if (line->byte_count == 0 || line->byte_count > PLAYER_REPORT_MAX)
        player_die("a report of %zu bytes; 1 to %d can be played", line->byte_count,
                   PLAYER_REPORT_MAX);
    if ((d->report_count & (d->report_count - 1)) == 0) { // full at each power of two
        size_t room = d->report_count ? 2 * d->report_count : 1;
        d->reports = realloc(d->reports, room * sizeof *d->reports);
    }
    uint8_t *bytes = malloc(line->byte_count);
    if (!d->reports || !bytes)
        player_die("no memory");
    memcpy(bytes, line->bytes, line->byte_count);
    d->reports[d->report_count++] =
        (struct player_report){.t_ns = line->t_ns, .len = line->byte_count, .bytes = bytes};
}

static void add_line(struct player *p, struct player_device *d, const struct ap_hid_line *line) {
    if (line->kind == AP_HID_LINE_DESCRIPTOR) {
        d->descriptor_len =
            line->byte_count < sizeof d->descriptor ? line->byte_count : sizeof d->descriptor;
        memcpy(d->descriptor, line->bytes, d->descriptor_len);
    } else if (line->kind == AP_HID_LINE_NAME) {
        snprintf(d->name, sizeof d->name, "%.*s", (int)line->text.len, line->text.text);
    } else if (line->kind == AP_HID_LINE_IDS) {
        d->bus = line->bus;
        d->vendor = line->vendor;
        d->product = line->product;
    } else if (line->kind == AP_HID_LINE_REPORT) {
        add_report(d, line);
    } else if (line->kind == AP_HID_LINE_FEATURE && line->byte_count > 0 &&
               line->byte_count <= sizeof p->features[0].bytes) {
        struct player_feature *f = &p->features[line->bytes[0]];
        f->len = line->byte_count;
        memcpy(f->bytes, line->bytes, line->byte_count);
    }
}

// Each device of the file becomes one of the player's.
void player_load(struct player *p, const char *path) {
    static struct ap_hid_line line;
    FILE *file = fopen(path, "r");
    char *text = NULL;
    size_t room = 0, number = 0;
    int first = p->device_count, at = first;
    if (!file)
        player_die("%s: %s", path, strerror(errno));
    for (ssize_t len; (len = getline(&text, &room, file)) > 0;) {
        struct ap_bad_line bad;
        number++;
        while (len > 0 && strchr("\r\n", text[len - 1]))
            len--;
        if (!ap_hid_parse_line(text, (size_t)len, &line, &bad))
            player_die("%s:%zu: expected %s", path, number, bad.expected);
        if (line.kind == AP_HID_LINE_NOTHING)
            continue;
        if (line.kind == AP_HID_LINE_DEVICE)
            at = first + (line.device < PLAYER_DEVICES_MAX ? (int)line.device : PLAYER_DEVICES_MAX);
        if (at >= PLAYER_DEVICES_MAX)
            player_die("%s:%zu: more than %d devices", path, number, PLAYER_DEVICES_MAX);
        if (at >= p->device_count)
            p->device_count = at + 1;
        add_line(p, &p->devices[at], &line);
    }
    free(text);
    fclose(file);
}

static double number_of(const char *text) {
    char *end;
    double v = strtod(text, &end);
    if (end == text || *end)
        player_die("'%s' is no number", text);
    return v;
}

static const struct option options[] = {
    {"rate", required_argument, NULL, 'r'},  {"count", required_argument, NULL, 'n'},
    {"wait", no_argument, NULL, 'w'},        {"serial", required_argument, NULL, 's'},
    {"maker", required_argument, NULL, 'm'}, {"hold", required_argument, NULL, 'h'},
    {"fail", required_argument, NULL, 'f'},  {"bare", no_argument, NULL, 'b'},
    {"late", required_argument, NULL, 'l'},  {"late-for", required_argument, NULL, 'L'},
    {"sent", required_argument, NULL, 'o'},  {"after", required_argument, NULL, 'a'},
    {"polite", no_argument, NULL, 'p'},      {NULL, 0, NULL, 0},
};

static void set_option(struct player *p, int letter, const char *value) {
    switch (letter) {
    case 'r':
        p->rate_hz = number_of(value);
        break;
    case 'n':
        p->count = (int64_t)number_of(value);
        break;
    case 'w':
        p->wait = true;
        break;
    case 's':
        p->serial = value;
        break;
    case 'm':
        p->maker = value;
        break;
    case 'a':
        p->after_ns = (int64_t)(1e9 * number_of(value));
        break;
    case 'h':
        p->hold_ns = (int64_t)(1e9 * number_of(value));
        break;
    case 'f':
        p->fail_after = (int64_t)number_of(value);
        break;
    case 'b':
        p->bare = true;
        break;
    case 'p':
        if (nice(10) < 0)
            player_die("cannot wait for others: %s", strerror(errno));
        break;
    case 'l':
        p->late_at = (int64_t)number_of(value);
        break;
    case 'L':
        p->late_ns = (int64_t)(1e9 * number_of(value));
        break;
    case 'o':
        p->sent_log = fopen(value, "w");
        if (!p->sent_log)
            player_die("%s: %s", value, strerror(errno));
        break;
    default:
        player_die("see player.c for the options");
    }
}

void player_open(struct player *p, const char *program, int argc, char **argv) {
    program_name = program;
    *p = (struct player){
        .serial = "", .maker = "Example", .count = -1, .fail_after = -1, .late_at = -1};
    for (int letter; (letter = getopt_long(argc, argv, "", options, NULL)) != -1;)
        set_option(p, letter, optarg);
    if (optind == argc)
        player_die("which recording?");
    for (int i = optind; i < argc; i++)
        player_load(p, argv[i]);
    for (int i = 0; i < p->device_count; i++)
        if (p->devices[i].descriptor_len == 0)
            player_die("device %d has no report descriptor", i);
    setvbuf(stdout, NULL, _IOLBF, 0);
    struct sigaction action = {.sa_handler = on_signal};
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
}

int64_t player_due_ns(const struct player *p, const struct player_device *d, int64_t i) {
    int64_t due;
    if (p->rate_hz > 0) {
        due = (int64_t)((double)i * 1e9 / p->rate_hz);
    } else { // played again: a mean interval between the last and the first
        int64_t n = (int64_t)d->report_count, first = d->reports[0].t_ns;
        int64_t length = d->reports[n - 1].t_ns - first;
        due = (i / n) * (length + (n > 1 ? length / (n - 1) : 10000000)) + d->reports[i % n].t_ns -
              first;
    }
    if (p->late_at >= 0 && i >= p->late_at) {
        int64_t held =
            player_due_ns(&(struct player){.rate_hz = p->rate_hz, .late_at = -1}, d, p->late_at) +
            p->late_ns;
        due = due > held ? due : held;
    }
    return due;
}

int64_t player_total(const struct player *p, const struct player_device *d) {
    if (d->report_count == 0)
        return 0;
    return p->count < 0 ? (int64_t)d->report_count : p->count == 0 ? INT64_MAX : p->count;
}

void player_log_sent(const struct player *p, int64_t i) {
    if (p->sent_log)
        fprintf(p->sent_log, "%lld %lld\n", (long long)i, (long long)player_now_ns());
}

void player_print(const char *what, unsigned id, const uint8_t *bytes, size_t len) {
    printf("%s %u:", what, id);
    for (size_t i = 0; i < len; i++)
        printf(" %02x", bytes[i]);
    putchar('\n');
}

bool player_poll(int fd, int64_t t_ns) {
    int64_t left = t_ns - player_now_ns();
    left = left > 0 ? left : 0;
    struct timespec ts = {.tv_sec = left / 1000000000, .tv_nsec = left % 1000000000};
    struct pollfd p = {.fd = fd, .events = POLLIN};
    return ppoll(&p, 1, &ts, NULL) > 0;
}
