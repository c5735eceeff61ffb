#include "src/app/play/session.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/app/play/board.h"
#include "src/app/play/picture.h"
#include "src/base/clock.h"
#include "src/base/log.h"

enum { MENU_WIDTH_PX = 720, MENU_HEIGHT_PX = 960, RATE_WIDTH_PX = 256, RATE_HEIGHT_PX = 48 };

// 30 pictures a second, with what the headset needs for itself.
static const double budget_ms = 28;

struct ap_play {
    struct ap_play_params params;
    struct ap_play_settings settings;
    struct ap_room room;
    struct ap_body body;
    struct ap_play_game *game; // NULL: the balls lie
    struct ap_play_board board;
    struct ap_xr *xr;
    struct ap_gpu gpu;
    struct ap_renderer *renderer;
    uint32_t width_px, height_px; // of the swapchain's images
    uint32_t drawn_width_px, drawn_height_px;
    struct ap_frame_input input;

    struct ap_comfort comfort;
    struct ap_menu menu;
    struct ap_play_panel menu_panel, rate_panel;
    struct ap_pose menu_pose; // in STAGE
    bool menu_was_open, was_down[2], was_clicked, picture_wanted, end_wanted;

    struct ap_detail detail;
    double error_px; // the bound that is drawn with
    int64_t frame_began_ns, rate_began_ns;
    int rate_frames;
    double rate_hz;
    struct ap_play_stats stats;
};

// ---- The room: made anew whenever space, table or tracker change

// What the command line leaves open is as the settings have it. A scene of one's own says for
// itself which space it is in.
static struct ap_room_options room_options(const struct ap_play *play) {
    const struct ap_play_settings *s = &play->settings;
    struct ap_room_options o = play->params.room;
    if (!o.scene && !o.space)
        o.space = ap_play_word(s, AP_PLAY_SPACE);
    if (!o.scene && isnan(o.table_edge_m) && isnan(o.radius_m))
        o.table_edge_m = ap_play_number(s, AP_PLAY_TABLE_EDGE);
    if (!o.tracker && !o.anchor && !o.scene)
        o.tracker = ap_play_word(s, AP_PLAY_WALK);
    if (!o.view && !o.native_of)
        o.view = ap_play_word(s, AP_PLAY_VIEW);
    if (!o.eye)
        o.eye = ap_play_word(s, AP_PLAY_EYE);
    if (!play->params.room.space && strcmp(o.space ? o.space : "", "e3") != 0)
        o.side_pockets = false; // of a table that the menu has changed
    if (isnan(o.max_error_px))
        o.max_error_px = ap_play_number(s, AP_PLAY_ERROR);
    return o;
}

static enum ap_status make_renderer(struct ap_error *err, struct ap_play *play) {
    struct ap_xr_vulkan vk = ap_xr_vulkan(play->xr);
    double scale = ap_detail_scale(&play->detail);
    play->drawn_width_px = (uint32_t)fmax(16, floor(scale * play->width_px));
    play->drawn_height_px = (uint32_t)fmax(16, floor(scale * play->height_px));
    ap_renderer_destroy(play->renderer);
    play->renderer = NULL;
    struct ap_renderer_params render = {.color_format = vk.color_format,
                                        .width = play->drawn_width_px,
                                        .height = play->drawn_height_px,
                                        .no_multiview = !vk.multiview};
    ap_room_renderer_params(&play->room, &render);
    // A bound that was asked for on the command line stands.
    if (isnan(play->params.room.max_error_px))
        render.max_error_px = fmax(render.max_error_px, ap_detail_error_px(&play->detail));
    play->error_px = render.max_error_px;
    if (isnan(play->params.room.samples)) // likewise
        render.samples = ap_detail_samples(&play->detail);
    return ap_renderer_create(err, &play->gpu, play->room.scene, &render, &play->renderer);
}

