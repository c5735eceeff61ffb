#ifndef ANTIPODE_RENDER_REFINE_REFINE_STICK_H
#define ANTIPODE_RENDER_REFINE_REFINE_STICK_H

#include "src/render/refine/refine_surface.h"

// Where refining a stick begins: rings along its axis and corners around it, as many as an edge
// along it and one around it need, each for itself. Cutting in halves both ways at once would end
// up to twice as fine as either asks for.

enum { AP_STICK_RINGS = 97, AP_STICK_AROUND = 96 };

struct ap_stick_grid {
    double along[AP_STICK_RINGS]; // over rho, of the middle; both ends are there
    int rings;                    // at least 2
    int around;                   // 8 or more
};

// edge_px: how far off an edge may be, the sum of one along and one around. It is not promised:
// refining looks at every edge. Where nothing of the stick is in the picture its rings are far
// apart.
struct ap_stick_grid ap_stick_grid_of(const struct ap_surface *surface, const struct ap_eyes *eyes,
                                      double edge_px);

#endif
