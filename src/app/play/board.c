#include "src/app/play/board.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { WIDTH_PX = 1000, HEIGHT_PX = 340 };

static const double width_m = 1.2, beyond_m = 0.5, above_m = 0.55;
static const double quarter_rad = 1.5707963267948966;

enum ap_status ap_play_board_create(struct ap_error *err, struct ap_xr *xr,
                                    const struct ap_gpu *gpu, struct ap_play_board *board) {
    *board = (struct ap_play_board){.drawn = false};
    return ap_play_panel_create(err, xr, gpu, WIDTH_PX, HEIGHT_PX, &board->panel);
}

void ap_play_board_destroy(struct ap_play_board *board) {
    ap_play_panel_destroy(&board->panel);
}

static int left_of(const struct ap_game *g, int from, int to) {
    int n = 0;
    for (int i = from; i <= to && i < g->physics.ball_count; i++)
        n += g->physics.ball[i].state != AP_BALL_POCKETED;
    return n;
}

static void write_score(const struct ap_game *g, char *line) {
    const struct ap_rules *r = &g->rules;
    int n = snprintf(line, AP_GAME_TEXT_MAX, "shot %d", g->shots + (g->shooting ? 0 : 1));
    for (int p = 0; p < 2 && r->phase == AP_PHASE_GROUPS; p++) {
        bool solids = r->group[p] == AP_GROUP_SOLIDS;
        n += snprintf(line + n, (size_t)(AP_GAME_TEXT_MAX - n), "   player %d: %s, %d left", p + 1,
                      solids ? "solids" : "stripes", solids ? left_of(g, 1, 7) : left_of(g, 9, 15));
    }
    if (r->phase != AP_PHASE_GROUPS)
        n += snprintf(line + n, (size_t)(AP_GAME_TEXT_MAX - n), "   %d balls on the table",
                      left_of(g, 1, AP_BALLS_MAX - 1));
    for (int p = 0; p < 2 && r->kind == AP_GAME_NINE; p++)
        if (r->fouls[p] > 0)
            n += snprintf(line + n, (size_t)(AP_GAME_TEXT_MAX - n), "   player %d: %d foul%s",
                          p + 1, r->fouls[p], r->fouls[p] == 1 ? "" : "s");
}

void ap_board_write(const struct ap_game *game, const char *says, const char *aims,
                    struct ap_board_text *text) {
    static const struct ap_board_text nothing;
    *text = nothing;
    ap_game_text(game, text->line[0]);
    char *verdict = strstr(text->line[0], "; ");
    if (verdict)
        *verdict = '\0';
    if (game->shooting)
        snprintf(text->line[1], AP_GAME_TEXT_MAX, "the balls roll");
    else if (game->rules.winner >= 0)
        snprintf(text->line[1], AP_GAME_TEXT_MAX, "a new rack: in the menu");
    else if (game->verdict.what[0])
        snprintf(text->line[1], AP_GAME_TEXT_MAX, "last shot: %s%s", game->verdict.what,
                 game->verdict.foul ? " (foul)" : "");
    write_score(game, text->line[2]);
    snprintf(text->line[3], AP_GAME_TEXT_MAX, "%s", says);
    snprintf(text->line[4], AP_GAME_TEXT_MAX, "%s", aims);
}

static enum ap_status draw(struct ap_error *err, struct ap_play_board *board) {
    static const char *const controls[] = {
        "strike with the cue in both hands; or aim it:",
        "hold the right squeeze (mouse: right button) and look where the ball is to go",
        "right trigger (left button): strike     right stick (wheel): how fast",
        "left stick (I J K L): where the tip meets     A (C): put the ball in hand",
        "menu (M): new rack, take back, path of the next shot",
    };
    enum { CONTROLS = sizeof controls / sizeof *controls };
    struct ap_panel_row rows[6 + CONTROLS] = {{.cell = {board->shown.line[0]}, .heading = true}};
    size_t n = 1;
    for (int i = 1; i < 5; i++)
        rows[n++] = (struct ap_panel_row){.cell = {board->shown.line[i]}};
    rows[3].rgb[0] = 255; // what was refused
    rows[3].rgb[1] = rows[3].rgb[2] = 130;
    for (int i = 0; i < CONTROLS; i++)
        rows[n++] = (struct ap_panel_row){.cell = {controls[i]}, .rgb = {150, 160, 175}};
    const struct ap_panel panel = {.size_px = 26,
                                   .padding_px = 20,
                                   .ground_rgba = {10, 18, 28, 205},
                                   .rows = rows,
                                   .row_count = n};
    enum ap_status st = ap_panel_draw(err, &panel, &board->panel.canvas, NULL);
    return st ? st : ap_play_panel_show(err, &board->panel);
}

int ap_board_side(const struct ap_tracker_params *room, struct ap_pose head, int present) {
    double x = head.p.x - room->table_x_m, z = head.p.z - room->table_z_m;
    if (!isfinite(x + z) || hypot(x, z) < 0.1)
        return present;
    // Side 0 lies toward −z: across from a head at +z.
    double across = atan2(x, z) - room->table_yaw_rad;
    double off = remainder(across - present * quarter_rad, 4 * quarter_rad);
    if (fabs(off) < 0.66 * quarter_rad)
        return present;
    return ((int)lround(across / quarter_rad) % 4 + 4) % 4;
}

struct ap_pose ap_board_pose(const struct ap_tracker_params *room, double edge_m, int side) {
    struct ap_quat q = ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0},
                                               room->table_yaw_rad + side * quarter_rad);
    struct ap_vec3 out = ap_quat_rotate(q, (struct ap_vec3){0, 0, -(edge_m / 2 + beyond_m)});
    struct ap_vec3 middle = {room->table_x_m, room->table_height_m + above_m, room->table_z_m};
    return (struct ap_pose){ap_vec3_add(middle, out), q};
}

enum ap_status ap_play_board_step(struct ap_error *err, struct ap_play_board *board,
                                  const struct ap_board_text *text,
                                  const struct ap_tracker_params *room, double edge_m,
                                  struct ap_pose room_from_head) {
    board->side = ap_board_side(room, room_from_head, board->side);
    const struct ap_xr_panel_place place = {.shown = text != NULL,
                                            .pose = ap_board_pose(room, edge_m, board->side),
                                            .width_m = width_m,
                                            .blended = true};
    ap_xr_panel_set(board->panel.quad, &place);
    if (!text || (board->drawn && memcmp(text, &board->shown, sizeof *text) == 0))
        return AP_OK;
    board->shown = *text;
    board->drawn = true;
    return draw(err, board);
}
