#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "src/scene/scene.h"
#include "tests/scene/scratch.h"

static struct scratch scratch;

static void put(const char *name, const char *text) {
    scratch_write(&scratch, name, text, strlen(text));
}

static enum ap_status read_with(struct ap_error *err, const char *space, const char *member,
                                struct ap_scene **scene) {
    char text[512];
    snprintf(text, sizeof text,
             "{\"space\":{\"geometry\":\"%s\",\"radius_m\":1},\"objects\":[{\"model\":"
             "{\"at_m\":[0,0,-0.5],%s}}]}",
             space, member);
    put("s.json", text);
    const struct ap_scene_params none = {0};
    return ap_scene_read(err, scratch_path(&scratch, "s.json"), &none, scene);
}

// Two quads at right angles, one with normals of its own file order.
static const char obj[] = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\n"
                          "f 1 2 3 4\nf 1 5 6 2\n";

// A triangle under two nodes: moved by (0, 0, 1), and doubled and mirrored in x. The buffer holds
// three positions as float32.
static const char gltf[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}],"
    "\"nodes\":[{\"mesh\":0,\"translation\":[0,0,1]},{\"mesh\":0,\"scale\":[-2,2,2]}],"
    "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,0,0,1]}}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":0}]}],"
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\","
    "\"min\":[0,0,0],\"max\":[1,1,0]}],"
    "\"bufferViews\":[{\"buffer\":0,\"byteOffset\":0,\"byteLength\":36}],"
    "\"buffers\":[{\"byteLength\":36,\"uri\":\"data:application/octet-stream;base64,"
    "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}]}";

static void a_file_becomes_solids(void **state) {
    (void)state;
    put("m.obj", obj);
    struct ap_error err = {""};
    struct ap_scene *s = NULL;
    if (read_with(&err, "h3", "\"file\":\"m.obj\",\"scale\":0.5,\"color\":\"#102030\"", &s))
        print_error("%s\n", err.text);
    assert_non_null(s);
    assert_int_equal(s->solid_count, 1);
    assert_int_equal(s->part_count, 1);
    assert_int_equal(s->solids[0].index_count, 12);
    if (fabs(s->solids[0].reach_m - 0.5 * sqrt(2)) > 1e-6) {
        print_error("reach %g, expected %g\n", s->solids[0].reach_m, 0.5 * sqrt(2));
        fail();
    }
    for (size_t i = 0; i < s->solids[0].vertex_count; i++) {
        const float *n = &s->solids[0].normals[3 * i];
        assert_true(fabs(hypot(hypot(n[0], n[1]), n[2]) - 1) < 1e-5);
    }
    assert_true(fabs(s->parts[0].color_srgb[2] - 0x30 / 255.0) < 1e-12);
    ap_scene_destroy(s);
}

// The triangles' area vectors say where their nodes put them, and which way they face.
static void nodes_are_applied(void **state) {
    (void)state;
    put("m.gltf", gltf);
    struct ap_error err = {""};
    struct ap_scene *s = NULL;
    if (read_with(&err, "e3", "\"file\":\"m.gltf\"", &s))
        print_error("%s\n", err.text);
    assert_non_null(s);
    assert_int_equal(s->part_count, 2);
    const double expected_area[2] = {0.5, 2}, expected_z[2] = {1, 0}, least_x[2] = {0, -2};
    for (int i = 0; i < 2; i++) {
        const struct ap_solid *o = &s->solids[s->parts[i].solid];
        assert_int_equal(o->index_count, 3);
        struct ap_vec3 c[3];
        double x = INFINITY;
        for (int k = 0; k < 3; k++) {
            const float *q = &o->positions[3 * o->indices[k]];
            c[k] = (struct ap_vec3){q[0], q[1], q[2]};
            x = fmin(x, c[k].x);
        }
        struct ap_vec3 area =
            ap_vec3_scale(0.5, ap_vec3_cross(ap_vec3_sub(c[1], c[0]), ap_vec3_sub(c[2], c[0])));
        print_message("node %d: area %g, z %g, least x %g, normal %g\n", i, area.z, c[0].z, x,
                      (double)o->normals[2]);
        // A mirrored place keeps the outside outside: its triangle is turned, so it still faces +z.
        assert_true(fabs(area.z - expected_area[i]) < 1e-6);
        assert_true(fabs(c[0].z - expected_z[i]) < 1e-6 && fabs(x - least_x[i]) < 1e-6);
        assert_true(o->normals[2] > 0.99F);
        assert_true(s->parts[i].color_srgb[0] == 1 && s->parts[i].color_srgb[1] == 0);
    }
    ap_scene_destroy(s);
}

static void bad_models_are_input_errors(void **state) {
    (void)state;
    put("m.obj", obj);
    put("empty.obj", "");
    put("text.glb", "this is not a model at all, whatever its name says");
    put("points.obj", "v 0 0 0\nv 1 0 0\np 1 2\n");
    put("face.obj", "v 0 0 0\nf 1 7 9\n");
    put("off.off", "OFF\n400000000 400000000 0\n0 0 0\n");
    put("ply.ply", "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\n"
                   "end_header\n0\n");
    put("ext.gltf", "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":36,"
                    "\"uri\":\"/etc/passwd\"}]}");
    static const char *const files[] = {
        "empty.obj", "text.glb", "points.obj", "face.obj", "off.off", "ply.ply",
        "ext.gltf",  "none.obj", "m.blend",    ".",        ""};
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char member[128];
        snprintf(member, sizeof member, "\"file\":\"%s\"", files[i]);
        struct ap_error err = {""};
        struct ap_scene *s = NULL;
        enum ap_status st = read_with(&err, "h3", member, &s);
        print_message("%s: status %d, %s\n", files[i], st, err.text);
        assert_int_equal(st, AP_INPUT);
        assert_non_null(strstr(err.text, "/objects/0/model/file"));
        assert_null(strchr(err.text, '\n'));
        assert_null(s);
    }
    // Farther than s3 is large.
    struct ap_error err = {""};
    struct ap_scene *s = NULL;
    assert_int_equal(read_with(&err, "s3", "\"file\":\"m.obj\",\"scale\":4", &s), AP_INPUT);
    assert_non_null(strstr(err.text, "scale"));
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_file_becomes_solids),
                                       cmocka_unit_test(nodes_are_applied),
                                       cmocka_unit_test(bad_models_are_input_errors)};
    if (scratch_open(&scratch))
        return 1;
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    scratch_remove(&scratch, (const char *const[]){"s.json", "m.obj", "m.gltf", "empty.obj",
                                                   "text.glb", "points.obj", "face.obj", "off.off",
                                                   "ply.ply", "ext.gltf", NULL});
    return failed;
}
