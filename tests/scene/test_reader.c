#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "src/geom/map.h"
#include "src/geom/table.h"
#include "src/scene/scene.h"
#include "tests/scene/scratch.h"

static struct scratch scratch;

static enum ap_status read_text(const char *text, const struct ap_scene_params *params,
                                struct ap_error *err, struct ap_scene **scene) {
    const struct ap_scene_params none = {0};
    const char *path = scratch_write(&scratch, "s.json", text, strlen(text));
    return ap_scene_read(err, path, params ? params : &none, scene);
}

static struct ap_scene *must_read(const char *text, const struct ap_scene_params *params) {
    struct ap_error err = {""};
    struct ap_scene *scene = NULL;
    if (read_text(text, params, &err, &scene)) {
        print_error("%s\n  for %s\n", err.text, text);
        fail();
    }
    return scene;
}

static void close_to(const char *what, double got, double expected, double tolerance) {
    if (!(fabs(got - expected) <= tolerance)) {
        print_error("%s: %.17g, expected %.17g within %g\n", what, got, expected, tolerance);
        fail();
    }
}

struct bad {
    const char *text, *says;
};

#define S3 "{\"space\":{\"geometry\":\"s3\",\"radius_m\":1},\"objects\":["
#define H3 "{\"space\":{\"geometry\":\"h3\",\"radius_m\":1},\"objects\":["

