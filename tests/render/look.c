// Draws the billiards room from a place at the table and writes what each eye sees, to be looked
// at: look SPACE native|tourist OUT.png [x y z yaw pitch [size [flags [ipd]]]]. Not a test.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/image/text.h"
#include "tests/render/stage.h"

static double number(int argc, char **argv, int i, double other) {
    return argc > i ? atof(argv[i]) : other;
}

int main(int argc, char **argv) {
    if (argc < 4) {
        fprintf(
            stderr,
            "usage: look SPACE native|tourist OUT.png [x y z yaw pitch [size [flags [ipd]]]]\n");
        return 2;
    }
    struct stage stage;
    struct ap_scene *scene;
    uint32_t size = (uint32_t)number(argc, argv, 9, 700);
    struct ap_scene_params params = {.space_name = argv[1]};
    enum ap_view_mode mode;
    STAGE_CHECK(ap_view_mode_from_name(&stage_error, argv[2], &mode));
    if (strchr(argv[1], '.')) {
        params.space_name = NULL;
        STAGE_CHECK(ap_scene_read(&stage_error, argv[1], &params, &scene));
    } else {
        STAGE_CHECK(ap_scene_billiards(&stage_error, &params, &scene));
    }
    if (!stage_open(&stage, size, size, true))
        return 77;
    struct ap_frame_input input =
        stage_input(scene->space, mode, 0.8, number(argc, argv, 11, 0.064));
    struct ap_vec3 at = {number(argc, argv, 4, 0), number(argc, argv, 5, 0.5),
                         number(argc, argv, 6, 0.9)};
    struct ap_quat yaw =
                       ap_quat_from_axis_angle((struct ap_vec3){0, 1, 0}, number(argc, argv, 7, 0)),
                   pitch = ap_quat_from_axis_angle((struct ap_vec3){1, 0, 0},
                                                   number(argc, argv, 8, -0.5));
    input.viewer.world_from_nose =
        ap_iso_from_pose(scene->space, (struct ap_pose){at, ap_quat_mul(yaw, pitch)});
    for (int h = 0; h < 2; h++) {
        input.hand_tracked[h] = true;
        struct ap_vec3 hand = {h == 0 ? -0.2 : 0.2, -0.25, -0.4};
        input.world_from_hand[h] =
            ap_iso_mul(input.viewer.world_from_nose, ap_iso_translate(scene->space, hand));
    }
    int flags = (int)number(argc, argv, 10, 0); // 1: multiview on a CPU too, 2: no culling
    struct ap_renderer_params how = {.multiview_in_software = flags & 1, .no_cull = flags & 2};
    const char *texts[32];
    struct ap_text_atlas atlas = {0};
    for (size_t i = 0; i < scene->decal_count && i < 32; i++)
        texts[i] = scene->decals[i].text;
    if (scene->decal_count > 0 && scene->decal_count <= 32 &&
        ap_text_atlas_create(NULL, texts, (uint32_t)scene->decal_count, 96, &atlas) == AP_OK) {
        how.decals = atlas.coverage;
        how.decal_px = atlas.cell_px;
        how.decal_count = atlas.count;
    }
    struct ap_renderer *renderer = stage_renderer(&stage, scene, &how);
    ap_text_atlas_finish(&atlas);
    struct ap_frame_stats stats = stage_draw(&stage, renderer, &input);
    printf("%zu parts; left eye: %u draws (%u back), %u culled, %llu triangles, %llu vertices\n",
           scene->part_count, stats.eye[0].draws, stats.eye[0].back_draws, stats.eye[0].culled,
           (unsigned long long)stats.eye[0].triangles, (unsigned long long)stats.eye[0].vertices);
    struct ap_image left = stage_picture(&stage, 0), right = stage_picture(&stage, 1), both;
    STAGE_CHECK(ap_image_side_by_side(&stage_error, &left, &right, &both));
    STAGE_CHECK(ap_png_write(&stage_error, argv[3], &both));
    ap_image_finish(&left);
    ap_image_finish(&right);
    ap_image_finish(&both);
    ap_renderer_destroy(renderer);
    ap_scene_destroy(scene);
    stage_close(&stage);
    return stage.validation_errors != 0;
}
