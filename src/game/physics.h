#ifndef ANTIPODE_GAME_PHYSICS_H
#define ANTIPODE_GAME_PHYSICS_H

#include <stdbool.h>

#include "src/base/status.h"
#include "src/game/plane.h"
#include "src/geom/table.h"

// Billiards on the plane of the table, event by event: between two events every ball moves by a
// formula, and the next event is the first root of all that may happen, bracketed from below so
// that none is missed. The model, its constants and what it leaves out: docs/physics.md.
//
// Coordinates: the world's (base point at the table's centre, y up). A ball is known by its foot,
// the point of the table's plane below it. Seconds since the balls were set; metres, radians,
// kilograms. Plain data, no memory to release, nothing allocated; one thread at a time; the same
// bits on every run, however the time is cut into ap_physics_advance.

enum {
    AP_BALLS_MAX = 16,
    AP_EDGES_MAX = 5,
    AP_POCKETS_MAX = 8,
    AP_SERIES_MAX = 40,
    AP_TOLD_MAX = 96
};

// Zero means the default in brackets; to switch something off, say a negative number.
struct ap_physics_params {
    double ball_radius_m;       // 0.028575, or what fits a small table (ap_physics_ball_radius)
    double ball_mass_kg;        // 0.17
    double gravity_m_s2;        // 9.81
    double slide_friction;      // 0.2
    double roll_friction;       // 0.01
    double spin_friction;       // 0.0127, times (5/2)·g/R is how fast vertical spin goes
    double ball_restitution;    // 0.95
    double ball_friction;       // 0.05
    double cushion_restitution; // 0.85
    double cushion_friction;    // 0.2
    double cushion_m; // 0.025, or 0.07·inradius: from the table's edge in to the cushion's nose
    double pocket_radius_m; // how near its middle a foot falls in; √2·(cushion + s) + s, s the
                            // ball's radius: the mouth that the room shows
    double cue_mass_kg;     // 0.54
    double tip_restitution; // 0.75
    bool no_pockets;
    bool side_pockets; // e3: two more, at the middles of edges 1 and 3
    bool no_cushions;  // s3 only: the whole sphere is the table
};

enum ap_ball_state {
    AP_BALL_AT_REST,
    AP_BALL_SPINNING, // on the spot
    AP_BALL_ROLLING,
    AP_BALL_SLIDING,
    AP_BALL_POCKETED, // in pocket `pocket`, or not in play (pocket −1)
};

// From t0_s on, until t_end_s or something happens to it.
struct ap_ball {
    enum ap_ball_state state;
    int pocket;
    double t0_s, t_end_s;
    struct ap_plane_frame world_from_foot;            // at t0_s; carried along in parallel
    struct ap_plane2 velocity_m_s, acceleration_m_s2; // of the foot, in its frame
    // The rate of turn at the point of contact, in the foot's frame (x, y up, z): the body's motion
    // is `slip` there and this turn about it. Rolling: |turn| = |V|/R, R = rho·tanh(s/rho) in h3.
    struct ap_vec3 turn_rad_s, turn_rate_rad_s2;
    struct ap_quat foot_from_ball; // at t0_s
    // Where it is at t: along a straight line, or by a series in t − t0 (a curved slide).
    bool straight;
    struct ap_plane2 along;
    int terms;
    double series[AP_SERIES_MAX][12]; // row by row; the last three are nothing
};

enum ap_physics_kind {
    AP_EVENT_NONE,
    AP_EVENT_BALLS,   // a and b meet
    AP_EVENT_CUSHION, // a meets the cushion of edge b
    AP_EVENT_POCKET,  // a falls into pocket b
    AP_EVENT_ROLL,    // a slides no more
    AP_EVENT_STOP,    // a comes to rest, but for spin on the spot
    AP_EVENT_STRIKE,
};

struct ap_physics_event {
    double t_s;
    enum ap_physics_kind kind;
    int a, b;         // −1 where there is none
    double speed_m_s; // of approach
};

struct ap_physics_counters {
    unsigned long long events, tries, rounds; // tries: lower bounds made better
};

struct ap_physics {
    struct ap_physics_params params; // every default filled in
    struct ap_table_shape shape;
    int ball_count, edge_count, pocket_count;
    double now_s, changed_s; // when something last began to move otherwise
    struct ap_ball ball[AP_BALLS_MAX];
    // Derived, all in metres: R = rho·tan_kappa(s/rho); the least foot distance from an edge and
    // its rho·sin_kappa; chords² of contact, capture and the longest on the table;
    // the longest rho·sin_kappa of a distance on it; the largest cos_kappa of one to an edge.
    double rolling_radius_m, edge_distance_m, edge_height_m;
    double touch_m2, capture_m2, longest_m2, lever_m, edge_lever;
    struct ap_plane3 edge[AP_EDGES_MAX]; // plain dot product with a foot: rho·sin_kappa(distance)
    struct ap_plane3 pocket[AP_POCKETS_MAX];
    // The queue: before key[i][j] nothing happens between i and j (j > i), i and a cushion, i and a
    // pocket. Rows' least values.
    double pair_s[AP_BALLS_MAX][AP_BALLS_MAX], cushion_s[AP_BALLS_MAX], pocket_s[AP_BALLS_MAX];
    double row_s[AP_BALLS_MAX];
    // Of the moment, not handed out yet.
    struct ap_physics_event told[AP_TOLD_MAX];
    int told_count, told_next;
    struct ap_physics_counters counters;
};