static const struct bad bads[] = {
    {"{", "s.json:1:"},
    {"[]", "s.json: /: expected an object"},
    {"{}", "s.json: /objects: expected an array"},
    {"{\"objects\":{}}", "/objects: expected an array"},
    {"{\"objects\":[],\"objcets\":1}", "/objcets: unknown key"},
    {"{\"objects\":[],\"space\":3}", "/space: expected an object"},
    {"{\"objects\":[],\"space\":{\"geometry\":\"nil\"}}", "/space/geometry: expected \"s3\""},
    {"{\"objects\":[],\"space\":{\"radius_m\":0}}", "/space/radius_m: expected a length above 0"},
    {"{\"objects\":[],\"space\":{\"radius_m\":-2}}", "/space/radius_m"},
    {"{\"objects\":[],\"space\":{\"radius_m\":1.1e9}}", "/space/radius_m: 1.1e+09 m is too large"},
    {"{\"objects\":[],\"space\":{\"radius\":2}}", "/space/radius: unknown key"},
    {"{\"objects\":[],\"background\":\"red\"}", "/background: expected a colour"},
    {"{\"objects\":[],\"background\":\"#12345\"}", "/background"},
    {"{\"objects\":[],\"background\":\"#12345g\"}", "/background"},
    {"{\"objects\":[],\"background\":7}", "/background: expected a string"},
    {"{\"objects\":[3]}", "/objects/0: expected an object"},
    {"{\"objects\":[{}]}", "/objects/0: expected one of"},
    {"{\"objects\":[{\"cue\":{},\"hands\":{}}]}", "/objects/0: expected one of"},
    {"{\"objects\":[{\"cube\":{}}]}", "/objects/0/cube: unknown key"},
    {"{\"objects\":[{\"cue\":{\"length_m\":1}}]}", "/objects/0/cue/length_m: unknown key"},
    {"{\"objects\":[{\"table\":{}},{\"table\":{}}]}", "/objects/1/table: a scene has only one"},
    {H3 "{\"ball\":{}}]}", "/objects/0/ball/at_m: expected an array of 3"},
    {H3 "{\"ball\":{\"at_m\":[0,0],\"radius_m\":1}}]}", "/objects/0/ball/at_m"},
    {H3 "{\"ball\":{\"at_m\":[0,0,\"1\"],\"radius_m\":1}}]}", "/objects/0/ball/at_m/2"},
    {H3 "{\"ball\":{\"at_m\":[0,0,1e999],\"radius_m\":1}}]}", "s.json"},
    {H3 "{\"ball\":{\"at_m\":[0,0,1e9],\"radius_m\":1}}]}", "/objects/0/ball/at_m"},
    {"{\"space\":{\"geometry\":\"e3\"},\"objects\":[{\"ball\":{\"at_m\":[0,0,1.1e9]}}]}",
     "/objects/0/ball/at_m: 1.1e+09 m from the base point: at most 1e9 m"},
    {H3 "{\"ball\":{\"at_m\":[0,0,0]}}]}", "/objects/0/ball/radius_m: expected a number"},
    {H3 "{\"ball\":{\"at_m\":[0,0,0],\"radius_m\":0}}]}", "/ball/radius_m: expected a length"},
    {H3 "{\"ball\":{\"at_m\":[0,0,0],\"radius_m\":-1}}]}", "/ball/radius_m"},
    {H3 "{\"ball\":{\"at_m\":[0,0,0],\"radius_m\":1,\"lit\":1}}]}", "/ball/lit: expected true"},
    {H3 "{\"ball\":{\"at_m\":[0,0,0],\"radius_m\":1,\"colour\":\"\"}}]}", "/ball/colour: unknown"},
    {H3 "{\"ball\":{\"at_m\":[0,0,0],\"radius_m\":1,\"target\":\"t\"}}]}",
     "/ball/target: a target"},
    {H3 "{\"ball\":{\"at_m\":[0,0,0],\"radius_m\":1,\"lit\":false,\"target\":\"\"}}]}",
     "/ball/target: expected 1 to 63"},
    {H3 "{\"ball\":{\"at_m\":[0,0,0],\"radius_m\":1,\"lit\":false,\"target\":\"a,b\"}}]}",
     "/ball/target: expected 1 to 63"},
    {H3 "{\"ball\":{\"at_m\":[0,0,0],\"radius_m\":1,\"lit\":false,\"target\":\"a\"}},"
        "{\"ball\":{\"at_m\":[1,0,0],\"radius_m\":1}}]}",
     "/objects/0/ball/target: target 'a': its colour is used more than once"},
    {H3 "{\"ball\":{\"at_m\":[0,0,0],\"radius_m\":1,\"lit\":false,\"color\":\"#000000\","
        "\"target\":\"a\"}}]}",
     "/objects/0/ball/target: target 'a': its colour"}, // the background's
    {H3 "{\"ball\":{\"at_m\":[0,0,0],\"radius_m\":1,\"lit\":false,\"target\":\"a\"}},"
        "{\"ball\":{\"at_m\":[1,0,0],\"radius_m\":1,\"lit\":false,\"color\":\"#010203\","
        "\"target\":\"a\"}}]}",
     "ball/target: target 'a': another target"},
    {S3 "{\"ball\":{\"at_m\":[0,0,0],\"radius_m\":1.5707964}}]}", "/objects/0/ball/radius_m"},
    {S3 "{\"ball\":{\"at_m\":[0,3.1416,0],\"radius_m\":0.1}}]}", "/objects/0/ball/at_m"},
    {S3 "{\"stick\":{\"from_m\":[0,0,0],\"to_m\":[0,0,0],\"radius_m\":0.1}}]}", "/stick: from_m"},
    {S3 "{\"stick\":{\"from_m\":[1.57079632679489662,0,0],\"to_m\":[-1.57079632679489662,0,0],"
        "\"radius_m\":0.1}}]}",
     "/objects/0/stick: from_m and to_m are opposite"},
    {H3 "{\"stick\":{\"from_m\":[0,0,0],\"radius_m\":0.1}}]}", "/stick/to_m"},
    {S3 "{\"polygon\":{\"at_m\":[0,0,0],\"sides\":4,\"edge_m\":1.6}}]}",
     "/polygon/edge_m: 4 edges"},
    {H3 "{\"polygon\":{\"at_m\":[0,0,0],\"sides\":2,\"edge_m\":1}}]}", "/polygon/sides"},
    {H3 "{\"polygon\":{\"at_m\":[0,0,0],\"sides\":4.5,\"edge_m\":1}}]}", "/polygon/sides"},
    {H3 "{\"polygon\":{\"at_m\":[0,0,0],\"sides\":1000,\"edge_m\":1}}]}", "/polygon/sides"},
    {H3 "{\"polygon\":{\"at_m\":[0,0,0],\"sides\":4,\"edge_m\":1,\"rotate\":[0,0,0,2]}}]}",
     "/polygon/rotate"},
    {H3 "{\"model\":{\"at_m\":[0,0,0]}}]}", "/model/file: expected a string"},
    {H3 "{\"model\":{\"at_m\":[0,0,0],\"file\":\"gone.obj\"}}]}", "/objects/0/model/file"},
    {H3 "{\"model\":{\"at_m\":[0,0,0],\"file\":\"/etc/passwd\"}}]}", "/objects/0/model/file"},
    {H3 "{\"model\":{\"at_m\":[0,0,0],\"file\":\"x.obj\",\"scale\":0}}]}", "/model/scale"},
};

static void bad_files_are_named_by_their_place(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof bads / sizeof *bads; i++) {
        struct ap_error err = {""};
        struct ap_scene *scene = NULL;
        enum ap_status st = read_text(bads[i].text, NULL, &err, &scene);
        if (st != AP_INPUT || !strstr(err.text, bads[i].says) || scene) {
            print_error("status %d, '%s', expected status 3 and '%s' for %s\n", st, err.text,
                        bads[i].says, bads[i].text);
            fail();
        }
        assert_null(strchr(err.text, '\n'));
    }
    struct ap_scene *scene = NULL;
    const struct ap_scene_params none = {0};
    assert_int_equal(ap_scene_read(NULL, "/nonexistent/x.json", &none, &scene), AP_INPUT);
}

