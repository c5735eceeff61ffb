#ifndef ANTIPODE_GEOM_CELLS_H
#define ANTIPODE_GEOM_CELLS_H

#include <stddef.h>
#include <stdint.h>

#include "src/geom/pairing.h"

// The cells of a tiling around one of them, found as they are asked for: a graph whose nodes know
// where they are and who is across each face. The tiling looks the same from each of its cells, so
// one graph serves a walker wherever she is: cell 0 is always the one she is in. One thread.
struct ap_cell {
    struct ap_iso base_from_cell; // cell 0's frame from this one's
    double distance_m;            // of the centres
    bool reverses;
    int32_t next; // private
};

struct ap_cells {
    const struct ap_tiling *tiling; // borrowed, as is the pairing
    const struct ap_pairing *pairing;
    struct ap_cell *cells;
    int32_t *neighbour; // private; face_count each
    int32_t *bucket;
    size_t count, room, bucket_count, most;
};

// budget_bytes bounds what the graph may hold; at least some hundred cells are allowed.
enum ap_status ap_cells_create(struct ap_error *err, const struct ap_tiling *tiling,
                               const struct ap_pairing *pairing, size_t budget_bytes,
                               struct ap_cells **cells);
void ap_cells_destroy(struct ap_cells *cells);

// What it holds of its budget.
size_t ap_cells_bytes(const struct ap_cells *cells);

// The cell across a face of a cell; −1 where it is not known yet and the budget or the memory is
// used up, or beyond 20 rho in h3. What cells.cells points to may move.
int32_t ap_cells_across(struct ap_cells *cells, int32_t cell, int face);

// Across which face a walker has left the cell: the one she is farthest beyond, −1 where she is in
// it (beyond no face by more than 1e-6 of the inradius). The frame of the neighbour she is in then
// is cell_from_neighbour[to[face]] away: that takes the old cell's coordinates to the new one's.
int ap_cells_left_by(const struct ap_tiling *tiling, struct ap_vec4 at_m);

#endif