static void settle(struct ap_play *play) {
    double width_m = 0, depth_m = 0;
    ap_xr_stage_bounds(play->xr, &width_m, &depth_m);
    ap_body_settle(&play->body, &play->settings, width_m, depth_m);
    play->detail.automatic = ap_play_is(&play->settings, AP_PLAY_DETAIL, "auto");
    const char *lines = play->params.lines;
    if (play->game)
        play->game->shows_lines =
            lines ? strcmp(lines, "on") == 0 : ap_play_is(&play->settings, AP_PLAY_LINES, "on");
}

// How a recording is to be seen again; a scene or a tracker of one's own is to be said there, too.
static void write_command(const struct ap_play *play, char *text, size_t size) {
    const struct ap_scene *scene = play->room.scene;
    const char *at = play->params.room.table_at;
    snprintf(
        text, size,
        "antipode replay --space %s --table-edge %.17g%s%s --saved start.json --shots shots.txt "
        "--out pictures poses.csv",
        ap_space_name(scene->space), scene->table_edge_m, at ? " --table-at " : "", at ? at : "");
}

static void close_game(struct ap_play *play) {
    if (play->game)
        play->stats.strikes += play->game->strikes;
    ap_play_game_close(play->game);
    play->game = NULL;
}

// The game that the settings say, on the room's table where it has one. One that cannot be played
// (its rack does not fit) is told, and the balls lie.
static enum ap_status open_game(struct ap_error *err, struct ap_play *play) {
    struct ap_scene *scene = play->room.scene;
    const char *kind =
        play->params.game ? play->params.game : ap_play_word(&play->settings, AP_PLAY_GAME);
    if (strcmp(kind, "none") == 0 || !ap_table_play_is_possible(scene)) {
        if (!play->params.record)
            return AP_OK;
        return ap_fail(err, AP_USAGE, "--record: there is no game to be recorded");
    }
    char command[512];
    write_command(play, command, sizeof command);
    char *path =
        play->params.keep_game ? ap_play_game_path(ap_space_name(scene->space), kind) : NULL;
    const struct ap_play_game_params params = {.scene = scene,
                                               .kind = kind,
                                               .path = path,
                                               .anew = play->params.new_game,
                                               .record = play->params.record,
                                               .command = command};
    enum ap_status st = ap_play_game_open(err, &params, &play->game);
    free(path);
    if (st != AP_INPUT)
        return st;
    ap_log(AP_LOG_WARNING, "no game is played: %s", err->text);
    return AP_OK;
}

static enum ap_status make_room(struct ap_error *err, struct ap_play *play) {
    const struct ap_room_options options = room_options(play);
    struct ap_room room;
    enum ap_status st = ap_room_open(err, &options, &room);
    if (st)
        return st;
    ap_renderer_destroy(play->renderer);
    play->renderer = NULL;
    close_game(play);
    ap_room_close(&play->room);
    play->room = room;
    play->input = (struct ap_frame_input){.viewer.world_from_nose = AP_ISO_IDENTITY};
    st = ap_body_init(err, &play->room, &play->body);
    return st ? st : open_game(err, play);
}

static enum ap_status make_room_anew(struct ap_error *err, struct ap_play *play) {
    if (play->params.record && play->game)
        ap_log(AP_LOG_WARNING, "the recording ends here: the room is made anew");
    play->params.record = NULL;
    play->params.new_game = false;
    enum ap_status st = make_room(err, play);
    if (!st)
        st = make_renderer(err, play);
    settle(play);
    play->stats.rebuilt++;
    return st;
}

// ---- Panels

static enum ap_status draw_menu(struct ap_error *err, struct ap_play *play) {
    struct ap_menu_text text;
    ap_menu_write(&play->menu, &play->settings, &text);
    const struct ap_panel panel = {.size_px = 23,
                                   .padding_px = 24,
                                   .ground_rgba = {14, 20, 32, 235},
                                   .mark_rgba = {40, 96, 160, 255},
                                   .rows = text.rows,
                                   .row_count = text.count};
    enum ap_status st = ap_panel_draw(err, &panel, &play->menu_panel.canvas, NULL);
    return st ? st : ap_play_panel_show(err, &play->menu_panel);
}

