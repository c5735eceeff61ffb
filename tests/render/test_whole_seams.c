// Seams of pieces of a world of cells that a part's, or a cell's, place says need no cut
// (ap_level.whole_seams) are judged no other by themselves, so that asking once changes no picture:
// random parts near and far, turned in any way, all spaces, native and tourist. `test_whole_seams
// N` takes N a world.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "src/geom/map.h"
#include "src/render/refine/seam.h"
#include "tests/render/exact.h"
#include "tests/render/stage.h"

static struct exact_random random_of = {17};

struct tally {
    long parts, whole, wrong;
};

// A part, its middle within reach of all that is drawn, and what is known of its place: its own, or
// a cell's that it lies in.
static void try_part(const struct ap_scene *scene, const struct ap_meshes *meshes, int i,
                     struct tally *t) {
    size_t index = (size_t)i % scene->part_count;
    const struct ap_part *part = &scene->parts[index];
    const struct ap_shape *shape = &meshes->shapes[meshes->shape_of_part[index]];
    struct ap_space space = scene->space;
    double rho = space.rho_m, most = space.kappa > 0 ? 3.1 : space.kappa < 0 ? 7 : 40;
    struct ap_viewer viewer =
        exact_viewer(&random_of, space.kappa, i % 5 == 4 ? AP_VIEW_TOURIST : AP_VIEW_NATIVE);
    viewer.space = space;
    struct ap_eyes eyes = ap_eyes_of(&viewer, 1440, 1600);
    struct ap_vec3 way = {exact_uniform(&random_of, -1, 1), exact_uniform(&random_of, -1, 1),
                          exact_uniform(&random_of, -1, 1)};
    double d = rho * most * exact_uniform(&random_of, 0.02, 1);
    struct ap_quat q = {exact_uniform(&random_of, -1, 1), exact_uniform(&random_of, -1, 1),
                        exact_uniform(&random_of, -1, 1), exact_uniform(&random_of, -1, 1)};
    way = ap_vec3_scale(d, ap_vec3_normalize(way));
    double reach_m = meshes->reach_m[index], px = 0.02 * pow(200, exact_uniform(&random_of, 0, 1));
    int image = space.kappa > 0 && i % 2;
    struct ap_place place = {.reach_m = reach_m};
    place.nose_from_part =
        ap_iso_mul(ap_iso_translate(space, way), ap_iso_rotate(ap_quat_normalize(q)));
    if (i % 3 == 0) { // a cell's
        place.anywhere = true;
        place.reach_m = 1.5 * reach_m;
    }
    place.near_m = fmax(d - place.reach_m, 0);
    place.far_m = space.kappa > 0 ? fmin(d + place.reach_m, 3.14159 * rho) : d + place.reach_m;
    struct ap_level level;
    struct ap_seam_cut cuts[AP_SEAMS_MAX];
    int pieces;
    t->parts++;
    if (!ap_choose_level(&viewer, &eyes, part, shape, &place, image, px, &level) ||
        !level.whole_seams)
        return;
    t->whole++;
    bool equal =
        ap_seams_cut(&viewer, &eyes, part, shape, &place.nose_from_part, image, px, cuts, &pieces);
    if ((!equal || pieces != 1) && t->wrong++ < 5)
        printf("  form %d at %.3f rho, %.3f px, image %d: %d pieces, not 1\n", (int)part->form,
               d / rho, px, image, equal ? pieces : -1);
}

int main(int argc, char **argv) {
    static const char *const WORLDS[] = {
        "honeycomb:5,3,4", "honeycomb:5,3,4,struts", "honeycomb:4,3,4", "honeycomb:4,3,4,struts",
        "honeycomb:5,3,3", "honeycomb:5,3,3,struts", "seifert-weber",   "honeycomb:3,5,3,struts"};
    int each = argc > 1 ? atoi(argv[1]) : 20000, bad = 0;
    for (size_t k = 0; k < sizeof WORLDS / sizeof *WORLDS; k++) {
        const struct ap_scene_params none = {0};
        const struct ap_gpu no_gpu = {0};
        struct ap_scene *scene;
        struct ap_meshes meshes;
        struct ap_mesh_data ahead = {0};
        struct tally t = {0};
        STAGE_CHECK(ap_scene_named(&stage_error, WORLDS[k], &none, &scene));
        STAGE_CHECK(ap_meshes_make(&stage_error, scene, &meshes, &ahead));
        for (int i = 0; i < each; i++)
            try_part(scene, &meshes, i, &t);
        printf("%-24s %ld parts, of %ld no seam is cut by their place (more than a fiftieth), of "
               "%ld a seam is by itself (none)\n",
               WORLDS[k], t.parts, t.whole, t.wrong);
        bad += t.wrong > 0 || t.whole * 50 < t.parts;
        ap_meshes_destroy(&no_gpu, &meshes);
        ap_mesh_data_finish(&ahead);
        ap_scene_destroy(scene);
    }
    return bad ? 1 : 0;
}
