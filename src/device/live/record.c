#include "src/device/live/record.h"

#include <inttypes.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/file.h"
#include "src/device/log/pack.h"
#include "src/device/poselog.h"

// Readers put nodes into a list; whoever writes takes the list, sorts by time (queues that were
// found late are dated back) and writes what nothing can come before any more.

static const int64_t HOLD_BACK_NS = 1000000000, ZERO_NS = 1000000000;
enum { BYTES_MAX = 256 << 20 }; // of nodes; a disk that hangs must not eat the machine

enum node_kind { NODE_DEVICE, NODE_REPORT, NODE_POSE };

struct node {
    struct node *next; // newest first
    enum node_kind kind;
    int device;
    int64_t t_ns, sequence;
    char role[AP_LIVE_ROLE_NAME_MAX]; // NODE_POSE
    struct ap_sample sample;
    size_t len;
    uint8_t bytes[]; // NODE_REPORT: the report; NODE_DEVICE: lines
};

struct ap_recorder {
    pthread_mutex_t lock; // of the next ones
    struct node *newest;
    size_t held; // bytes
    int64_t sequence;
    struct ap_record_counts counts;
    struct {
        bool is_known;
        int number;    // of its D: line
        uint64_t what; // of the lines that stand under it
    } devices[AP_LIVE_DEVICES_MAX];
    int again; // numbers beyond the devices' that have been given

    int64_t zero_ns;
    struct ap_outfile raw, csv;
    struct ap_packer *packer;
    struct node **pending; // sorted, but for what was added since
    size_t pending_count, pending_room;
    int device;             // whose lines the file is at; −1: nobody's
    int64_t raw_ns, csv_ns; // the newest written
};

// --- from the readers

static struct node *make_node(struct ap_recorder *r, enum node_kind kind, int device, int64_t t_ns,
                              size_t len) {
    struct node *node = calloc(1, sizeof *node + len);
    if (!node)
        return NULL;
    node->kind = kind;
    node->device = device;
    node->t_ns = t_ns - r->zero_ns;
    node->len = len;
    return node;
}

static void put(struct ap_recorder *r, struct node *node) {
    pthread_mutex_lock(&r->lock);
    bool room = node && r->held + sizeof *node + node->len <= BYTES_MAX;
    if (room) {
        r->held += sizeof *node + node->len;
        node->device = r->devices[node->device].number;
        r->counts.reports += node->kind == NODE_REPORT;
        r->counts.poses += node->kind == NODE_POSE;
        node->sequence = r->sequence++;
        node->next = r->newest;
        r->newest = node;
    } else {
        r->counts.dropped++;
    }
    pthread_mutex_unlock(&r->lock);
    if (!room)
        free(node);
}

static void on_report(void *user, const struct ap_live_report *report) {
    struct node *node =
        make_node(user, NODE_REPORT, report->device, report->arrival_ns, report->len);
    if (node)
        memcpy(node->bytes, report->bytes, report->len);
    put(user, node);
}

static void on_pose(void *user, const struct ap_live_pose_row *row) {
    if (!row->role[0])
        return;
    struct node *node = make_node(user, NODE_POSE, row->device, row->t_ns, 0);
    if (node) {
        memcpy(node->role, row->role, sizeof node->role);
        node->sample = (struct ap_sample){.t_ns = node->t_ns,
                                          .pose = row->pose,
                                          .trigger = row->sample->trigger,
                                          .select = row->sample->buttons & 1,
                                          .reset = row->restarted};
    }
    put(user, node);
}

static void print_bytes(FILE *f, const char *key, const uint8_t *bytes, size_t len) {
    fprintf(f, "%s %zu", key, len);
    for (size_t i = 0; i < len; i++)
        fprintf(f, " %02x", (unsigned)bytes[i]);
    fputc('\n', f);
}

// A hash (FNV-1a) of what a reader must know to understand the reports.
static uint64_t what_of(const struct ap_live_place *p) {
    const uint16_t ids[3] = {p->bus, p->vendor, p->product};
    uint64_t hash = UINT64_C(14695981039346656037);
    for (size_t i = 0; i < sizeof ids + p->descriptor_len; i++) {
        uint8_t byte = i < sizeof ids ? ((const uint8_t *)ids)[i] : p->descriptor[i - sizeof ids];
        hash = (hash ^ byte) * UINT64_C(1099511628211);
    }
    return hash;
}

// The number under which the device's lines stand: one that has come back by another way speaks
// otherwise, and is another one to whoever reads.
static int number_for(struct ap_recorder *r, int device, const struct ap_live_place *place) {
    uint64_t what = what_of(place);
    pthread_mutex_lock(&r->lock);
    if (!r->devices[device].is_known) {
        r->counts.devices++;
        r->devices[device].is_known = true;
        r->devices[device].number = device;
    } else if (r->devices[device].what != what) {
        r->devices[device].number = AP_LIVE_DEVICES_MAX + r->again++;
    }
    r->devices[device].what = what;
    int number = r->devices[device].number;
    pthread_mutex_unlock(&r->lock);
    return number;
}

