#include "tests/render/closed_world.h"

#include <string.h>

#include "src/scene/honeycomb.h"
#include "tests/render/stage.h"

struct ap_scene *closed_world(const char *name) {
    const struct ap_scene_params none = {0};
    struct ap_scene *scene;
    STAGE_CHECK(ap_scene_named(&stage_error, name, &none, &scene));
    struct ap_honeycomb *h = scene->honeycomb;
    for (int k = 0; k < scene->parts[0].solid_levels; k++) {
        struct ap_solid *solid = &scene->solids[scene->parts[0].solid + k];
        struct ap_mesh mesh = {0}, old = {.solid = *solid};
        double longest_m;
        ap_mesh_wall(&h->tiling, 1, 1 << k, &mesh, &longest_m);
        mesh.solid.longest_m = longest_m;
        *solid = mesh.solid;
        ap_mesh_finish(&old);
    }
    for (int f = 0; f < h->tiling.face_count; f++)
        h->window[f] = ap_wall_window(&h->tiling, f, 0.999);
    for (size_t i = 0; i < scene->part_count; i++) {
        const double grey[3] = {0.2, 0.2, 0.2};
        scene->parts[i].lit = false;
        memcpy(scene->parts[i].color_srgb, grey, sizeof grey);
    }
    scene->background_srgb[0] = scene->background_srgb[1] = scene->background_srgb[2] = 1;
    return scene;
}