// Where she looks when it opens, facing her, its lines level; and there it stays.
static struct ap_pose before(struct ap_pose head) {
    struct ap_vec3 ahead = ap_quat_rotate(head.q, (struct ap_vec3){0, 0, -1});
    double yaw = atan2(-ahead.x, -ahead.z), pitch = asin(fmin(fmax(ahead.y, -1), 1));
    struct ap_quat q = ap_quat_mul(ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, yaw),
                                   ap_quat_from_axis_angle((struct ap_vec3){1, 0, 0}, pitch));
    struct ap_vec3 offset = ap_quat_rotate(q, (struct ap_vec3){0, 0, -0.9});
    return (struct ap_pose){ap_vec3_add(head.p, offset), q};
}

static void place_menu(struct ap_play *play, const struct ap_xr_frame *frame) {
    if (play->menu.open && !play->menu_was_open)
        play->menu_pose = before(frame->head.pose);
    play->menu_was_open = play->menu.open;
    const struct ap_xr_panel_place place = {
        .shown = play->menu.open, .pose = play->menu_pose, .width_m = 0.62, .blended = true};
    ap_xr_panel_set(play->menu_panel.quad, &place);
}

static enum ap_status show_rate(struct ap_error *err, struct ap_play *play) {
    int64_t now = ap_clock_now_ns();
    bool shown = ap_play_is(&play->settings, AP_PLAY_RATE, "on");
    const struct ap_xr_panel_place place = {.shown = shown,
                                            .in_view = true,
                                            .pose = {{-0.2, -0.24, -0.8}, AP_QUAT_IDENTITY},
                                            .width_m = 0.16,
                                            .blended = true};
    ap_xr_panel_set(play->rate_panel.quad, &place);
    play->rate_frames++;
    if (now - play->rate_began_ns < 500000000)
        return AP_OK;
    play->rate_hz = play->rate_frames * 1e9 / (double)(now - play->rate_began_ns);
    play->rate_frames = 0;
    play->rate_began_ns = now;
    if (!shown)
        return AP_OK;
    char text[64];
    snprintf(text, sizeof text, "%.0f fps, %.0f %%", play->rate_hz,
             100 * ap_detail_scale(&play->detail));
    const struct ap_panel_row row = {.cell = {text}};
    const struct ap_panel panel = {.size_px = 28,
                                   .padding_px = 6,
                                   .ground_rgba = {0, 0, 0, 140},
                                   .rows = &row,
                                   .row_count = 1};
    enum ap_status st = ap_panel_draw(err, &panel, &play->rate_panel.canvas, NULL);
    return st ? st : ap_play_panel_show(err, &play->rate_panel);
}

// ---- What the person asks for

static struct ap_menu_input menu_input(const struct ap_xr_frame *frame) {
    const struct ap_xr_hand *l = &frame->hand[0], *r = &frame->hand[1];
    bool left_x = fabsf(l->stick_x) > fabsf(r->stick_x),
         left_y = fabsf(l->stick_y) > fabsf(r->stick_y);
    return (struct ap_menu_input){.stick_x = (double)(left_x ? l->stick_x : r->stick_x),
                                  .stick_y = (double)(left_y ? l->stick_y : r->stick_y),
                                  .press = l->select || r->select || l->primary || r->primary,
                                  .menu = l->menu || r->menu};
}

static void keep_settings(const struct ap_play *play) {
    struct ap_error err;
    if (play->params.settings_path &&
        ap_play_settings_write(&err, play->params.settings_path, &play->settings))
        ap_log(AP_LOG_WARNING, "the settings are not kept: %s", err.text);
}

static void open_eyes(struct ap_play *play) {
    const struct ap_play_settings *s = &play->settings;
    play->room.closed_eyes = ap_play_is(s, AP_PLAY_EYE, "left")    ? 2
                             : ap_play_is(s, AP_PLAY_EYE, "right") ? 1
                                                                   : 0;
}