static void command_line_before_file_before_defaults(void **state) {
    (void)state;
    const char *file = "{\"space\":{\"geometry\":\"e3\",\"radius_m\":2},\"objects\":[]}";
    const char *huge = "{\"space\":{\"geometry\":\"e3\",\"radius_m\":1e9},\"objects\":[]}";
    const char *far = "{\"space\":{\"geometry\":\"e3\"},\"objects\":[{\"ball\":"
                      "{\"at_m\":[0,0,-1e9],\"radius_m\":1}}]}";
    const char *bare = "{\"objects\":[]}", *tabled = "{\"objects\":[{\"table\":{}}]}";
    struct {
        const char *text;
        struct ap_scene_params params;
        int kappa;
        double rho_m, edge_m;
    } cases[] = {
        {bare, {0}, -1, 0.848036510331695, 0.9},
        {tabled, {0}, -1, 0.848036510331695, 0.9},
        {bare, {.space_name = "s3"}, 1, 0.572957795130823, 0.9},
        {bare, {.space_name = "e3"}, 0, 1, 0.9},
        {bare, {.table_edge_m = 1.8}, -1, 2 * 0.848036510331695, 1.8},
        {bare, {.radius_m = 3}, -1, 3, 3 * 1.0612750619050357},
        {bare, {.space_name = "s3", .radius_m = 1e9}, 1, 1e9, 1.5707963267948966e9},
        {huge, {0}, 0, 1e9, 0.9},
        {far, {0}, 0, 1, 0.9},
        {file, {0}, 0, 2, 0.9},
        {file, {.space_name = "h3"}, -1, 2, 2 * 1.0612750619050357},
        {file, {.radius_m = 5}, 0, 5, 0.9},
        {tabled, {.space_name = "s3", .radius_m = 1}, 1, 1, 1.5707963267948966},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct ap_scene *s = must_read(cases[i].text, &cases[i].params);
        assert_int_equal(s->space.kappa, cases[i].kappa);
        close_to("radius", s->space.rho_m, cases[i].rho_m, 2e-15 * 3);
        close_to("edge", s->table_edge_m, cases[i].edge_m, 1e-14 * fmax(cases[i].edge_m, 1));
        close_to("height", s->table_height_m, 0.75, 0);
        assert_int_equal(s->has_table, cases[i].text == tabled);
        ap_scene_destroy(s);
    }
}

static void contradictions_are_usage_errors(void **state) {
    (void)state;
    const char *tabled = "{\"objects\":[{\"table\":{}}]}";
    struct ap_scene_params params = {.radius_m = 1, .table_edge_m = 0.9};
    struct ap_error err = {""};
    struct ap_scene *scene = NULL;
    assert_int_equal(read_text(tabled, &params, &err, &scene), AP_USAGE);
    assert_non_null(strstr(err.text, "--table-edge"));
    params.table_edge_m = 1.0612750619050357;
    ap_scene_destroy(must_read(tabled, &params));
    params = (struct ap_scene_params){.radius_m = -1};
    assert_int_equal(read_text(tabled, &params, &err, &scene), AP_USAGE);
    params = (struct ap_scene_params){.table_edge_m = NAN};
    assert_int_equal(read_text(tabled, &params, &err, &scene), AP_USAGE);
    params = (struct ap_scene_params){.space_name = "x3"};
    assert_int_equal(read_text(tabled, &params, &err, &scene), AP_USAGE);
    assert_null(scene);
}

