#include "src/scene/build.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "src/base/log.h"
#include "src/scene/import.h"
#include "src/scene/simplify.h"

// The importer is a large library that ends the process when a file breaks its assumptions (an
// empty file does). So a process of its own reads the model and sends what it found through a pipe;
// if it dies or takes too long, that is an input error here, and what comes through is checked like
// a file.
enum { MAX_SOLIDS = 100000, CPU_LIMIT_S = 60 };
#define MEMORY_LIMIT ((rlim_t)3 << 30)

struct reply {
    enum ap_status status;
    struct ap_error why;
    size_t solids, triangles; // triangles: in the file
};

struct solid_head {
    unsigned rgb;
    size_t vertex_count, index_count;
};

static bool send_all(int fd, const void *bytes, size_t len) {
    for (const char *p = bytes; len > 0;) {
        ssize_t n = write(fd, p, len);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return false;
        p += n;
        len -= (size_t)n;
    }
    return true;
}

static bool receive_all(int fd, void *bytes, size_t len) {
    for (char *p = bytes; len > 0;) {
        ssize_t n = read(fd, p, len);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return false;
        p += n;
        len -= (size_t)n;
    }
    return true;
}

static bool send_solid(int fd, const struct ap_scene *scene, const struct ap_part *part) {
    const struct ap_solid *s = &scene->solids[part->solid];
    struct solid_head head;
    memset(&head, 0, sizeof head);
    head.rgb = ap_color_rgb(part->color_srgb);
    head.vertex_count = s->vertex_count;
    head.index_count = s->index_count;
    return send_all(fd, &head, sizeof head) &&
           send_all(fd, s->positions, 3 * s->vertex_count * sizeof *s->positions) &&
           send_all(fd, s->normals, 3 * s->vertex_count * sizeof *s->normals) &&
           send_all(fd, s->indices, s->index_count * sizeof *s->indices);
}

// A file may claim any number of vertices: what the process may use beyond what it has is bounded.
static void limit_resources(void) {
    struct rlimit cpu = {CPU_LIMIT_S, CPU_LIMIT_S}, no_core = {0, 0};
    setrlimit(RLIMIT_CPU, &cpu);
    setrlimit(RLIMIT_CORE, &no_core);
    unsigned long long size, resident, shared, text, lib, data;
    FILE *f = fopen("/proc/self/statm", "r");
    if (!f)
        return;
    if (fscanf(f, "%llu %llu %llu %llu %llu %llu", &size, &resident, &shared, &text, &lib, &data) ==
        6) {
        rlim_t most = data * (rlim_t)sysconf(_SC_PAGESIZE) + MEMORY_LIMIT;
        struct rlimit memory = {most, most};
        setrlimit(RLIMIT_DATA, &memory);
    }
    fclose(f);
}

// Each solid gets the same share of its size. What cannot be simplified stays.
static void keep_to_budget(struct ap_scene *scene, size_t from_part, size_t most_bytes) {
    size_t bytes = 0;
    for (size_t i = from_part; i < scene->part_count; i++)
        bytes += ap_solid_bytes(&scene->solids[scene->parts[i].solid]);
    double share = bytes > most_bytes ? (double)most_bytes / (double)bytes : 1;
    for (size_t i = from_part; share < 1 && i < scene->part_count; i++) {
        struct ap_solid *solid = &scene->solids[scene->parts[i].solid];
        ap_solid_simplify(solid, (size_t)(share * (double)ap_solid_bytes(solid)));
    }
}

static size_t count_triangles(const struct ap_scene *scene, size_t from_part) {
    size_t count = 0;
    for (size_t i = from_part; i < scene->part_count; i++)
        count += scene->solids[scene->parts[i].solid].index_count / 3;
    return count;
}

// In the process of its own; never returns.
static _Noreturn void import_and_send(int fd, struct ap_scene_build *build,
                                      const struct ap_model_request *request) {
    limit_resources();
    int null = open("/dev/null", O_WRONLY); // the importer's last words are not for people
    if (null >= 0)
        dup2(null, STDERR_FILENO);
    struct reply reply;
    memset(&reply, 0, sizeof reply);
    size_t before = build->scene->part_count;
    reply.status = ap_import_model(&reply.why, build, request);
    if (!reply.status && build->out_of_memory)
        reply.status = ap_fail(&reply.why, AP_ENVIRONMENT, "out of memory for %s", request->path);
    reply.solids = reply.status ? 0 : build->scene->part_count - before;
    if (!reply.status) {
        reply.triangles = count_triangles(build->scene, before);
        keep_to_budget(build->scene, before, request->most_bytes);
    }
    bool sent = send_all(fd, &reply, sizeof reply);
    for (size_t i = 0; i < reply.solids && sent; i++)
        sent = send_solid(fd, build->scene, &build->scene->parts[before + i]);
    _exit(sent ? 0 : 1);
}