// A device begins, or begins anew: what a recorder says of it.
static void on_started(void *user, int device, const struct ap_live_place *place,
                       const struct ap_device_info *info, int64_t now_ns) {
    struct ap_recorder *r = user;
    char *text = NULL;
    size_t len = 0;
    FILE *f = open_memstream(&text, &len);
    if (f) {
        fprintf(f, "D: %d\n", number_for(r, device, place));
        if (place->serial[0])
            fprintf(f, "# serial: %s\n", place->serial);
        print_bytes(f, "R:", place->descriptor, place->descriptor_len);
        fprintf(f, "N: %s\nP: %s\nI: %x %04x %04x\n", place->name, place->port,
                (unsigned)place->bus, (unsigned)place->vendor, (unsigned)place->product);
        for (int i = 0; i < info->feature_count; i++)
            print_bytes(f, "# F:", info->features[i].bytes, info->features[i].len);
        fclose(f);
    }
    // Before its first report also where that is cut to microseconds.
    struct node *node = text ? make_node(r, NODE_DEVICE, device, now_ns - 1000, len) : NULL;
    if (node)
        memcpy(node->bytes, text, len);
    free(text);
    put(r, node);
}

struct ap_live_listener ap_recorder_listener(struct ap_recorder *recorder) {
    return (struct ap_live_listener){
        .user = recorder, .started = on_started, .report = on_report, .pose = on_pose};
}

// --- to the files

static bool pack_text(struct ap_recorder *r, const char *text, size_t len) {
    return ap_packer_write(r->packer, text, len);
}

static bool go_to(struct ap_recorder *r, int device) {
    char line[32];
    if (r->device == device)
        return true;
    r->device = device;
    return pack_text(r, line, (size_t)snprintf(line, sizeof line, "D: %d\n", device));
}

static bool write_report(struct ap_recorder *r, const struct node *node) {
    static const char digits[] = "0123456789abcdef";
    char line[64 + 3 * AP_HID_REPORT_MAX];
    int64_t t_us = (node->t_ns > r->raw_ns ? node->t_ns : r->raw_ns) / 1000;
    size_t n = (size_t)snprintf(line, 64, "E: %06" PRId64 ".%06" PRId64 " %zu", t_us / 1000000,
                                t_us % 1000000, node->len);
    for (size_t i = 0; i < node->len; i++) {
        line[n++] = ' ';
        line[n++] = digits[node->bytes[i] >> 4];
        line[n++] = digits[node->bytes[i] & 15];
    }
    line[n++] = '\n';
    r->raw_ns = t_us * 1000;
    return go_to(r, node->device) && pack_text(r, line, n);
}

// A pose log's times do not decrease.
static void write_pose(struct ap_recorder *r, const struct node *node) {
    if (node->t_ns < r->csv_ns) {
        pthread_mutex_lock(&r->lock);
        r->counts.dropped++;
        pthread_mutex_unlock(&r->lock);
        return;
    }
    r->csv_ns = node->t_ns;
    ap_poselog_write_row(r->csv.stream, node->role, &node->sample);
}

static bool write_node(struct ap_recorder *r, const struct node *node) {
    switch (node->kind) {
    case NODE_REPORT:
        return write_report(r, node);
    case NODE_DEVICE:
        r->device = node->device;
        return pack_text(r, (const char *)node->bytes, node->len);
    case NODE_POSE:
        write_pose(r, node);
        break;
    }
    return true;
}

static int by_time(const void *a, const void *b) {
    const struct node *x = *(struct node *const *)a, *y = *(struct node *const *)b;
    if (x->t_ns != y->t_ns)
        return x->t_ns < y->t_ns ? -1 : 1;
    return x->sequence < y->sequence ? -1 : x->sequence > y->sequence;
}

static bool take_newest(struct ap_recorder *r) {
    pthread_mutex_lock(&r->lock);
    struct node *list = r->newest;
    r->newest = NULL;
    pthread_mutex_unlock(&r->lock);
    bool ok = true;
    while (list) {
        struct node *next = list->next;
        if (r->pending_count == r->pending_room) {
            size_t room = r->pending_room ? 2 * r->pending_room : 1024;
            struct node **more = realloc(r->pending, room * sizeof(struct node *));
            if (more) {
                r->pending = more;
                r->pending_room = room;
            }
        }
        if (r->pending_count < r->pending_room) {
            r->pending[r->pending_count++] = list;
        } else {
            free(list);
            ok = false;
        }
        list = next;
    }
    if (r->pending_count)
        qsort(r->pending, r->pending_count, sizeof *r->pending, by_time);
    return ok;
}

