#ifndef ANTIPODE_RENDER_CELLS_H
#define ANTIPODE_RENDER_CELLS_H

#include "src/render/list.h"
#include "src/view/portal.h"

// A scene of cells: the cells that can be seen in a frame, and each one's parts into the list of
// what is drawn. One thread.
struct ap_cell_view {
    struct ap_cells *cells;
    struct ap_portal portal;
    size_t *parts; // those that every cell has
    size_t part_count;
    struct ap_level *level; // by shape: of the cell at hand, or that it is not chosen, or that
                            // none holds the bound
    size_t shape_count;
    bool warned; // the budget's end has been told
};

enum ap_status ap_cell_view_create(struct ap_error *err, const struct ap_scene *scene,
                                   const struct ap_meshes *meshes, struct ap_cell_view *view);
void ap_cell_view_destroy(struct ap_cell_view *view);

// After what is not in cells. Parts grow fainter toward the horizon. Where the budget ends the
// world ends nearer; it is said once.
enum ap_status ap_cell_view_fill(struct ap_error *err, struct ap_cell_view *view,
                                 const struct ap_list_params *params, struct ap_draw_list *list);

#endif