static bool sound(const struct ap_solid *s, double most_m) {
    for (size_t i = 0; i < 3 * s->vertex_count; i++)
        if (!(fabs((double)s->positions[i]) <= most_m) || !(fabsf(s->normals[i]) <= 1.001F))
            return false;
    for (size_t i = 0; i < s->index_count; i++)
        if (s->indices[i] >= s->vertex_count)
            return false;
    return true;
}

static bool receive_solid(int fd, struct ap_scene_build *build,
                          const struct ap_model_request *request, size_t *vertices) {
    struct solid_head head;
    if (!receive_all(fd, &head, sizeof head))
        return false;
    *vertices += head.vertex_count;
    if (head.vertex_count > AP_MODEL_MAX_VERTICES || *vertices > AP_MODEL_MAX_VERTICES ||
        head.index_count > 6 * (size_t)AP_MODEL_MAX_VERTICES)
        return false;
    struct ap_mesh mesh = {0};
    ap_mesh_reserve(&mesh, head.vertex_count, head.index_count);
    struct ap_solid *s = &mesh.solid;
    bool good = !mesh.out_of_memory &&
                receive_all(fd, s->positions, 3 * s->vertex_count * sizeof *s->positions) &&
                receive_all(fd, s->normals, 3 * s->vertex_count * sizeof *s->normals) &&
                receive_all(fd, s->indices, s->index_count * sizeof *s->indices) &&
                sound(s, ap_model_reach(build->scene->space));
    if (!good) {
        ap_mesh_finish(&mesh);
        return false;
    }
    ap_mesh_measure(&mesh);
    struct ap_part part =
        ap_solid_part(request->place, ap_build_solid(build, &mesh), head.rgb & 0xffffff);
    part.lit = request->lit;
    ap_build_part(build, part);
    return true;
}

static enum ap_status receive_model(struct ap_error *err, int fd, struct ap_scene_build *build,
                                    const struct ap_model_request *request) {
    struct reply reply;
    size_t vertices = 0, before = build->scene->part_count;
    bool good = receive_all(fd, &reply, sizeof reply) && reply.solids <= MAX_SOLIDS;
    if (good && reply.status != AP_OK) {
        reply.why.text[AP_ERROR_TEXT_MAX - 1] = '\0';
        return ap_fail(err, reply.status == AP_ENVIRONMENT ? AP_ENVIRONMENT : AP_INPUT, "%s",
                       reply.why.text);
    }
    for (size_t i = 0; good && i < reply.solids; i++)
        good = receive_solid(fd, build, request, &vertices);
    if (!good)
        return ap_fail(err, AP_INPUT,
                       "%s: reading it failed or took more than %d s: the file is damaged, or too "
                       "large",
                       request->path, CPU_LIMIT_S);
    size_t kept = count_triangles(build->scene, before);
    if (kept < reply.triangles && !build->out_of_memory)
        ap_log(
            AP_LOG_WARNING,
            "%s: the budget of %.3g MiB has room for %zu of its %zu triangles: it is drawn coarser "
            "(give a larger --budget)",
            request->path, (double)ap_scene_budget(build->scene) / 1048576, kept, reply.triangles);
    return AP_OK;
}

enum ap_status ap_build_model(struct ap_error *err, struct ap_scene_build *build,
                              const struct ap_model_request *request) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC))
        return ap_fail(err, AP_ENVIRONMENT, "no pipe to read a model through: %s", strerror(errno));
    pid_t child = fork();
    if (child == 0) {
        close(ends[0]);
        import_and_send(ends[1], build, request);
    }
    int why = errno;
    close(ends[1]);
    enum ap_status st =
        child < 0 ? ap_fail(err, AP_ENVIRONMENT, "no process to read a model: %s", strerror(why))
                  : receive_model(err, ends[0], build, request);
    close(ends[0]); // a child that still writes ends by it
    while (child > 0 && waitpid(child, NULL, 0) < 0 && errno == EINTR)
        continue;
    return st;
}
