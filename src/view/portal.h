#ifndef ANTIPODE_VIEW_PORTAL_H
#define ANTIPODE_VIEW_PORTAL_H

#include "src/geom/cells.h"
#include "src/view/view.h"
#include "src/view/window.h"

// Which cells of a tiling can be seen, found by walking outward from the cell of the nose through
// the faces that an eye may see: the cost grows with what is seen, not with what exists. An eye's
// line of sight leaves a cell through a point of a face that this eye sees, so whatever is seen is
// reached through faces that are in its view (exact for each eye, native and tourist: nothing of it
// depends on lines being geodesics; native-of view sees all cells). A face is out of view where one
// side of an eye's pyramid, moved to the nose and leaned outward by asin(e/d), e the side's
// distance from the nose and d the cell's, has all its corners behind it.
//
// Where walls are opaque, a line of sight goes through a window in each of them: each cell has the
// part of each eye's picture that it can be seen in, a box about all ways to it, and what no eye's
// box reaches is left out. From the nose a window is a convex cone; an eye sees each of its points
// within asin(e/d) of that.
//
// A cell is nearer than the neighbour across a face that one looks through (the face lies half way
// between their centres), so that the walk may end at a distance: the horizon.

struct ap_seen_cell {
    int32_t cell;
    int image;              // 0; 1: the long way round s3
    unsigned within;        // bit e: all of it lies in eye e's view; its contents need no test
    unsigned eyes;          // that may see any of it
    struct ap_gaze gaze[2]; // each eye's, as far as the windows on the way let it in
    struct ap_iso nose_from_cell;
    bool reverses;        // nose_from_cell mirrors
    double distance_m;    // of its centre from the nose (image 0's, also for image 1)
    double near_m, far_m; // its points' distances lie between
    int growths;          // private
    bool again;
};

struct ap_portal_params {
    const struct ap_viewer *viewer; // world: the frame of cell 0
    double horizon_m;               // cells whose centre is farther are not drawn; INFINITY in s3
    size_t most_cells;              // 0: no bound but the graph's
    // Where walls are opaque: the corners of the window in each face (cell's frame), convex and in
    // the face's plane; NULL: faces are open. What is seen of a window's rim may be slack_rad off.
    const struct ap_window *window;
    double slack_rad;
    bool no_cull; // all cells within the horizon, seen or not: for tests
};

struct ap_portal_stats {
    uint32_t visited; // cells·images that are drawn
    uint32_t cone;    // cells·images met across a face that no eye sees, and by no other way
    uint32_t walls;   // met across a face in view whose window is not, and by no other way
    uint32_t size;    // beyond the horizon
    uint32_t budget;  // left out, for there were too many
};

// Grows; zero-initialised it is empty. One thread.
struct ap_portal {
    struct ap_seen_cell *seen; // in the order of the walk: the nose's cell first
    size_t count, room;
    uint32_t *stamp[2], *place[2]; // private, by cell
    size_t stamp_room;
    uint32_t frame;
};
void ap_portal_finish(struct ap_portal *portal);

// AP_ENVIRONMENT only without memory for the first cells.
enum ap_status ap_portal_walk(struct ap_error *err, struct ap_cells *cells,
                              const struct ap_portal_params *params, struct ap_portal *portal,
                              struct ap_portal_stats *stats);

// The distance beyond which a ball of radius_m is seen under less than half_angle_rad; INFINITY in
// s3, where nothing is small for being far.
double ap_horizon_m(struct ap_space space, double radius_m, double half_angle_rad);

// The sides of both eyes' pyramids, to test balls against: the eyes (bits) that may see any of one.
struct ap_sides {
    bool tourist;
    struct ap_iso eye_from_nose[2]; // tourist
    struct ap_vec3 normal[2][4];    // unit, inward; in the nose's axes (native) or the eye's
    double offset_m[2][4];          // n·apex
    double eye_m;                   // the farther eye's distance from the nose
};
struct ap_sides ap_sides_of(const struct ap_viewer *viewer);

// The ball about `centre` (nose space, metres), seen in an image. Conservative.
unsigned ap_sides_see_ball(const struct ap_sides *sides, struct ap_space space,
                           struct ap_vec4 centre, double radius_m, int image);

#endif
