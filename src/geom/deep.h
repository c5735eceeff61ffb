#ifndef ANTIPODE_GEOM_DEEP_H
#define ANTIPODE_GEOM_DEEP_H

#include "src/geom/fixed.h"
#include "src/geom/pairing.h"

// Isometries of h3 in 256 bits, for a walker whose pose is kept relative to her cell. A rounding of
// size u of an isometry is seen e^d·u large after d·rho more, and e^(2d)·u where it leads off the
// group; so a pose is put back onto the group at each step (ap_deep_renew), and 1e-65 lasts for
// 100 rho with 1e-20 left. Pure; any thread.
struct ap_deep_iso {
    struct ap_fixed m[4][4];
};

struct ap_deep_iso ap_deep_identity(void);

// Entries of both below 2^16 (11.7 rho from the base point).
struct ap_deep_iso ap_deep_mul(const struct ap_deep_iso *a, const struct ap_deep_iso *b);
struct ap_deep_iso ap_deep_inverse(const struct ap_deep_iso *a);

// One step of Newton's iteration onto the group: a defect of 1e-33 becomes 1e-65.
struct ap_deep_iso ap_deep_renew(const struct ap_deep_iso *a);

// Whether its entries are small enough for the functions here.
bool ap_deep_fits(const struct ap_deep_iso *a);

// The nearest doubles, and what is left of each.
void ap_deep_round(const struct ap_deep_iso *a, struct ap_iso *high, struct ap_iso *low);

// translate(p)·rotate(q), (p, q) the motion from one room pose to another in the first one's frame,
// exact for these doubles (quaternions of any length but 0). False: not finite, or more than 11
// rho, or 2^30 metres or rho from the room's origin.
bool ap_deep_between(double rho_m, struct ap_pose room_from_a, struct ap_pose room_from_b,
                     struct ap_deep_iso *motion);

// pairing->cell_from_neighbour of all faces of a tiling of h3, from the mirrors of its simplex
// anew. False in another space.
bool ap_deep_steps(const struct ap_tiling *tiling, const struct ap_pairing *pairing,
                   struct ap_deep_iso step[AP_CELL_FACES]);

#endif
