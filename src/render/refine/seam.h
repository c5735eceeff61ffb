#ifndef ANTIPODE_RENDER_REFINE_SEAM_H
#define ANTIPODE_RENDER_REFINE_SEAM_H

#include "src/render/place/frame.h"
#include "src/render/mesh/meshes.h"
#include "src/render/place/place.h"

// Lines that pieces of a world of cells share: two walls the edge at which they meet, two wedges of
// a strut or of a joint the line between their cells. Each piece has a level of detail of its own,
// but how a seam is cut depends on where its ends are and on nothing else, so that all who share it
// draw the same polyline and nothing shows between them.

// A seam of a piece in a frame.
struct ap_seam_cut {
    signed char depth; // into 2^depth pieces of equal length; AP_SEAM_BY_PIECE: each as
                       // ap_refine_part finds it necessary, by the piece's own ends
    bool any_depth;    // an error in depth does not show (ap_is_stretched)
};
enum { AP_SEAM_BY_PIECE = -1 };

// How a part's seams (of its shape) are cut so that they are seen within max_error_px of where they
// are; false where some are to be cut piece by piece. *pieces: the most that any one is cut into.
bool ap_seams_cut(const struct ap_viewer *viewer, const struct ap_eyes *eyes,
                  const struct ap_part *part, const struct ap_shape *shape,
                  const struct ap_iso *nose_from_part, int image, double max_error_px,
                  struct ap_seam_cut cuts[AP_SEAMS_MAX], int *pieces);

// Levels whose seams are coarser than the rest, as a frame needs them: each is made once.
struct ap_snapped {
    struct ap_snapped_mesh *made; // open addressing, a power of two
    size_t count, room;
    uint32_t *moved; // scratch
    size_t moved_room;
};
void ap_snapped_clear(struct ap_snapped *snapped);
void ap_snapped_finish(struct ap_snapped *snapped);

// The mesh of a level with seams that are cut so: the one made ahead where that is what it has
// (*own false, *which 0), else one in data; equal ones have the same *which. No seam may be cut
// into more pieces than the level has. AP_ENVIRONMENT: no memory.
enum ap_status ap_snapped_mesh(struct ap_error *err, struct ap_snapped *snapped,
                               const struct ap_meshes *meshes, size_t shape, int level,
                               const struct ap_seam_cut cuts[AP_SEAMS_MAX],
                               struct ap_mesh_data *data, struct ap_mesh *mesh, uint64_t *which,
                               bool *own);

#endif
