#include "src/render/list.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/render/mesh/budget.h"
#include "src/render/pass/kind.h"

static const double PI = 3.14159265358979323846;

// What comes first in the order of drawing, as one number, so that items themselves are looked at
// only where it is equal.
struct ap_draw_key {
    uint64_t first;
    const struct ap_draw_item *item;
};

// What each item that there is room for takes.
enum { ITEM_BYTES = sizeof(struct ap_draw_item) + sizeof(struct ap_draw_key) + sizeof(void *) };

_Static_assert(ITEM_BYTES + AP_FRAMES_AHEAD * sizeof(struct ap_gpu_draw) <= AP_PART_BYTES,
               "the budget's size of a part (src/render/mesh/budget.h)");

static enum ap_status make_room(struct ap_error *err, size_t room, struct ap_draw_list *list) {
    struct ap_draw_item *items = realloc(list->items, room * sizeof *items);
    if (items)
        list->items = items;
    const struct ap_draw_item **order = realloc(list->order, room * sizeof *order);
    if (order)
        list->order = order;
    struct ap_draw_key *keys = realloc(list->keys, room * sizeof *keys);
    if (keys)
        list->keys = keys;
    if (!items || !order || !keys)
        return ap_fail(err, AP_ENVIRONMENT, "no memory to draw %zu parts", room);
    list->room = room;
    return AP_OK;
}

enum ap_status ap_draw_list_create(struct ap_error *err, size_t part_count,
                                   struct ap_draw_list *list) {
    memset(list, 0, sizeof *list);
    return make_room(err, 2 * part_count + 1, list);
}

enum ap_status ap_draw_list_reserve(struct ap_error *err, size_t more, struct ap_draw_list *list) {
    size_t room = list->count + more + 1;
    return room <= list->room ? AP_OK : make_room(err, ap_grown(room), list);
}

size_t ap_draw_list_item_bytes(void) {
    return ITEM_BYTES;
}

void ap_draw_list_destroy(struct ap_draw_list *list) {
    free(list->items);
    free(list->order);
    free(list->keys);
    ap_mesh_data_finish(&list->refined);
    ap_refiner_finish(&list->refiner);
    ap_snapped_finish(&list->snapped);
    memset(list, 0, sizeof *list);
}

static int compare_items(const void *left, const void *right) {
    const struct ap_draw_item *a = *(const struct ap_draw_item *const *)left,
                              *b = *(const struct ap_draw_item *const *)right;
    bool disc = a->pipeline == AP_PIPELINE_DISC;
    if (disc != (b->pipeline == AP_PIPELINE_DISC))
        return disc ? 1 : -1;
    if (a->rank != b->rank)
        return a->rank < b->rank ? -1 : 1;
    if (a->pipeline != b->pipeline)
        return a->pipeline < b->pipeline ? -1 : 1;
    if (a->far_m != b->far_m)
        return a->far_m > b->far_m ? -1 : 1;
    if (a->refined != b->refined)
        return a->refined ? 1 : -1;
    // Where in the frame's data such a mesh lies depends on what else is drawn.
    if (a->snapped != b->snapped)
        return a->snapped < b->snapped ? -1 : 1;
    if (a->snapped == 0 && a->mesh.first_index != b->mesh.first_index)
        return a->mesh.first_index < b->mesh.first_index ? -1 : 1;
    if (a->part != b->part)
        return a->part < b->part ? -1 : 1;
    if (a->image != b->image || a->way != b->way)
        return a->image != b->image ? a->image - b->image : a->way - b->way;
    // The same part of several cells: near before far.
    double dw = a->nose_from_part.m[3][3] - b->nose_from_part.m[3][3];
    return dw == 0 ? memcmp(&a->nose_from_part, &b->nose_from_part, sizeof a->nose_from_part)
           : (dw < 0) == (a->image == 0) ? -1
                                         : 1;
}

