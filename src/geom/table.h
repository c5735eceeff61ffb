#ifndef ANTIPODE_GEOM_TABLE_H
#define ANTIPODE_GEOM_TABLE_H

#include "src/geom/isometry.h"

// The right-angled regular table of a space: n = 3 in s3, 4 in e3, 5 in h3 (Weeks 2021, section
// 1.3). Edges are numbered counterclockwise seen from above; the midpoint of edge 0 lies toward −z.
struct ap_table_shape {
    struct ap_space space; // with the radius that edge and corner angle fix (s3, h3)
    int sides;
    double edge_m;
    double inradius_m;
    double circumradius_m;
};

// From the edge length; e3 takes rho_m as it is given. Domain edge_m > 0, finite. Relative error of
// each length 8e-16.
struct ap_table_shape ap_table_from_edge(int kappa, double edge_m, double e3_rho_m);

// From the radius of s3 or h3: edge = rho·pi/2, rho·acosh((1+√5)/2).
double ap_table_edge_of_radius(struct ap_space space);

// world_from_edge = rotY(2·pi·(e mod n)/n)·translate(0, 0, −inradius): at the midpoint of edge e,
// −z outward, −x counterclockwise along the edge (seen from above). e may be any integer.
struct ap_iso ap_table_edge_frame(const struct ap_table_shape *table, long long edge);

// Regular polygons in general: circumradius and inradius of a regular `sides`-gon of edge edge_m in
// the space. AP_INPUT where there is none (s3: sides·edge ≥ 2·pi·rho). Relative error 8e-16; in
// s3 1.2e-13 where the edge is within 1e-6 of closing a great circle.
enum ap_status ap_regular_polygon(struct ap_error *err, struct ap_space space, int sides,
                                  double edge_m, double *circumradius_m, double *inradius_m);

#endif
