#include "src/scene/import.h"

#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "src/base/file.h"

// Models come from anywhere. The file is read here, bounded, and handed to the importer as bytes
// with its format's name, so that nothing in it can make the importer open another file; what comes
// out is counted over all places in its tree before anything is copied.
enum { MAX_FILE_BYTES = 64 << 20, MAX_NODES = 100000, MAX_DEPTH = 256 };

static const char *format_of(const char *path) {
    static const char *const formats[] = {"glb", "gltf", "obj", "ply", "stl", "off", "dae", NULL};
    const char *dot = strrchr(path, '.');
    for (const char *const *f = formats; dot && *f; f++)
        if (strcasecmp(dot + 1, *f) == 0)
            return *f;
    return NULL;
}

struct importer {
    struct ap_error *err;
    struct ap_scene_build *build;
    const struct ap_model_request *request;
    const struct aiScene *scene;
    size_t nodes, vertices, triangles;
};

static enum ap_status count_node(struct importer *in, const struct aiNode *node, int depth) {
    if (depth > MAX_DEPTH || ++in->nodes > MAX_NODES)
        return ap_fail(in->err, AP_INPUT, "%s: its tree is too large (%d nodes, %d levels at most)",
                       in->request->path, MAX_NODES, MAX_DEPTH);
    for (unsigned i = 0; i < node->mNumMeshes; i++) {
        if (node->mMeshes[i] >= in->scene->mNumMeshes)
            return ap_fail(in->err, AP_INPUT, "%s: a node names a mesh that is not there",
                           in->request->path);
        const struct aiMesh *mesh = in->scene->mMeshes[node->mMeshes[i]];
        in->vertices += mesh->mNumVertices;
        in->triangles += mesh->mNumFaces;
    }
    if (in->vertices > AP_MODEL_MAX_VERTICES || in->triangles > 2 * (size_t)AP_MODEL_MAX_VERTICES)
        return ap_fail(in->err, AP_INPUT, "%s: more than %d vertices or %d triangles",
                       in->request->path, AP_MODEL_MAX_VERTICES, 2 * AP_MODEL_MAX_VERTICES);
    enum ap_status st = AP_OK;
    for (unsigned i = 0; i < node->mNumChildren && !st; i++)
        st = count_node(in, node->mChildren[i], depth + 1);
    return st;
}

static struct ap_vec3 transform(const struct aiMatrix4x4 *m, struct aiVector3D v, double w) {
    return (struct ap_vec3){m->a1 * v.x + m->a2 * v.y + m->a3 * v.z + m->a4 * w,
                            m->b1 * v.x + m->b2 * v.y + m->b3 * v.z + m->b4 * w,
                            m->c1 * v.x + m->c2 * v.y + m->c3 * v.z + m->c4 * w};
}

// Normals go by the cofactors, which need no inverse and keep their sense in mirrored places when
// multiplied by the determinant's sign.
static struct ap_vec3 transform_normal(const struct aiMatrix4x4 *m, struct aiVector3D n) {
    struct ap_vec3 r0 = {m->a1, m->a2, m->a3}, r1 = {m->b1, m->b2, m->b3};
    struct ap_vec3 r2 = {m->c1, m->c2, m->c3}, v = {n.x, n.y, n.z};
    struct ap_vec3 c0 = ap_vec3_cross(r1, r2), c1 = ap_vec3_cross(r2, r0);
    struct ap_vec3 c2 = ap_vec3_cross(r0, r1);
    double side = ap_vec3_dot(r0, c0) < 0 ? -1 : 1;
    return ap_vec3_normalize(ap_vec3_scale(
        side, (struct ap_vec3){ap_vec3_dot(c0, v), ap_vec3_dot(c1, v), ap_vec3_dot(c2, v)}));
}

static bool mirrors(const struct aiMatrix4x4 *m) {
    struct ap_vec3 r0 = {m->a1, m->a2, m->a3}, r1 = {m->b1, m->b2, m->b3};
    struct ap_vec3 r2 = {m->c1, m->c2, m->c3};
    return ap_vec3_dot(r0, ap_vec3_cross(r1, r2)) < 0;
}

static unsigned mesh_color(const struct importer *in, const struct aiMesh *mesh) {
    struct aiColor4D c = {0.75F, 0.75F, 0.75F, 1};
    if (in->request->rgb >= 0)
        return (unsigned)in->request->rgb;
    if (mesh->mMaterialIndex < in->scene->mNumMaterials) {
        const struct aiMaterial *m = in->scene->mMaterials[mesh->mMaterialIndex];
        if (aiGetMaterialColor(m, AI_MATKEY_BASE_COLOR, &c) != AI_SUCCESS)
            (void)aiGetMaterialColor(m, AI_MATKEY_COLOR_DIFFUSE, &c);
    }
    const float channel[3] = {c.r, c.g, c.b};
    unsigned rgb = 0;
    for (int i = 0; i < 3; i++) // not a number falls to 0
        rgb = rgb << 8 | (unsigned)(channel[i] > 0 ? lround(fmin(channel[i], 1) * 255) : 0);
    return rgb;
}