static enum ap_status write_until(struct ap_error *err, struct ap_recorder *r, int64_t until_ns) {
    bool ok = take_newest(r);
    size_t done = 0, bytes = 0;
    for (; ok && done < r->pending_count && r->pending[done]->t_ns <= until_ns; done++) {
        ok = write_node(r, r->pending[done]);
        bytes += sizeof(struct node) + r->pending[done]->len;
        free(r->pending[done]);
    }
    r->pending_count -= done;
    if (done)
        memmove(r->pending, r->pending + done, r->pending_count * sizeof(struct node *));
    pthread_mutex_lock(&r->lock);
    r->held -= bytes;
    pthread_mutex_unlock(&r->lock);
    if (!ok)
        return ap_fail(err, AP_ENVIRONMENT, "%s: out of memory", r->raw.path);
    if (ferror(r->raw.stream) || ferror(r->csv.stream))
        return ap_fail(err, AP_ENVIRONMENT, "%s: cannot be written (is the disk full?)",
                       ferror(r->raw.stream) ? r->raw.path : r->csv.path);
    return AP_OK;
}

enum ap_status ap_recorder_write(struct ap_error *err, struct ap_recorder *r, int64_t now_ns) {
    return write_until(err, r, now_ns - r->zero_ns - HOLD_BACK_NS);
}

struct ap_record_counts ap_recorder_counts(struct ap_recorder *r) {
    pthread_mutex_lock(&r->lock);
    struct ap_record_counts counts = r->counts;
    pthread_mutex_unlock(&r->lock);
    return counts;
}

// --- beginning and end

static bool cut(char *name, const char *end) {
    size_t n = strlen(name), m = strlen(end);
    bool ends = n > m && strcmp(name + n - m, end) == 0 && name[n - m - 1] != '/';
    if (ends)
        name[n - m] = '\0';
    return ends;
}

enum ap_status ap_record_csv_path(struct ap_error *err, const char *path, char *csv, size_t size) {
    int n = snprintf(csv, size, "%s", path);
    if (n < 0 || (size_t)n + sizeof ".csv" > size)
        return ap_fail(err, AP_USAGE, "%s: too long a name", path);
    if (!cut(csv, ".gz"))
        cut(csv, ".zst");
    if (cut(csv, ".csv"))
        return ap_fail(err, AP_USAGE,
                       "%s: the poses go into the CSV; name the raw recording, as take.hid", path);
    if (!cut(csv, ".hid"))
        cut(csv, ".txt");
    memcpy(csv + strlen(csv), ".csv", sizeof ".csv");
    return AP_OK;
}

enum ap_status ap_recorder_create(struct ap_error *err, const char *path, int64_t start_ns,
                                  struct ap_recorder **out) {
    static const char head[] =
        "# antipode record: raw HID reports, microseconds; feature reports as # F: lines\n";
    char csv[4096];
    enum ap_status st = ap_record_csv_path(err, path, csv, sizeof csv);
    if (st)
        return st;
    struct ap_recorder *r = calloc(1, sizeof *r);
    if (!r)
        return ap_fail(err, AP_ENVIRONMENT, "%s: out of memory", path);
    pthread_mutex_init(&r->lock, NULL);
    r->zero_ns = start_ns - start_ns % 1000 - ZERO_NS;
    r->device = -1;
    st = ap_outfile_open(err, path, &r->raw);
    if (!st)
        st = ap_outfile_open(err, csv, &r->csv);
    if (!st) {
        r->packer = ap_packer_create(ap_packing_of_name(path), r->raw.stream);
        if (!r->packer || !pack_text(r, head, sizeof head - 1))
            st = ap_fail(err, AP_ENVIRONMENT, "%s: out of memory", path);
    }
    if (st) {
        ap_recorder_destroy(r);
        return st;
    }
    ap_poselog_write_header(r->csv.stream);
    *out = r;
    return AP_OK;
}

enum ap_status ap_recorder_finish(struct ap_error *err, struct ap_recorder *r) {
    enum ap_status st = write_until(err, r, INT64_MAX);
    if (!st && !ap_packer_finish(r->packer))
        st = ap_fail(err, AP_ENVIRONMENT, "%s: cannot be packed", r->raw.path);
    if (!st)
        st = ap_outfile_commit(err, &r->csv);
    return st ? st : ap_outfile_commit(err, &r->raw);
}

void ap_recorder_destroy(struct ap_recorder *r) {
    if (!r)
        return;
    ap_outfile_abort(&r->raw);
    ap_outfile_abort(&r->csv);
    ap_packer_destroy(r->packer);
    while (r->newest) {
        struct node *next = r->newest->next;
        free(r->newest);
        r->newest = next;
    }
    for (size_t i = 0; i < r->pending_count; i++)
        free(r->pending[i]);
    free(r->pending);
    pthread_mutex_destroy(&r->lock);
    free(r);
}