// What compare_items looks at first; far_m is 0 but for discs.
static uint64_t first_of(const struct ap_draw_item *item) {
    enum { MOST_RANK = (1 << 20) - 1 };
    uint64_t rank = (uint64_t)(item->rank < 0           ? 0
                               : item->rank > MOST_RANK ? MOST_RANK
                                                        : item->rank);
    uint64_t first = rank << 43 | (uint64_t)item->pipeline << 35;
    if (item->pipeline == AP_PIPELINE_DISC)
        return first | UINT64_C(1) << 63;
    return first | (uint64_t)item->refined << 34 | (uint64_t)item->mesh.first_index << 2;
}

static int compare_keys(const void *left, const void *right) {
    const struct ap_draw_key *a = left, *b = right;
    if (a->first != b->first)
        return a->first < b->first ? -1 : 1;
    return compare_items(&a->item, &b->item);
}

// Counts it for the eyes of `of`: drawn, or culled where it is not for them.
static void count(struct ap_draw_list *list, const struct ap_draw_item *item, unsigned of) {
    for (int e = 0; e < 2; e++) {
        if (!(of >> e & 1))
            continue;
        struct ap_eye_stats *stats = &list->stats.eye[e];
        if (!(item->eyes >> e & 1)) {
            stats->culled++;
            continue;
        }
        stats->draws++;
        stats->back_draws += item->image == 1;
        stats->triangles += item->mesh.index_count / 3;
        stats->vertices += item->mesh.vertex_count;
    }
}

static void note_range(struct ap_draw_list *list, int way, double near_m, double far_m) {
    list->range.near_m[way] = fmin(list->range.near_m[way], near_m);
    list->range.far_m[way] = fmax(list->range.far_m[way], far_m);
}

// In an s3 that she was born in, things up to her antipode are seen one way, things up to a full
// turn the other; what lies across it is drawn both ways, and each fragment once. False: beyond.
static bool born_way(const struct ap_viewer *viewer, double near_m, double far_m, int way,
                     bool *across) {
    double half = PI * viewer->born.rho_m;
    if (viewer->mode != AP_VIEW_BORN || viewer->born.kappa <= 0)
        return way == 0;
    *across = far_m > half - 0.3 * viewer->born.rho_m;
    return way == 0 ? near_m < half : far_m > half && near_m < 2 * half;
}

void ap_draw_list_add(struct ap_draw_list *list, const struct ap_viewer *viewer,
                      const struct ap_draw_item *image, unsigned of, const double range_m[2]) {
    struct ap_draw_item item = *image;
    double near_m = range_m[0], far_m = range_m[1];
    bool any = false, guard = ap_pipeline_is_guarded(item.pipeline);
    for (int way = 0; way < 2; way++) {
        bool across = false;
        if (!born_way(viewer, near_m, far_m, way, &across))
            continue;
        // A disc is all on one side of her antipode.
        bool disc = item.pipeline == AP_PIPELINE_DISC,
             behind = viewer->mode == AP_VIEW_BORN && viewer->born.kappa > 0 &&
                      near_m + far_m > 2 * PI * viewer->born.rho_m;
        if (disc && behind != (way == 1))
            continue;
        // Of what is culled too, so that culling changes nothing in the picture.
        bool born = viewer->mode == AP_VIEW_BORN;
        note_range(list, born ? way : item.image, near_m, far_m);
        any = true;
        item.way = way;
        if (across && !guard && !disc)
            item.pipeline = ap_pipeline_looked_at(item.pipeline, false);
        if (item.eyes != 0)
            list->items[list->count++] = item;
        count(list, &item, of);
    }
    item.eyes = 0;
    if (!any)
        count(list, &item, of);
}

void ap_draw_list_sort(struct ap_draw_list *list) {
    for (size_t i = 0; i < list->count; i++)
        list->keys[i] = (struct ap_draw_key){first_of(&list->items[i]), &list->items[i]};
    qsort(list->keys, list->count, sizeof *list->keys, compare_keys);
    for (size_t i = 0; i < list->count; i++)
        list->order[i] = list->keys[i].item;
}