double ap_model_reach(struct ap_space space) {
    return space.kappa > 0 ? M_PI * space.rho_m : space.kappa < 0 ? 40 * space.rho_m : 1e9;
}

static enum ap_status add_vertices(struct importer *in, const struct aiMesh *mesh,
                                   const struct aiMatrix4x4 *m, struct ap_mesh *out) {
    double most = ap_model_reach(in->build->scene->space);
    for (unsigned i = 0; i < mesh->mNumVertices; i++) {
        struct ap_vec3 p = ap_vec3_scale(in->request->scale, transform(m, mesh->mVertices[i], 1));
        struct ap_vec3 n = {0, 1, 0};
        if (mesh->mNormals)
            n = transform_normal(m, mesh->mNormals[i]);
        if (!(ap_vec3_length(p) < most))
            return ap_fail(in->err, AP_INPUT,
                           "%s: a vertex %g m from the model's origin: less than %g m, please (see "
                           "scale)",
                           in->request->path, ap_vec3_length(p), most);
        if (!(ap_vec3_length(n) > 0.5))
            n = (struct ap_vec3){0, 1, 0}; // a degenerate face has no side
        ap_mesh_vertex(out, p, n);
    }
    return AP_OK;
}

static enum ap_status add_mesh(struct importer *in, const struct aiMesh *mesh,
                               const struct aiMatrix4x4 *m) {
    if (!mesh->mVertices || !(mesh->mPrimitiveTypes & aiPrimitiveType_TRIANGLE))
        return AP_OK; // points and lines
    struct ap_mesh out = {0};
    enum ap_status st = add_vertices(in, mesh, m, &out);
    bool turn = mirrors(m);
    for (unsigned i = 0; i < mesh->mNumFaces && !st; i++) {
        const struct aiFace *f = &mesh->mFaces[i];
        if (f->mNumIndices != 3)
            continue;
        unsigned a = f->mIndices[0], b = f->mIndices[turn ? 2 : 1], c = f->mIndices[turn ? 1 : 2];
        if (a >= mesh->mNumVertices || b >= mesh->mNumVertices || c >= mesh->mNumVertices)
            st = ap_fail(in->err, AP_INPUT, "%s: a face names a vertex that is not there",
                         in->request->path);
        else
            ap_mesh_triangle(&out, a, b, c);
    }
    if (st || out.solid.index_count == 0) {
        ap_mesh_finish(&out);
        return st;
    }
    struct ap_part part =
        ap_solid_part(in->request->place, ap_build_solid(in->build, &out), mesh_color(in, mesh));
    part.lit = in->request->lit;
    ap_build_part(in->build, part);
    return AP_OK;
}

static enum ap_status add_node(struct importer *in, const struct aiNode *node,
                               struct aiMatrix4x4 model_from_parent) {
    struct aiMatrix4x4 model_from_node = model_from_parent;
    aiMultiplyMatrix4(&model_from_node, &node->mTransformation);
    enum ap_status st = AP_OK;
    for (unsigned i = 0; i < node->mNumMeshes && !st; i++)
        st = add_mesh(in, in->scene->mMeshes[node->mMeshes[i]], &model_from_node);
    for (unsigned i = 0; i < node->mNumChildren && !st; i++)
        st = add_node(in, node->mChildren[i], model_from_node);
    return st;
}

static enum ap_status add_model(struct importer *in) {
    if (!in->scene->mRootNode)
        return ap_fail(in->err, AP_INPUT, "%s: no model in it", in->request->path);
    enum ap_status st = count_node(in, in->scene->mRootNode, 0);
    struct aiMatrix4x4 identity;
    aiIdentityMatrix4(&identity);
    size_t before = in->build->scene->part_count;
    if (!st)
        st = add_node(in, in->scene->mRootNode, identity);
    if (!st && !in->build->out_of_memory && in->build->scene->part_count == before)
        st = ap_fail(in->err, AP_INPUT, "%s: no triangles in it", in->request->path);
    return st;
}

enum ap_status ap_import_model(struct ap_error *err, struct ap_scene_build *build,
                               const struct ap_model_request *request) {
    const char *format = format_of(request->path);
    if (!format)
        return ap_fail(err, AP_INPUT, "%s: expected a .glb, .gltf, .obj, .ply, .stl, .off or .dae",
                       request->path);
    char *bytes;
    size_t len;
    enum ap_status st = ap_file_read(err, request->path, MAX_FILE_BYTES, &bytes, &len);
    if (st)
        return st;
    if (len == 0) {
        free(bytes);
        return ap_fail(err, AP_INPUT, "%s: the file is empty", request->path);
    }
    const struct aiScene *scene = aiImportFileFromMemory(
        bytes, (unsigned)len,
        aiProcess_Triangulate | aiProcess_GenSmoothNormals | aiProcess_SortByPType |
            aiProcess_ValidateDataStructure | aiProcess_JoinIdenticalVertices,
        format);
    free(bytes);
    if (!scene)
        return ap_fail(err, AP_INPUT, "%s: not a model that can be read: %s", request->path,
                       aiGetErrorString());
    struct importer in = {.err = err, .build = build, .request = request, .scene = scene};
    st = add_model(&in);
    aiReleaseImport(scene);
    return st;
}
