#include "src/device/log/iwer.h"
#include "src/device/log/poselog_document.h"

// The poses in a recording of IWER (iwer.h): the head, and of each hand the grip, or the ray where
// there is none. Of its gamepad the first button is the trigger, the second one the squeeze.

struct reading {
    struct ap_document *document;
    int64_t t_ns, frame;
};

static enum ap_status add(struct ap_error *err, struct reading *r, const struct ap_json_at *at,
                          const char *device, struct ap_table_row row) {
    row.t_ns = r->t_ns;
    row.frame = r->frame;
    struct ap_error why;
    enum ap_status st = ap_document_add(&why, r->document, device, row);
    return st == AP_INPUT ? ap_json_fail(err, at, "%s", why.text)
           : st           ? ap_fail(err, st, "%s", why.text)
                          : AP_OK;
}

static enum ap_status take_frame(struct ap_error *err, void *user, int64_t t_ns,
                                 const struct ap_json_at *frame) {
    struct reading *r = user;
    r->t_ns = t_ns;
    r->frame = (int64_t)frame->index;
    struct ap_table_row row = {0};
    enum ap_status st = ap_iwer_pose(err, frame, AP_IWER_HEAD, &row.pose);
    return st ? st : add(err, r, frame, "head", row);
}

static enum ap_status read_gamepad(struct ap_error *err, const struct ap_json_at *pad,
                                   size_t buttons, struct ap_table_row *row) {
    double v[3];
    bool there;
    enum ap_status st = AP_OK;
    if (buttons > 0)
        st = ap_iwer_button(err, pad, 0, v, &there);
    if (st || buttons == 0)
        return st;
    row->select = v[0] != 0;
    row->trigger = (float)v[2];
    if (buttons > 1)
        st = ap_iwer_button(err, pad, 1, v, &there);
    if (!st && buttons > 1)
        row->squeeze = (float)v[2];
    return st;
}

static enum ap_status take_source(struct ap_error *err, void *user,
                                  const struct ap_iwer_source *what,
                                  const struct ap_json_at *source) {
    struct reading *r = user;
    if (!what->device)
        return AP_OK;
    struct ap_table_row row = {0};
    struct ap_json_at grip = ap_json_element(source, what->grip),
                      pad = ap_json_element(source, what->gamepad);
    bool has_grip = what->grip && json_is_array(grip.value);
    enum ap_status st =
        ap_iwer_pose(err, has_grip ? &grip : source, has_grip ? 0 : AP_IWER_RAY, &row.pose);
    if (!st && what->gamepad && json_is_array(pad.value))
        st = read_gamepad(err, &pad, what->buttons, &row);
    return st ? st : add(err, r, source, what->device, row);
}

static enum ap_status pass_over(struct ap_error *err, void *user, const struct ap_error *why) {
    struct reading *r = user;
    return ap_document_reject(err, r->document, why);
}

enum ap_status ap_iwer_read_poses(struct ap_error *err, struct ap_document *document,
                                  const struct ap_json_at *root) {
    struct reading r = {.document = document};
    const struct ap_iwer_visitor visitor = {
        .user = &r, .frame = take_frame, .source = take_source, .bad = pass_over};
    return ap_iwer_visit(err, root, &visitor);
}
