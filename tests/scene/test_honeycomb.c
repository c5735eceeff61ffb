#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "src/scene/scene.h"
#include "tests/scene/scratch.h"

static struct scratch scratch;

static enum ap_status read_text(const char *text, struct ap_error *err, struct ap_scene **scene) {
    const struct ap_scene_params none = {0};
    return ap_scene_read(err, scratch_write(&scratch, "s.json", text, strlen(text)), &none, scene);
}

struct bad {
    const char *text, *says;
};

#define ONE(object) "{\"objects\":[" object "]}"

static const struct bad bads[] = {
    {ONE("{\"honeycomb\":{}}"), "/objects/0/honeycomb/symbol: expected a Schl"},
    {ONE("{\"honeycomb\":{\"symbol\":[5,3,-4]}}"), "/symbol/2: expected a number of the symbol"},
    {ONE("{\"honeycomb\":{\"symbol\":[6,3,3]}}"), "flat planes without end"},
    {ONE("{\"honeycomb\":{\"symbol\":[3,3,7]}}"), "beyond infinity"},
    {ONE("{\"honeycomb\":{\"symbol\":[5,3,4],\"show\":[\"doors\"]}}"), "/show/0: expected"},
    {ONE("{\"honeycomb\":{\"symbol\":[5,3,4],\"width\":2}}"), "/width: expected a number from"},
    {ONE("{\"honeycomb\":{\"symbol\":[5,3,4]}},{\"quotient\":{\"name\":\"torus\"}}"),
     "/objects/1/quotient: a scene has only one"},
    {ONE("{\"honeycomb\":{\"symbol\":[5,3,4]}},{\"table\":{}}"), "has no table"},
    {ONE("{\"honeycomb\":{\"symbol\":[5,3,4]}},{\"ball\":{\"at_m\":[0,-0.9,0],\"radius_m\":0.2}}"),
     "/objects/1: reaches out of the cell through face"},
    {ONE("{\"quotient\":{\"name\":\"klein\"}}"), "/quotient/name: expected \"torus\""},
    {ONE("{\"quotient\":{\"cell\":[4,3,4],\"pairs\":[{\"face\":0,\"to\":5,\"turn\":0}]}}"),
     "/quotient/pairs: face 1 is not paired"},
    {ONE("{\"quotient\":{\"cell\":[4,3,4],\"pairs\":[{\"face\":0,\"to\":5,\"turn\":0},"
         "{\"face\":5,\"to\":1,\"turn\":0}]}}"),
     "/quotient/pairs/1: face 5 is paired already, with face 0"},
    {ONE("{\"quotient\":{\"cell\":[5,3,3],\"name\":\"torus\",\"pairs\":[]}}"),
     "expected a \"name\""},
    {"{\"space\":{\"geometry\":\"e3\"},\"objects\":[{\"honeycomb\":{\"symbol\":[5,3,4]}}]}",
     "belongs to h3, not to e3"},
};

static void bad_ones_say_where(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof bads / sizeof *bads; i++) {
        struct ap_error err = {""};
        struct ap_scene *scene = NULL;
        enum ap_status st = read_text(bads[i].text, &err, &scene);
        if (!st || !strstr(err.text, bads[i].says))
            fail_msg("status %d, \"%s\"; expected \"%s\"", st, err.text, bads[i].says);
        assert_null(scene);
    }
}

static void sizes_follow_the_edge(void **state) {
    (void)state;
    struct ap_error err = {""};
    struct ap_scene *scene;
    if (read_text(ONE("{\"honeycomb\":{\"symbol\":[4,3,5],\"edge_m\":2.5}}"), &err, &scene))
        fail_msg("%s", err.text);
    assert_int_equal(scene->space.kappa, -1);
    if (fabs(scene->honeycomb->tiling.edge_m - 2.5) > 1e-15 * 4)
        fail_msg("edge %.17g, expected 2.5", scene->honeycomb->tiling.edge_m);
    ap_scene_destroy(scene);
}

static void names_are_scenes(void **state) {
    (void)state;
    static const char *const good[] = {"honeycomb:5,3,4,walls,width=0.3", "torus",
                                       "poincare-dodecahedral,struts,balls,horizon=20,budget=1",
                                       "seifert-weber", "mirrored-dodecahedron"};
    const struct ap_scene_params none = {0};
    struct ap_error err = {""};
    struct ap_scene *scene;
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        assert_true(ap_scene_is_named(good[i]));
        if (ap_scene_named(&err, good[i], &none, &scene))
            fail_msg("%s: %s", good[i], err.text);
        assert_true(scene->honeycomb && scene->part_count >= 10);
        ap_scene_destroy(scene);
    }
    assert_false(ap_scene_is_named("torus.json"));
    assert_int_equal(ap_scene_named(&err, "torus,width=x", &none, &scene), AP_USAGE);
    assert_non_null(strstr(err.text, "'width=x' is not understood"));
    const struct ap_scene_params e3 = {.space_name = "e3"};
    assert_int_equal(ap_scene_named(&err, "honeycomb:5,3,4", &e3, &scene), AP_USAGE);
    assert_non_null(strstr(err.text, "belongs to h3"));
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(bad_ones_say_where),
                                       cmocka_unit_test(sizes_follow_the_edge),
                                       cmocka_unit_test(names_are_scenes)};
    scratch_open(&scratch);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    scratch_remove(&scratch, (const char *const[]){"s.json", NULL});
    return failed;
}
