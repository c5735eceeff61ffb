#ifndef ANTIPODE_APP_PLAY_BOARD_H
#define ANTIPODE_APP_PLAY_BOARD_H

#include "src/app/play/panel.h"
#include "src/game/game.h"
#include "src/track/tracker.h"

// The board with score, turn and what is to be hit: a panel that stands in the room beyond the edge
// of the table that is farthest from the player.

struct ap_board_text {
    char line[5][AP_GAME_TEXT_MAX]; // turn; last shot; score; what was refused; what is aimed
};

struct ap_play_board {
    struct ap_play_panel panel;
    struct ap_board_text shown;
    bool drawn;
    int side; // of the four
};

enum ap_status ap_play_board_create(struct ap_error *err, struct ap_xr *xr,
                                    const struct ap_gpu *gpu, struct ap_play_board *board);
void ap_play_board_destroy(struct ap_play_board *board);

// What stands on it; `says` and `aims` may be "".
void ap_board_write(const struct ap_game *game, const char *says, const char *aims,
                    struct ap_board_text *text);

// Which side of the table it stands at (0 toward the table's −z, counterclockwise from above): the
// one across from the head, but for the present one as long as that is nearly across.
int ap_board_side(const struct ap_tracker_params *room, struct ap_pose room_from_head, int present);

// Its middle in STAGE, for a table of this edge; +z toward the table.
struct ap_pose ap_board_pose(const struct ap_tracker_params *room, double edge_m, int side);

// A frame; draws only what changed. text NULL: there is no game, nothing is shown.
enum ap_status ap_play_board_step(struct ap_error *err, struct ap_play_board *board,
                                  const struct ap_board_text *text,
                                  const struct ap_tracker_params *room, double edge_m,
                                  struct ap_pose room_from_head);

#endif
