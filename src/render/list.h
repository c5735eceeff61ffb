#ifndef ANTIPODE_RENDER_LIST_H
#define ANTIPODE_RENDER_LIST_H

#include "src/render/pass/pass.h"
#include "src/render/place/place.h"
#include "src/render/refine/refine.h"
#include "src/render/renderer.h"

// What is drawn in a frame: list.c holds, orders and counts it, list_fill.c chooses meshes,
// list_write.c says what the shaders need.

// A part in an image, for the eyes that may see it.
struct ap_draw_item {
    uint32_t part;
    int image;
    int way; // native-of: 1, seen the long way round her own s3
    unsigned eyes;
    enum ap_pipeline_kind pipeline;
    int rank;     // drawn in this order, near before far, so that what is hidden is not shaded
    bool refined; // mesh lies in the list's own data, not in the scene's
    bool beyond;  // it shows the part farther off than the bound
    struct ap_mesh mesh;
    uint64_t snapped; // 0, or which of the meshes it is that are shared in a frame
    double far_m;     // discs: their order
    struct ap_iso nose_from_part;
    bool at_foot;      // its part is moved along its plane (ap_plane_foot), the lamp with it
    bool lamp_in_cell; // lit by its cell's lamp, which is at lamp (in the part), not the scene's
    struct ap_vec4 lamp;
    float brightness; // of cells: how far from the background's colour to its own; else 1
};

struct ap_draw_list {
    struct ap_draw_item *items;        // what is reserved
    const struct ap_draw_item **order; // as they are drawn: after ap_draw_list_sort
    struct ap_draw_key *keys;          // of its own
    size_t count, room;
    struct ap_depth_range range;
    struct ap_frame_stats stats;
    // Meshes made for this frame alone, where none made ahead is good enough.
    struct ap_mesh_data refined;
    struct ap_refiner refiner;
    struct ap_snapped snapped;
};

struct ap_list_params {
    const struct ap_scene *scene;
    const struct ap_meshes *meshes;
    const struct ap_frame_input *input;
    const struct ap_eyes *eyes;
    uint32_t width_px, height_px; // of the pictures that are drawn
    double max_error_px;
    bool no_cull;
};

enum ap_status ap_draw_list_create(struct ap_error *err, size_t part_count,
                                   struct ap_draw_list *list);
void ap_draw_list_destroy(struct ap_draw_list *list);
// What each item that there is room for takes in the process.
size_t ap_draw_list_item_bytes(void);

// Places every part, drops what no eye can see before any vertex is touched, finds each one a mesh
// that holds the bound. AP_ENVIRONMENT: no memory.
enum ap_status ap_draw_list_fill(struct ap_error *err, const struct ap_list_params *params,
                                 struct ap_draw_list *list);

// Room for so many more items.
enum ap_status ap_draw_list_reserve(struct ap_error *err, size_t more, struct ap_draw_list *list);

// Gives an item, whose place, image and pipeline are known, a mesh that holds the bound: one made
// ahead, or where none does (or only a large one) one for this frame, which may change the pipeline
// to one that takes its depth from the surface. Its seams are cut as all parts that share them do.
// Counts what cannot hold the bound. known: a level that is known to, or NULL.
enum ap_status ap_draw_list_mesh(struct ap_error *err, const struct ap_list_params *params,
                                 const struct ap_place *place, const struct ap_level *known,
                                 struct ap_draw_list *list, struct ap_draw_item *item);

// Adds one part in one image, seen at distances from range_m[0] to range_m[1], for its eyes; counts
// it for those of `of` (a bit an eye), as culled for the ones that are not its own.
void ap_draw_list_add(struct ap_draw_list *list, const struct ap_viewer *viewer,
                      const struct ap_draw_item *item, unsigned of, const double range_m[2]);
// Fills `order`, so that equal meshes follow one another, after the last one has been added; it
// depends on the input only.
void ap_draw_list_sort(struct ap_draw_list *list);

// Once it is sorted: writes what the shaders need of each item, and the marks of the surface that
// takes them.
void ap_draw_list_write(const struct ap_scene *scene, const struct ap_frame_input *input,
                        const struct ap_eyes *eyes, const struct ap_draw_list *list,
                        struct ap_gpu_draw *draws, struct ap_gpu_marks *marks);

// How many of each mark a scene has at most: shadows + 256·mouths.
int32_t ap_draw_list_marks(const struct ap_scene *scene);

// An sRGB component, 0…1, as linear light.
float ap_linear_color(double srgb);

#endif
