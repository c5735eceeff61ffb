#ifndef ANTIPODE_GEOM_PAIRING_H
#define ANTIPODE_GEOM_PAIRING_H

#include "src/geom/tiling.h"

// How the cells of a tiling hang together: for each face, in whose frame the neighbour across it is
// seen. The same step is right at every cell, so that the tiling looks the same from each, and what
// is painted on a face is painted on the same face of all of them. Such a pairing of the cell's
// faces is also a quotient space: the one cell, whose faces are identified in pairs (Thurston,
// Three-dimensional geometry and topology, 1.4).
struct ap_pairing {
    unsigned char turn[AP_CELL_FACES];                // a symmetry of the cell
    unsigned char to[AP_CELL_FACES];                  // the neighbour's face that is the same face
    struct ap_iso cell_from_neighbour[AP_CELL_FACES]; // reflection in the face · turn
    struct ap_iso low[AP_CELL_FACES];                 // what rounding took from it
    bool reverses[AP_CELL_FACES];                     // the neighbour is a mirror image
    // Cycles of edges do not close: a neighbour's frame depends on the way to it, and only what has
    // all the cell's symmetries may be put into the cells.
    bool loose;
};

// One identification: corner k of `face` (as in face_vertex) is corner (turn − k) mod p of `to`,
// or, mirrored, (turn + k) mod p.
struct ap_face_pair {
    int face, to, turn;
    bool mirrored;
};

// From a list that names each face once (a face may be paired with itself). AP_INPUT names the face
// that is missing, named twice or out of range, or not an involution where it is paired with
// itself, and the edge whose cycle does not close to 2·pi. *at is the entry that the sentence is
// about, or −1.
enum ap_status ap_pairing_from_faces(struct ap_error *err, const struct ap_tiling *tiling,
                                     const struct ap_face_pair *pairs, int count, int *at,
                                     struct ap_pairing *pairing);

// Opposite faces by a translation and a turn of twist_rad about it, counterclockwise seen from the
// cell: 0 for the cube's 3-torus, pi/5 for the Poincaré dodecahedral space, 3·pi/5 for the
// Seifert–Weber space. AP_INPUT where that is none.
enum ap_status ap_pairing_opposite(struct ap_error *err, const struct ap_tiling *tiling,
                                   double twist_rad, struct ap_pairing *pairing);

// Every face is a mirror. AP_INPUT where r is odd.
enum ap_status ap_pairing_mirrors(struct ap_error *err, const struct ap_tiling *tiling,
                                  struct ap_pairing *pairing);

// For a tiling: the pairing closest to a translation across each face that fits, by search. Mirrors
// for {5,3,4}, where a cell alone has no other that is known; loose for {3,5,3}, where the search
// gives up. Milliseconds.
void ap_pairing_find(const struct ap_tiling *tiling, struct ap_pairing *pairing);

#endif