// An empty table. AP_USAGE: a number that is not finite, a ball too large for the table (in s3 also
// rho·pi/4 and more), pockets that swallow the table.
enum ap_status ap_physics_init(struct ap_error *err, const struct ap_table_shape *shape,
                               const struct ap_physics_params *params, struct ap_physics *physics);

// 0.028575 m, or 0.0835·inradius on a table that is too small for fifteen of them.
double ap_physics_ball_radius(const struct ap_table_shape *shape);

// Sets a ball at rest at exp(x, 0, z). AP_INPUT: not on the table, in a pocket's mouth, or over
// another ball (whose number the sentence says; `ball` itself is not looked at).
enum ap_status ap_physics_place(struct ap_error *err, struct ap_physics *physics, int ball,
                                struct ap_plane2 at_m);

// Without the checks, and with any motion: for tests and saved games.
void ap_physics_set(struct ap_physics *physics, int ball, const struct ap_plane_frame *foot,
                    struct ap_plane2 velocity_m_s, struct ap_vec3 turn_rad_s,
                    struct ap_quat foot_from_ball);

// Takes a ball off the table.
void ap_physics_remove(struct ap_physics *physics, int ball);

// A stroke of the cue. The tip meets the ball at (right, above) of its centre, in ball radii,
// across the cue's line; the cue goes to `direction`, a tangent vector at the ball's foot in world
// coordinates, inclined by elevation_rad.
struct ap_strike {
    struct ap_plane3 direction;
    double speed_m_s; // of the cue just before
    double right, above;
    double elevation_rad;
};

// AP_INPUT: not finite, no direction, speed ≤ 0 or above 20 m/s, |offset| > 0.55 (the tip would
// slip off), elevation outside 0…1.4; the ball not in play.
enum ap_status ap_physics_strike(struct ap_error *err, struct ap_physics *physics, int ball,
                                 const struct ap_strike *strike);

// The direction whose geodesic from ball a's foot leads over ball b's foot (over a point of the
// plane; zero where that is the foot itself); and an angle
// counterclockwise from above, 0 along the world's −z carried in parallel from the centre.
struct ap_plane3 ap_physics_toward(const struct ap_physics *physics, int a, int b);
struct ap_plane3 ap_physics_toward_point(const struct ap_physics *physics, int ball,
                                         struct ap_plane3 point_m);
struct ap_plane3 ap_physics_heading(const struct ap_physics *physics, int ball, double angle_rad);

// Goes to the next event at or before until_s, does it and tells it; false: none, now_s is until_s.
bool ap_physics_next(struct ap_physics *physics, double until_s, struct ap_physics_event *event);

// Goes to until_s; `seen`, where given, is told every event.
void ap_physics_advance(struct ap_physics *physics, double until_s,
                        void (*seen)(void *data, const struct ap_physics_event *event), void *data);

// No ball in play moves or spins.
bool ap_physics_at_rest(const struct ap_physics *physics);

// A ball's foot and motion at t_s, between its t0_s and t_end_s (held to them); world coordinates.
struct ap_ball_motion {
    struct ap_plane3 foot_m, velocity_m_s;
    struct ap_plane3 rolling_rad_s; // turn × up, a tangent vector: it rolls where V = R·rolling
    double spin_rad_s;              // turn about up
};
struct ap_ball_motion ap_physics_motion(const struct ap_physics *physics, int ball, double t_s);

// world_from_ball at now_s: its centre stands s above the foot; orthonormal to 1e-15.
struct ap_iso ap_physics_world_from_ball(const struct ap_physics *physics, int ball);

// foot_from_ball at now_s.
struct ap_quat ap_physics_turn(const struct ap_physics *physics, int ball);

// Joules, of all balls in play. And what the isometries of the plane conserve without friction or
// cushions, m·(foot ∧ velocity): about the world's x, z (over rho, in kg·m/s) and y (kg·m²/s).
double ap_physics_energy(const struct ap_physics *physics);
void ap_physics_momentum(const struct ap_physics *physics, double about[3]);

// What would happen, for practice: plays a copy on until rest (or limit_s) and calls `point` with
// the feet of the moving balls, at events and at every step_m of way between: exact points of the
// way. `ball` is the number, `event` the event that the point belongs to or NULL.
struct ap_path_sink {
    void *data;
    void (*point)(void *data, int ball, double t_s, struct ap_plane3 foot_m,
                  const struct ap_physics_event *event);
};
void ap_physics_path(const struct ap_physics *physics, double limit_s, double step_m,
                     const struct ap_path_sink *sink);

#endif