static enum ap_status take_wish(struct ap_error *err, struct ap_play *play,
                                enum ap_menu_wish wish) {
    enum ap_status st = AP_OK;
    if (wish == AP_MENU_CHANGED || wish == AP_MENU_ANEW) {
        // Chosen in the menu, it stands above the command line.
        play->params.room.view = play->params.room.eye = play->params.room.native_of = NULL;
        play->params.lines = NULL;
        ap_view_mode_from_name(NULL, ap_play_word(&play->settings, AP_PLAY_VIEW), &play->room.view);
        open_eyes(play);
        settle(play);
        keep_settings(play);
    }
    if (wish == AP_MENU_ANEW) {
        play->params.room.space = play->params.room.tracker = play->params.room.anchor = NULL;
        play->params.room.table_edge_m = play->params.room.radius_m = NAN;
        play->params.room.max_error_px = NAN;
        play->params.game = NULL;
        st = make_room_anew(err, play);
    }
    if (wish == AP_MENU_RACK && play->game)
        ap_play_game_rack(play->game);
    if (wish == AP_MENU_UNDO && play->game)
        ap_play_game_undo(play->game);
    play->picture_wanted |= wish == AP_MENU_SCREENSHOT;
    play->end_wanted |= wish == AP_MENU_QUIT;
    if (!st && play->menu.open)
        st = draw_menu(err, play);
    return st;
}

static enum ap_status take_menu(struct ap_error *err, struct ap_play *play,
                                const struct ap_xr_frame *frame) {
    const struct ap_menu_input input = menu_input(frame);
    struct ap_menu was = play->menu;
    enum ap_menu_wish wish = ap_menu_step(&play->menu, &input, &play->settings);
    bool changed = play->menu.open && (!was.open || was.row != play->menu.row);
    enum ap_status st = AP_OK;
    if (wish != AP_MENU_NOTHING)
        st = take_wish(err, play, wish);
    else if (changed)
        st = draw_menu(err, play);
    place_menu(play, frame);
    return st;
}

// The upper button of a hand: the left one's switches the view, the right one's the eyes. The left
// stick pressed: a picture.
static void take_switches(struct ap_play *play, const struct ap_xr_frame *frame) {
    static const unsigned next_closed[4] = {1, 2, 0, 0}; // both open, then only right, only left
    for (int h = 0; h < 2; h++) {
        bool down = frame->hand[h].secondary, pressed = down && !play->was_down[h];
        play->was_down[h] = down;
        if (pressed && h == 0)
            ap_room_switch_view(&play->room);
        else if (pressed)
            play->room.closed_eyes = next_closed[play->room.closed_eyes & 3];
    }
    bool click = frame->hand[0].stick_click;
    play->picture_wanted |= click && !play->was_clicked;
    play->was_clicked = click;
}

// ---- The game

static enum ap_status step_game(struct ap_error *err, struct ap_play *play,
                                const struct ap_xr_frame *frame) {
    struct ap_play_game *g = play->game;
    const struct ap_scene *scene = play->room.scene;
    struct ap_board_text text;
    char aims[80] = "";
    if (g && play->body.head_known)
        ap_play_game_step(g, frame, &play->input, play->menu.open);
    if (g && ap_play_game_aims(g))
        snprintf(aims, sizeof aims, "cue at %.2g m/s, tip %+.2f to the right, %+.2f up",
                 g->aim.speed_m_s, g->aim.right, g->aim.above);
    if (g)
        ap_board_write(&g->table->game, g->says, aims, &text);
    enum ap_status st =
        ap_play_board_step(err, &play->board, g ? &text : NULL, &play->room.tracker_params,
                           scene->table_edge_m, frame->head.pose);
    for (int hand = 0; hand < 2 && g && !st; hand++)
        if (g->pulse[hand] > 0)
            st = ap_xr_haptic(err, play->xr, hand, 0.03, g->pulse[hand]);
    return st;
}

// ---- Frames

static void take_picture(struct ap_play *play, const struct ap_target *target) {
    struct ap_xr_vulkan vk = ap_xr_vulkan(play->xr);
    const struct ap_play_picture picture = {.image = {target->image[0], target->image[1]},
                                            .layer = {target->layer[0], target->layer[1]},
                                            .format = vk.color_format,
                                            .width_px = play->drawn_width_px,
                                            .height_px = play->drawn_height_px};
    const char *folder = play->params.pictures ? play->params.pictures : ".";
    struct ap_error err;
    char name[64];
    play->picture_wanted = false;
    if (ap_play_picture_write(&err, &play->gpu, &picture, folder, name)) {
        ap_log(AP_LOG_WARNING, "no picture: %s", err.text);
        return;
    }
    play->stats.pictures++;
    ap_log(AP_LOG_INFO, "%s/%s", folder, name);
}

