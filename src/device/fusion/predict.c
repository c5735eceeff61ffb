#include "src/device/fusion/predict.h"

#include <string.h>

#include "src/device/unit_quat.h"

// Over less than this a difference of poses is mostly the noise of its quotient.
static const int64_t SHORTEST_BASELINE_NS = 4000000;

enum { APART = 1, LOST = 2, HAS_RATE = 4 };

struct entry {
    int64_t t_ns;
    uint64_t flags;
    struct ap_pose pose;
    struct ap_vec3 rate;
};

static bool fill_ns(int64_t *value, int64_t standard) {
    if (*value == 0)
        *value = standard;
    return *value > 0 && *value <= 10000000000;
}

bool ap_history_init(struct ap_history *history, const struct ap_history_params *params) {
    struct ap_history_params p = *params;
    if (p.tau_s == 0)
        p.tau_s = 0.1;
    if (p.jump_m_s == 0)
        p.jump_m_s = 30;
    if (!(p.tau_s >= 1e-3 && p.jump_m_s > 0) || !fill_ns(&p.ahead_max_ns, 40000000) ||
        !fill_ns(&p.lost_after_ns, 100000000) || !fill_ns(&p.still_after_ns, 60000000) ||
        !fill_ns(&p.baseline_ns, 15000000))
        return false;
    memset(history, 0, sizeof *history);
    history->params = p;
    history->last_t_ns = INT64_MIN;
    history->apart = true;
    history->last_pose = AP_POSE_IDENTITY;
    return true;
}

