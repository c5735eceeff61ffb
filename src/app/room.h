#ifndef ANTIPODE_APP_ROOM_H
#define ANTIPODE_APP_ROOM_H

#include "src/app/command.h"
#include "src/image/text.h"
#include "src/render/renderer.h"
#include "src/scene/scene.h"
#include "src/track/tracker.h"
#include "src/view/view.h"
#include "xr/client.h"

// What `replay` and `play` have in common: a scene, the tracker that brings room poses into it, and
// the viewer that the eyes make of the head's virtual pose.

struct ap_room_options {
    const char *table_at; // "X,Z,YAW" in the room whose poses are fed; NULL: they are the table's
    const char *space, *scene, *tracker, *anchor, *view; // NULL: not given
    const char *native_of, *eye;
    double radius_m, table_edge_m, table_height_m; // NAN: not given
    bool side_pockets;
    double max_error_px, samples, budget_mib; // likewise
    bool no_cull;
};

#define AP_ROOM_OPTIONS_NONE                                                                       \
    ((struct ap_room_options){.radius_m = NAN,                                                     \
                              .table_edge_m = NAN,                                                 \
                              .table_height_m = NAN,                                               \
                              .max_error_px = NAN,                                                 \
                              .samples = NAN,                                                      \
                              .budget_mib = NAN})

// A paragraph for --help of a command with these options.
#define AP_ROOM_HELP                                                                               \
    "Scenes with a name, for --scene (docs/honeycombs.md):\n"                                      \
    "  " AP_SCENE_QUOTIENTS "\n"                                                                   \
    "  honeycomb:P,Q,R of " AP_SCENE_SYMBOLS "\n"                                                  \
    "and after the name: " AP_SCENE_WORDS

// The options' table entries, for a command that takes them.
#define AP_ROOM_OPTION_TABLE(o)                                                                    \
    {"space", AP_OPTION_CHOICE, &(o).space, "h3|s3|e3", "the space (default: the scene's, h3)"},   \
        {"radius", AP_OPTION_NUMBER, &(o).radius_m, "M", "its radius in metres"},                  \
        {"view", AP_OPTION_CHOICE, &(o).view, "native|tourist",                                    \
         "each distance as it is, or eyes in the curved space"},                                   \
        {"native-of", AP_OPTION_TEXT, &(o).native_of, "e3|s3|h3[:M]",                              \
         "as seen by somebody born in that space, of radius M (the world's)"},                     \
        {"eye", AP_OPTION_CHOICE, &(o).eye, "left|right|both", "which eyes are open (both)"},      \
        {"tracker", AP_OPTION_CHOICE, &(o).tracker, "billiards|anchor|naive",                      \
         "default billiards with a table, else anchor"},                                           \
        {"anchor", AP_OPTION_TEXT, &(o).anchor, "DEVICE",                                          \
         "of the anchor tracker: head, left, right, hands or a name (head)"},                      \
        {"side-pockets", AP_OPTION_FLAG, &(o).side_pockets, "", "e3: a table of six pockets"},     \
        {"max-error", AP_OPTION_NUMBER, &(o).max_error_px, "PX",                                   \
         "farthest that a surface may be seen from where it is (0.25)"},                           \
        {"samples", AP_OPTION_NUMBER, &(o).samples, "N",                                           \
         "a pixel: 1 (no smooth edges), 4, 16, 64 (4)"},                                           \
        {"budget", AP_OPTION_NUMBER, &(o).budget_mib, "MIB",                                       \
         "memory for what is drawn; detail gives way to it (worlds of cells 512, else 2048)"},     \
        {"no-cull", AP_OPTION_FLAG, &(o).no_cull, "",                                              \
         "draw what no eye can see too: the same pictures, to compare the work"},                  \
        {"scene", AP_OPTION_TEXT, &(o).scene, "FILE|NAME",                                         \
         "a scene (default: the billiards room)"},                                                 \
        {"table-edge", AP_OPTION_NUMBER, &(o).table_edge_m, "M",                                   \
         "edge of the real square table (0.9)"},                                                   \
    {                                                                                              \
        "table-height", AP_OPTION_NUMBER, &(o).table_height_m, "M", "its height (0.75)"            \
    }

struct ap_room {
    struct ap_scene *scene;
    struct ap_tracker *tracker;
    struct ap_tracker_params tracker_params;
    enum ap_view_mode view;
    struct ap_space born;           // of AP_VIEW_BORN
    unsigned closed_eyes;           // bit 0 left, bit 1 right
    struct ap_text_atlas decals;    // of the scene's texts; none where there is no font
    bool has_table;                 // the room has a physical table
    double max_error_px;            // 0: the renderer's default
    uint32_t samples;               // likewise
    bool no_cull;                   // draw what no eye can see too (ap_renderer_params)
    struct ap_deep_iso *deep_steps; // in h3's worlds of cells: across each face (ap_deep_steps)
    int64_t cells_crossed; // in a world of cells: how often the head went on to another one
};

// Command line before scene file before defaults. AP_USAGE or AP_INPUT where they contradict.
enum ap_status ap_room_open(struct ap_error *err, const struct ap_room_options *options,
                            struct ap_room *room);
void ap_room_close(struct ap_room *room);

// What the renderer needs to know of the room: its texts.
void ap_room_renderer_params(const struct ap_room *room, struct ap_renderer_params *params);

// In a world of cells: where the head has left its cell, the world's frame becomes that of the cell
// it is in, for the tracker and for these poses. After all devices of a frame have been placed.
enum ap_status ap_room_follow(struct ap_error *err, struct ap_room *room,
                              struct ap_iso *world_from_head, struct ap_iso world_from_hand[2]);

// To tourist, or from there to native; for any frame.
void ap_room_switch_view(struct ap_room *room);

// Both eyes at the head's virtual pose. Pictures are width×height; an eye whose own part is smaller
// gets a wider frustum, so that its part of the picture has just its own field of view.
struct ap_viewer ap_room_viewer(const struct ap_room *room, struct ap_iso world_from_head,
                                const struct ap_xr_view views[2], uint32_t width_px,
                                uint32_t height_px);

#endif