static enum ap_status draw(struct ap_error *err, struct ap_play *play, struct ap_xr_frame *frame) {
    struct ap_xr_images images;
    enum ap_status st = ap_xr_acquire(err, play->xr, &images);
    if (st)
        return st;
    // A share of the pixels: the same share of each eye's part.
    double scale = ap_detail_scale(&play->detail);
    for (int e = 0; e < 2; e++) {
        struct ap_xr_view *v = &frame->view[e];
        v->width_px = (uint32_t)fmin(play->drawn_width_px, floor(scale * v->width_px));
        v->height_px = (uint32_t)fmin(play->drawn_height_px, floor(scale * v->height_px));
    }
    play->input.viewer = ap_room_viewer(&play->room, play->input.viewer.world_from_nose,
                                        frame->view, play->drawn_width_px, play->drawn_height_px);
    play->input.plain = ap_detail_plain(&play->detail);
    unsigned shut = play->room.closed_eyes | (play->params.one_eye ? 2u : 0u);
    play->input.closed_eyes = play->picture_wanted ? 0 : shut == 3 ? 2 : shut;
    const struct ap_target target = {.image = {images.image[0], images.image[1]},
                                     .layer = {images.layer[0], images.layer[1]}};
    struct ap_frame_stats stats;
    play->stats.drawn++;
    st = ap_renderer_draw(err, play->renderer, &play->input, &target, &stats);
    if (!st && play->picture_wanted)
        take_picture(play, &target);
    return st;
}

void ap_play_say_detail(const struct ap_play *play) {
    printf("detail: %u x %u of %u x %u pixels an eye, error bound %g px%s%s%s\n",
           play->drawn_width_px, play->drawn_height_px, play->width_px, play->height_px,
           play->error_px, ap_detail_plain(&play->detail) ? ", plain surfaces" : "",
           isnan(play->params.room.samples) && ap_detail_samples(&play->detail) == 1
               ? ", edges with steps"
               : "",
           play->detail.automatic ? ", chosen for 30 frames a second" : "");
    fflush(stdout);
}

// How long the frame took from being begun to being handed over; the wait for the display is not
// work.
static enum ap_status watch_detail(struct ap_error *err, struct ap_play *play) {
    double frame_ms = (double)(ap_clock_now_ns() - play->frame_began_ns) * 1e-6;
    if (!ap_detail_step(&play->detail, frame_ms))
        return AP_OK;
    enum ap_status st = make_renderer(err, play);
    ap_play_say_detail(play);
    return st;
}

static enum ap_status step(struct ap_error *err, struct ap_play *play) {
    struct ap_xr_frame frame;
    enum ap_status st = ap_xr_begin_frame(err, play->xr, &frame);
    if (st)
        return st;
    play->frame_began_ns = ap_clock_now_ns();
    st = take_menu(err, play, &frame);
    if (!play->menu.open)
        take_switches(play, &frame);
    if (!st)
        st = ap_body_step(err, &play->body, &frame,
                          play->menu.open || (play->game && ap_play_game_aims(play->game)),
                          &play->input);
    if (!st)
        st = step_game(err, play, &frame);
    if (!st)
        st = ap_comfort_step(err, &play->comfort, play->body.fade, play->body.vignette);
    if (!st)
        st = show_rate(err, play);
    // Until the head has been seen once there is nowhere to look from.
    bool draws = frame.should_render && play->body.head_known;
    if (!st && draws)
        st = draw(err, play, &frame);
    play->stats.frames++;
    if (!st)
        st = ap_xr_end_frame(err, play->xr, &frame);
    return st || !draws ? st : watch_detail(err, play);
}