static uint64_t bits_of(double x) {
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static double double_of(uint64_t bits) {
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

// The words are stored with release and loaded with acquire order, so that whoever sees a new word
// sees the odd sequence number before it; that needs no fence, which ThreadSanitizer would not
// understand. Entry k has the sequence number 2k + 2 once it is whole.
static void write_entry(struct ap_history *h, const struct entry *e) {
    uint64_t k = atomic_load_explicit(&h->written, memory_order_relaxed);
    struct ap_history_slot *slot = &h->slots[k % AP_HISTORY_SLOTS];
    const uint64_t words[AP_HISTORY_WORDS] = {(uint64_t)e->t_ns,
                                              e->flags,
                                              bits_of(e->pose.p.x),
                                              bits_of(e->pose.p.y),
                                              bits_of(e->pose.p.z),
                                              bits_of(e->pose.q.x),
                                              bits_of(e->pose.q.y),
                                              bits_of(e->pose.q.z),
                                              bits_of(e->pose.q.w),
                                              bits_of(e->rate.x),
                                              bits_of(e->rate.y),
                                              bits_of(e->rate.z),
                                              k};
    atomic_store_explicit(&slot->sequence, 2 * k + 1, memory_order_relaxed);
    for (int i = 0; i < AP_HISTORY_WORDS; i++)
        atomic_store_explicit(&slot->words[i], words[i], memory_order_release);
    atomic_store_explicit(&slot->sequence, 2 * k + 2, memory_order_release);
    atomic_store_explicit(&h->written, k + 1, memory_order_release);
}

// False where it has been overwritten.
static bool read_entry(const struct ap_history *h, uint64_t k, struct entry *e) {
    const struct ap_history_slot *slot = &h->slots[k % AP_HISTORY_SLOTS];
    uint64_t w[AP_HISTORY_WORDS];
    if (atomic_load_explicit(&slot->sequence, memory_order_acquire) != 2 * k + 2)
        return false;
    for (int i = 0; i < AP_HISTORY_WORDS; i++)
        w[i] = atomic_load_explicit(&slot->words[i], memory_order_acquire);
    if (atomic_load_explicit(&slot->sequence, memory_order_relaxed) != 2 * k + 2 || w[12] != k)
        return false;
    *e = (struct entry){
        .t_ns = (int64_t)w[0],
        .flags = w[1],
        .pose = {{double_of(w[2]), double_of(w[3]), double_of(w[4])},
                 {double_of(w[5]), double_of(w[6]), double_of(w[7]), double_of(w[8])}},
        .rate = {double_of(w[9]), double_of(w[10]), double_of(w[11])}};
    return true;
}

static bool finite3(struct ap_vec3 v) {
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

bool ap_history_push(struct ap_history *h, int64_t t_ns, struct ap_pose pose,
                     const struct ap_vec3 *rate_rad_s) {
    if (t_ns <= h->last_t_ns || !finite3(pose.p) || !ap_quat_make_unit(&pose.q) ||
        (rate_rad_s && !finite3(*rate_rad_s))) {
        h->rejected++;
        return false;
    }
    struct entry e = {.t_ns = t_ns, .pose = pose, .flags = h->apart ? APART : 0};
    if (rate_rad_s) {
        e.flags |= HAS_RATE;
        e.rate = *rate_rad_s;
    }
    write_entry(h, &e);
    h->apart = false;
    h->last_t_ns = t_ns;
    h->last_pose = pose;
    return true;
}

void ap_history_reset(struct ap_history *h) {
    h->apart = true;
}

void ap_history_lose(struct ap_history *h, int64_t t_ns) {
    if (h->last_t_ns == INT64_MIN || h->last_t_ns == INT64_MAX)
        return;
    if (t_ns <= h->last_t_ns)
        t_ns = h->last_t_ns + 1;
    write_entry(h, &(struct entry){.t_ns = t_ns, .pose = h->last_pose, .flags = LOST});
    h->apart = true;
    h->last_t_ns = t_ns;
}

struct ap_pose ap_predict(struct ap_pose pose, struct ap_vec3 linear_m_s,
                          struct ap_vec3 angular_rad_s, double h_s, double tau_s) {
    double part = isinf(tau_s) ? h_s : -tau_s * expm1(-h_s / tau_s);
    double rate = ap_vec3_length(angular_rad_s);
    if (rate > 0)
        pose.q = ap_quat_normalize(ap_quat_mul(
            ap_quat_from_axis_angle(ap_vec3_normalize(angular_rad_s), rate * part), pose.q));
    pose.p = ap_vec3_add(pose.p, ap_vec3_scale(part, linear_m_s));
    return pose;
}

// The rotation vector that takes a to b, the short way, over dt_s, in the room.
static struct ap_vec3 rate_between(struct ap_quat a, struct ap_quat b, double dt_s) {
    struct ap_quat d = ap_quat_mul(b, ap_quat_conj(a));
    struct ap_vec3 v = {d.x, d.y, d.z};
    double size = ap_vec3_length(v);
    if (size == 0)
        return v;
    double angle = 2 * atan2(size, fabs(d.w));
    return ap_vec3_scale((d.w < 0 ? -angle : angle) / (size * dt_s), v);
}

// Times may lie 2⁶⁴ ns apart.
static int64_t minus(int64_t a, int64_t b) {
    int64_t d;
    return __builtin_sub_overflow(a, b, &d) ? (a > b ? INT64_MAX : INT64_MIN) : d;
}

static bool joins(const struct ap_history_params *p, const struct entry *a, const struct entry *b) {
    int64_t gap = minus(b->t_ns, a->t_ns);
    double way = ap_vec3_length(ap_vec3_sub(b->pose.p, a->pose.p));
    return !(b->flags & (APART | LOST)) && !(a->flags & LOST) && gap <= p->still_after_ns &&
           way <= p->jump_m_s * 1e-9 * (double)gap;
}

// The velocity at entry k: from the differences to the first sample that is at least the baseline
// older, through samples that belong together.
static void velocity_at(const struct ap_history *h, uint64_t k, const struct entry *newest,
                        struct ap_history_answer *answer) {
    const struct ap_history_params *p = &h->params;
    struct entry base = *newest, next;
    while (k > 0 && minus(newest->t_ns, base.t_ns) < p->baseline_ns && read_entry(h, --k, &next) &&
           joins(p, &next, &base))
        base = next;
    int64_t dt_ns = minus(newest->t_ns, base.t_ns);
    if (dt_ns == 0)
        return;
    if (newest->flags & HAS_RATE)
        answer->angular_rad_s = ap_quat_rotate(newest->pose.q, newest->rate);
    if (dt_ns < SHORTEST_BASELINE_NS)
        return;
    double dt_s = 1e-9 * (double)dt_ns;
    answer->linear_m_s = ap_vec3_scale(1 / dt_s, ap_vec3_sub(newest->pose.p, base.pose.p));
    if (!(newest->flags & HAS_RATE))
        answer->angular_rad_s = rate_between(base.pose.q, newest->pose.q, dt_s);
}

static void after_newest(const struct ap_history *h, uint64_t k, const struct entry *newest,
                         struct ap_history_answer *answer) {
    const struct ap_history_params *p = &h->params;
    answer->pose = newest->pose;
    answer->state = AP_POSE_LOST;
    if (newest->flags & LOST)
        return;
    velocity_at(h, k, newest, answer);
    int64_t ahead = answer->age_ns;
    if (ahead <= p->lost_after_ns)
        answer->state = ahead == 0 ? AP_POSE_EXACT : AP_POSE_PREDICTED;
    if (ahead > p->ahead_max_ns)
        ahead = p->ahead_max_ns;
    if (ahead > 0)
        answer->pose = ap_predict(newest->pose, answer->linear_m_s, answer->angular_rad_s,
                                  1e-9 * (double)ahead, p->tau_s);
    if (answer->state == AP_POSE_LOST)
        answer->linear_m_s = answer->angular_rad_s = (struct ap_vec3){0, 0, 0};
}

static void between(const struct ap_history *h, uint64_t k, int64_t t_ns, const struct entry *a,
                    const struct entry *b, struct ap_history_answer *answer) {
    answer->pose = a->pose;
    answer->state = AP_POSE_LOST;
    if (a->flags & LOST)
        return;
    int64_t gap = minus(b->t_ns, a->t_ns);
    if (a->t_ns == t_ns) {
        answer->state = AP_POSE_EXACT;
        velocity_at(h, k, a, answer);
    } else if (!(b->flags & (APART | LOST)) && gap <= h->params.lost_after_ns) {
        answer->state = AP_POSE_INTERPOLATED;
        answer->pose =
            ap_pose_interpolate(a->pose, b->pose, (double)(t_ns - a->t_ns) / (double)gap);
        if (joins(&h->params, a, b)) {
            double dt_s = 1e-9 * (double)gap;
            answer->linear_m_s = ap_vec3_scale(1 / dt_s, ap_vec3_sub(b->pose.p, a->pose.p));
            answer->angular_rad_s = rate_between(a->pose.q, b->pose.q, dt_s);
        }
    }
}

struct ap_history_answer ap_history_at(const struct ap_history *h, int64_t t_ns) {
    struct ap_history_answer answer = {.state = AP_POSE_NONE, .pose = AP_POSE_IDENTITY};
    struct entry a, b;
    uint64_t end;
    do { // again only where the writer went round the whole ring meanwhile
        end = atomic_load_explicit(&h->written, memory_order_acquire);
        if (end == 0)
            return answer;
    } while (!read_entry(h, end - 1, &b));
    answer.age_ns = minus(t_ns, b.t_ns);
    if (t_ns >= b.t_ns) {
        after_newest(h, end - 1, &b, &answer);
        return answer;
    }
    // The newest entry at or before t: low is before t or gone, high (its entry is b) is after.
    uint64_t low = end > AP_HISTORY_SLOTS ? end - AP_HISTORY_SLOTS : 0, high = end - 1;
    bool found = false, gone = low > 0;
    struct entry before = b;
    while (low < high) {
        uint64_t middle = low + (high - low) / 2;
        if (!read_entry(h, middle, &a)) {
            low = middle + 1;
            gone = true;
            found = false;
        } else if (a.t_ns <= t_ns) {
            low = middle + 1;
            before = a;
            found = true;
        } else {
            high = middle;
            b = a;
        }
    }
    if (found) {
        between(h, high - 1, t_ns, &before, &b, &answer);
    } else if (gone) {
        answer.pose = b.pose;
        answer.state = AP_POSE_LOST;
    }
    return answer;
}