static void parts_are_what_the_file_says(void **state) {
    (void)state;
    struct ap_scene *s = must_read(
        "{\"space\":{\"geometry\":\"h3\",\"radius_m\":0.85},\"background\":\"#336699\",\"objects\":["
        "{\"ball\":{\"at_m\":[0.3,0.2,-1],\"radius_m\":0.02,\"color\":\"#Ff2080\",\"lit\":false}},"
        "{\"stick\":{\"from_m\":[-0.5,0,-1],\"to_m\":[0.4,0.3,-0.8],\"radius_m\":0.01}},"
        "{\"polygon\":{\"at_m\":[0,-0.5,0],\"rotate\":[0,0.6,0,0.8],\"sides\":5,\"edge_m\":0.9}}]}",
        NULL);
    assert_int_equal(s->part_count, 3);
    close_to("background", s->background_srgb[1], 0.4, 1e-15);
    const struct ap_part *ball = &s->parts[0], *stick = &s->parts[1], *polygon = &s->parts[2];
    assert_true(ball->kind == AP_PART_BALL && !ball->lit && ball->target);
    assert_string_equal(ball->name, "object-0"); // unlit, its colour used once, no name given
    close_to("red", ball->color_srgb[0], 1, 0);
    close_to("blue", ball->color_srgb[2], 128 / 255.0, 1e-15);
    struct ap_vec4 base = {0, 0, 0, s->space.rho_m};
    struct ap_vec4 p = ap_iso_apply(&ball->carrier_from_part, base);
    struct ap_vec4 q = ap_exp(s->space, (struct ap_vec3){0.3, 0.2, -1});
    double d;
    assert_int_equal(ap_distance(NULL, s->space, p, q, &d), AP_OK);
    close_to("ball's place", d, 0, 1e-12);
    // The stick's ends: −z is `to`.
    const struct ap_vec3 ends[2] = {{0.4, 0.3, -0.8}, {-0.5, 0, -1}};
    for (int i = 0; i < 2; i++) {
        struct ap_vec3 half = {0, 0, (i ? 0.5 : -0.5) * stick->length_m};
        p = ap_iso_apply(&stick->carrier_from_part, ap_exp(s->space, half));
        assert_int_equal(ap_distance(NULL, s->space, p, ap_exp(s->space, ends[i]), &d), AP_OK);
        close_to("stick's end", d, 0, 1e-7);
    }
    // Parallel transport, then rotate.
    struct ap_iso want = ap_iso_mul(ap_iso_translate(s->space, (struct ap_vec3){0, -0.5, 0}),
                                    ap_iso_rotate((struct ap_quat){0, 0.6, 0, 0.8}));
    for (int i = 0; i < 16; i++)
        close_to("polygon's place", polygon->carrier_from_part.m[i / 4][i % 4],
                 want.m[i / 4][i % 4], 1e-15);
    assert_true(polygon->kind == AP_PART_POLYGON && polygon->sides == 5 && polygon->lit);
    assert_int_equal(polygon->object, 2);
    ap_scene_destroy(s);
}

// Two unlit balls of one colour are no targets, and that is no error unless one is named.
static void shared_colours_are_no_targets(void **state) {
    (void)state;
    struct ap_scene *s = must_read(
        H3 "{\"ball\":{\"at_m\":[0,0,-1],\"radius_m\":0.1,\"lit\":false,\"color\":\"#abcdef\"}},"
           "{\"ball\":{\"at_m\":[0,1,-1],\"radius_m\":0.1,\"lit\":false,\"color\":\"#ABCDEF\"}},"
           "{\"ball\":{\"at_m\":[1,1,-1],\"radius_m\":0.1,\"lit\":false,\"color\":\"#123456\","
           "\"target\":\"lone one\"}}]}",
        NULL);
    assert_false(s->parts[0].target || s->parts[1].target);
    assert_true(s->parts[2].target);
    assert_string_equal(s->parts[2].name, "lone one");
    ap_scene_destroy(s);
}

static void far_places_in_h3_stay_finite(void **state) {
    (void)state;
    struct ap_scene *s = must_read(H3 "{\"ball\":{\"at_m\":[0,0,-80],\"radius_m\":0.1}}]}", NULL);
    for (int i = 0; i < 16; i++)
        assert_true(isfinite(s->parts[0].carrier_from_part.m[i / 4][i % 4]));
    ap_scene_destroy(s);
}

static void examples_of_the_documentation_are_read(void **state) {
    (void)state;
    const char *root = getenv("ANTIPODE_SOURCE");
    if (!root) {
        print_message("skipped: ANTIPODE_SOURCE does not say where docs/scenes is\n");
        skip();
    }
    static const char *const names[] = {"lanterns", "long_way_round", "table"};
    for (int i = 0; i < 3; i++) {
        char path[512];
        snprintf(path, sizeof path, "%s/docs/scenes/%s.json", root, names[i]);
        const struct ap_scene_params none = {0};
        struct ap_error err = {""};
        struct ap_scene *scene = NULL;
        if (ap_scene_read(&err, path, &none, &scene))
            print_error("%s\n", err.text);
        assert_non_null(scene);
        size_t targets = 0;
        for (size_t k = 0; k < scene->part_count; k++)
            targets += scene->parts[k].target;
        assert_true(targets >= 1);
        ap_scene_destroy(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(bad_files_are_named_by_their_place),
                                       cmocka_unit_test(command_line_before_file_before_defaults),
                                       cmocka_unit_test(contradictions_are_usage_errors),
                                       cmocka_unit_test(parts_are_what_the_file_says),
                                       cmocka_unit_test(shared_colours_are_no_targets),
                                       cmocka_unit_test(far_places_in_h3_stay_finite),
                                       cmocka_unit_test(examples_of_the_documentation_are_read)};
    if (scratch_open(&scratch))
        return 1;
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    scratch_remove(&scratch, (const char *const[]){"s.json", NULL});
    return failed;
}