enum ap_status ap_play_run(struct ap_error *err, struct ap_play *play, bool (*end_asked)(void),
                           int64_t end_ns) {
    bool asked = false;
    for (;;) {
        enum ap_status st = AP_OK;
        if (!asked && (end_asked() || play->end_wanted || ap_clock_now_ns() >= end_ns)) {
            asked = true;
            st = ap_xr_request_exit(err, play->xr);
        }
        enum ap_xr_state state = AP_XR_WAITING;
        if (!st)
            st = ap_xr_poll(err, play->xr, &state);
        if (st || state == AP_XR_ENDED)
            return st;
        if (state == AP_XR_LOST)
            return ap_fail(err, AP_ENVIRONMENT, "%s: the session was lost",
                           ap_xr_runtime_name(play->xr));
        if (state == AP_XR_WAITING)
            ap_clock_sleep_until_ns(ap_clock_now_ns() + 5000000);
        else
            st = step(err, play);
        if (st)
            return st;
    }
}

// ---- Life

static enum ap_status open_headset(struct ap_error *err, struct ap_play *play) {
    const struct ap_xr_params params = {.application = "antipode",
                                        .older_vulkan = play->params.older_vulkan};
    enum ap_status st = ap_xr_create(err, &params, &play->xr);
    if (st)
        return st;
    struct ap_xr_vulkan vk = ap_xr_vulkan(play->xr);
    play->width_px = vk.width_px;
    play->height_px = vk.height_px;
    printf("%s, %s, %u x %u an eye\n", ap_xr_runtime_name(play->xr), ap_xr_system_name(play->xr),
           vk.width_px, vk.height_px);
    fflush(stdout);
    if (!ap_xr_has_stage(play->xr))
        ap_log(AP_LOG_WARNING, "the runtime has no STAGE space: set up its room, or the floor and "
                               "the table will not be where they are");
    return ap_gpu_init(err, vk.instance, vk.physical_device, vk.device, vk.queue_family, 0,
                       &play->gpu);
}

static enum ap_status make_panels(struct ap_error *err, struct ap_play *play) {
    enum ap_status st = ap_play_board_create(err, play->xr, &play->gpu, &play->board);
    if (!st)
        st = ap_play_panel_create(err, play->xr, &play->gpu, MENU_WIDTH_PX, MENU_HEIGHT_PX,
                                  &play->menu_panel);
    if (!st)
        st = ap_play_panel_create(err, play->xr, &play->gpu, RATE_WIDTH_PX, RATE_HEIGHT_PX,
                                  &play->rate_panel);
    return st ? st : ap_comfort_create(err, play->xr, &play->gpu, &play->comfort);
}

enum ap_status ap_play_open(struct ap_error *err, const struct ap_play_params *params,
                            struct ap_play **out) {
    struct ap_play *play = calloc(1, sizeof *play);
    if (!play)
        return ap_fail(err, AP_ENVIRONMENT, "out of memory");
    play->params = *params;
    play->settings = params->settings;
    play->rate_began_ns = ap_clock_now_ns();
    ap_detail_init(&play->detail, true, budget_ms);
    enum ap_status st = make_room(err, play);
    if (!st)
        st = open_headset(err, play);
    if (!st)
        st = make_panels(err, play);
    if (!st) {
        settle(play);
        st = make_renderer(err, play);
    }
    if (st)
        ap_play_close(play);
    else
        *out = play;
    return st;
}

void ap_play_close(struct ap_play *play) {
    if (!play)
        return;
    close_game(play);
    ap_play_board_destroy(&play->board);
    ap_renderer_destroy(play->renderer);
    ap_comfort_destroy(&play->comfort);
    ap_play_panel_destroy(&play->menu_panel);
    ap_play_panel_destroy(&play->rate_panel);
    if (play->gpu.device)
        ap_gpu_finish(&play->gpu);
    ap_xr_destroy(play->xr);
    ap_room_close(&play->room);
    free(play);
}

struct ap_play_stats ap_play_stats(const struct ap_play *play) {
    struct ap_play_stats stats = play->stats;
    stats.strikes += play->game ? play->game->strikes : 0;
    return stats;
}
