#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/uio.h>
#include <unistd.h>

#include "sim_hmd/core/instance.h"
#include "sim_hmd/strict/call.h"

// The arguments of a call against the tables of functions and structures: the implicit valid
// usage of the specification, named as the specification and the core validation layer name it.

// Longer arrays and chains are not believed: such a count is more likely wrong than the array.
enum { MAX_ELEMENTS = 1024, MAX_CHAIN = 32, STATEMENT = 160 };

// A found statement: "VUID-" owner "-" member "-" kind.
static void found(struct sim_strict_call *call, const char *owner, const char *member,
                  const char *kind, const char *format, ...) AP_PRINTF(5, 6);
static void found(struct sim_strict_call *call, const char *owner, const char *member,
                  const char *kind, const char *format, ...) {
    char statement[STATEMENT], values[256];
    snprintf(statement, sizeof statement, "VUID-%s-%s-%s", owner, member, kind);
    va_list args;
    va_start(args, format);
    vsnprintf(values, sizeof values, format, args);
    va_end(args);
    sim_strict_found(call, SIM_ERROR, statement, "%s", values);
}

static struct sim_object *ancestor(struct sim_object *object, enum sim_type type) {
    while (object && object->type != type)
        object = object->parent;
    return object;
}

// The object that the call is about: its first handle. The runtime's lock is held.
static struct sim_object *subject(const struct sim_strict_call *call) {
    const struct sim_param *p = &call->function->params[0];
    return p->kind == PARAM_HANDLE ? sim_object_get(call->v[0], p->object) : NULL;
}

// Both under one session, or where one is above sessions under one instance.
static bool related(struct sim_object *a, struct sim_object *b) {
    struct sim_object *s = ancestor(a, SIM_SESSION), *t = ancestor(b, SIM_SESSION);
    return s && t ? s == t : ancestor(a, SIM_INSTANCE) == ancestor(b, SIM_INSTANCE);
}

// NULL: there is nothing to say. Takes the lock for a moment.
static const char *handle_fault(const struct sim_strict_call *call, uint64_t handle,
                                enum sim_type type) {
    SIM_LOCKED;
    struct sim_object *object = sim_object_get(handle, type), *about = subject(call);
    if (!handle)
        return "XR_NULL_HANDLE";
    if (!object)
        return "not a live handle of this type";
    return about && !related(about, object) ? "of another session or instance" : NULL;
}

static void check_handle(struct sim_strict_call *call, const char *owner, const char *member,
                         uint64_t handle, enum sim_type type, bool optional) {
    const char *fault = optional && !handle ? NULL : handle_fault(call, handle, type);
    if (fault)
        found(call, owner, member, "parameter", "%s is 0x%llx: %s", member,
              (unsigned long long)handle, fault);
}

static bool path_known(const struct sim_strict_call *call, XrPath path, char *text, size_t size) {
    SIM_LOCKED;
    const struct sim_instance *instance =
        (const struct sim_instance *)ancestor(subject(call), SIM_INSTANCE);
    const char *known = instance ? sim_path_text(&instance->paths, path) : "";
    snprintf(text, size, "%s", known ? known : "");
    return known;
}

static void check_path(struct sim_strict_call *call, const char *owner, const char *name,
                       XrPath path, bool optional) {
    char text[XR_MAX_PATH_LENGTH];
    if ((path == XR_NULL_PATH && optional) || path_known(call, path, text, sizeof text))
        return;
    char statement[STATEMENT];
    snprintf(statement, sizeof statement,
             "XR_ERROR_PATH_INVALID: %s::%s is a path of xrStringToPath", owner, name);
    sim_strict_found(call, SIM_ERROR, statement, "%s is %llu", name, (unsigned long long)path);
}

static void check_structure(struct sim_strict_call *call, const struct sim_spec *spec,
                            const void *structure);

static bool may_extend(const struct sim_spec *part, const struct sim_spec *whole) {
    if (!part->extends)
        return false;
    return strstr(part->extends, whole->name) ||
           (strstr(part->extends, "XrCompositionLayerBaseHeader") &&
            strncmp(whole->name, "XrCompositionLayer", 18) == 0);
}

static void check_link(struct sim_strict_call *call, const struct sim_spec *spec,
                       const XrBaseInStructure *link) {
    const char *name = sim_structure_name(link->type), *needs = sim_extension_of(link->type);
    const struct sim_spec *part = sim_spec_find(link->type);
    if (!name && !needs && (link->type < 1000000000 || link->type == XR_STRUCTURE_TYPE_MAX_ENUM))
        found(call, spec->name, "next", "next", "a structure of unknown type %d in the chain",
              (int)link->type);
    else if (needs && !sim_strict_enabled(needs))
        found(call, spec->name, "next", "next", "%s (type %d) is of %s, which is not enabled",
              name ? name : "a structure", (int)link->type, needs);
    else if ((part && !may_extend(part, spec)) || (!part && name && link->type < 1000000000))
        found(call, spec->name, "next", "next", "%s does not belong into the chain of %s", name,
              spec->name);
    else if (part && part->members->kind)
        check_structure(call, part, link);
}

// A `next` that was never set is the commonest fault of all, and must not end the program here.
static bool readable(const void *memory, size_t size) {
    char copy[sizeof(XrBaseInStructure)];
    struct iovec to = {copy, size < sizeof copy ? size : sizeof copy};
    struct iovec from = {(void *)(uintptr_t)memory, to.iov_len};
    return process_vm_readv(getpid(), &to, 1, &from, 1, 0) >= 0 || errno != EFAULT;
}

static void check_chain(struct sim_strict_call *call, const struct sim_spec *spec,
                        const void *structure) {
    const XrBaseInStructure *first = ((const XrBaseInStructure *)structure)->next;
    int n = 0;
    for (const XrBaseInStructure *link = first; link && n < MAX_CHAIN; link = link->next, n++) {
        if (!readable(link, sizeof *link)) {
            found(call, spec->name, "next", "next", "next is %p, which is no memory: not set?",
                  (const void *)link);
            return;
        }
        for (const XrBaseInStructure *other = first; other != link; other = other->next)
            if (other->type == link->type) {
                found(call, spec->name, "next", "unique", "type %d stands twice in the chain",
                      (int)link->type);
                return;
            }
        check_link(call, spec, link);
    }
    if (n == MAX_CHAIN)
        found(call, spec->name, "next", "next", "the chain has no end");
}

// False: it is not what it should be, and nothing more of it is read.
static bool check_type(struct sim_strict_call *call, const struct sim_spec *spec,
                       const void *structure) {
    XrStructureType type = ((const XrBaseInStructure *)structure)->type;
    if (!spec->type || type == spec->type)
        return true;
    const char *name = sim_structure_name(type);
    found(call, spec->name, "type", "type", "type is %d (%s), not %d", (int)type,
          name ? name : "unknown", (int)spec->type);
    return false;
}

static void check_enum(struct sim_strict_call *call, const char *owner, const char *member,
                       const struct sim_values *values, int32_t value) {
    const char *name, *needs = sim_extension_of(value);
    if (!sim_value_known(values, value, &name))
        found(call, owner, member, "parameter", "%s is %d", member, value);
    else if (needs && !sim_strict_enabled(needs))
        found(call, owner, member, "parameter", "%s is %s, of %s, which is not enabled", member,
              name, needs);
}

static void check_flags(struct sim_strict_call *call, const struct sim_spec *spec,
                        const struct sim_member *m, uint64_t flags) {
    if (flags & ~m->mask)
        found(call, spec->name, m->name, "parameter", "%s is 0x%llx; 0x%llx is not defined",
              m->name, (unsigned long long)flags, (unsigned long long)(flags & ~m->mask));
    else if (!flags && !m->optional)
        found(call, spec->name, m->name, "requiredbitmask", "%s is 0", m->name);
}

static void check_floats(struct sim_strict_call *call, const char *owner, const char *name,
                         const float *f, size_t size, bool infinite_too) {
    for (size_t i = 0; i < size / sizeof *f; i++)
        if (isnan(f[i]) || (infinite_too && isinf(f[i]))) {
            char statement[STATEMENT];
            snprintf(statement, sizeof statement, "Floating point: %s::%s is finite", owner, name);
            sim_strict_found(call, SIM_ERROR, statement, "number %zu of %s is %g", i, name,
                             (double)f[i]);
            return;
        }
}

static void check_pose(struct sim_strict_call *call, const char *owner, const char *name,
                       const XrPosef *pose) {
    check_floats(call, owner, name, &pose->orientation.x, sizeof *pose, true);
    XrQuaternionf q = pose->orientation;
    double n = sqrt((double)q.x * q.x + (double)q.y * q.y + (double)q.z * q.z + (double)q.w * q.w);
    char statement[STATEMENT];
    if (fabs(n - 1) > 0.01) {
        snprintf(statement, sizeof statement, "XR_ERROR_POSE_INVALID: %s::%s has a unit quaternion",
                 owner, name);
        sim_strict_found(call, SIM_ERROR, statement, "(%g, %g, %g, %g) is %g long", (double)q.x,
                         (double)q.y, (double)q.z, (double)q.w, n);
    } else if (fabs(n - 1) > 1e-4) {
        snprintf(statement, sizeof statement, "USE-quaternion: %s::%s", owner, name);
        sim_strict_found(call, SIM_WARNING, statement,
                         "the quaternion is %g long; runtimes forgive 1 %%", n);
    }
}

static void check_fov(struct sim_strict_call *call, const struct sim_spec *spec,
                      const struct sim_member *m, const XrFovf *fov) {
    const float a[] = {fov->angleLeft, fov->angleRight, fov->angleUp, fov->angleDown};
    for (int i = 0; i < 4; i++)
        if (!(fabsf(a[i]) < 1.5707963f)) {
            char statement[STATEMENT];
            snprintf(statement, sizeof statement,
                     "XrFovf: %s::%s has angles between -pi/2 and pi/2", spec->name, m->name);
            sim_strict_found(call, SIM_ERROR, statement, "%g, %g, %g, %g", (double)a[0],
                             (double)a[1], (double)a[2], (double)a[3]);
            return;
        }
    if (a[0] >= a[1] || a[2] <= a[3])
        sim_strict_found(call, SIM_WARNING, "USE-fov-flipped",
                         "left %g, right %g, up %g, down %g: a mirrored or empty view",
                         (double)a[0], (double)a[1], (double)a[2], (double)a[3]);
}

static void check_layer(struct sim_strict_call *call, const struct sim_spec *spec,
                        const struct sim_member *m, const XrCompositionLayerBaseHeader *layer) {
    if (!layer) {
        found(call, spec->name, m->name, "parameter", "a layer is NULL");
        return;
    }
    const struct sim_spec *known = sim_spec_find(layer->type);
    const char *name = sim_structure_name(layer->type), *needs = sim_extension_of(layer->type);
    if (!name || strncmp(name, "XrCompositionLayer", 18) != 0)
        found(call, spec->name, m->name, "parameter", "a layer's type is %d (%s)", (int)layer->type,
              name ? name : "unknown");
    else if (needs && !sim_strict_enabled(needs))
        found(call, spec->name, m->name, "parameter", "%s is of %s, which is not enabled", name,
              needs);
    else if (known)
        check_structure(call, known, layer);
}

static void check_element(struct sim_strict_call *call, const struct sim_spec *spec,
                          const struct sim_member *m, const void *array, uint32_t i) {
    switch (m->kind) {
    case MEMBER_HANDLES:
        check_handle(call, spec->name, m->name, ((const uint64_t *)array)[i], m->object, false);
        break;
    case MEMBER_STRUCTS:
        check_structure(call, m->spec, (const char *)array + i * m->spec->size);
        break;
    case MEMBER_LAYERS:
        check_layer(call, spec, m, ((const XrCompositionLayerBaseHeader *const *)array)[i]);
        break;
    case MEMBER_PATHS:
        check_path(call, spec->name, m->name, ((const XrPath *)array)[i], m->optional);
        break;
    case MEMBER_NAMES:
        if (!((const char *const *)array)[i])
            found(call, spec->name, m->name, "parameter", "element %u is NULL", i);
        break;
    default:
        break;
    }
}

static void check_array(struct sim_strict_call *call, const struct sim_spec *spec,
                        const struct sim_member *m, const char *structure) {
    uint32_t count = *(const uint32_t *)(structure + m->count_offset);
    const void *array = *(const void *const *)(structure + m->offset);
    if (!count && !m->optional) {
        found(call, spec->name, m->name, "arraylength", "the count of %s is 0", m->name);
        return;
    }
    if (count && !array)
        found(call, spec->name, m->name, "parameter", "%s is NULL for %u elements", m->name, count);
    if (!array || count > (m->most ? m->most : MAX_ELEMENTS))
        return;
    for (uint32_t i = 0; i < count; i++)
        check_element(call, spec, m, array, i);
}

static void check_string(struct sim_strict_call *call, const struct sim_spec *spec,
                         const struct sim_member *m, const char *text) {
    if (strnlen(text, m->size) == m->size)
        found(call, spec->name, m->name, "parameter", "no end within %zu bytes", m->size);
}

static void check_member(struct sim_strict_call *call, const struct sim_spec *spec,
                         const struct sim_member *m, const char *structure) {
    const void *at = structure + m->offset;
    switch (m->kind) {
    case MEMBER_HANDLE:
        check_handle(call, spec->name, m->name, *(const uint64_t *)at, m->object, m->optional);
        break;
    case MEMBER_ENUM:
        check_enum(call, spec->name, m->name, m->values, *(const int32_t *)at);
        break;
    case MEMBER_FLAGS:
        check_flags(call, spec, m, *(const uint64_t *)at);
        break;
    case MEMBER_STRUCT:
        check_structure(call, m->spec, at);
        break;
    case MEMBER_CHARS:
        check_string(call, spec, m, at);
        break;
    case MEMBER_TEXT:
    case MEMBER_POINTER:
        if (!m->optional && !*(const void *const *)at)
            found(call, spec->name, m->name, "parameter", "%s is NULL", m->name);
        break;
    case MEMBER_FLOATS:
        check_floats(call, spec->name, m->name, at, m->size, false);
        break;
    case MEMBER_POSE:
        check_pose(call, spec->name, m->name, at);
        break;
    case MEMBER_FOV:
        check_fov(call, spec, m, at);
        break;
    case MEMBER_PATH:
        check_path(call, spec->name, m->name, *(const XrPath *)at, m->optional);
        break;
    case MEMBER_HANDLES:
    case MEMBER_STRUCTS:
    case MEMBER_LAYERS:
    case MEMBER_NAMES:
    case MEMBER_ITEMS:
    case MEMBER_PATHS:
        check_array(call, spec, m, structure);
        break;
    case MEMBER_TIME:
    case MEMBER_NUMBER:
    case MEMBER_END:
        break;
    }
}

static void check_structure(struct sim_strict_call *call, const struct sim_spec *spec,
                            const void *structure) {
    if (!check_type(call, spec, structure))
        return;
    if (spec->type && !spec->extends)
        check_chain(call, spec, structure);
    for (const struct sim_member *m = spec->members; m->kind; m++)
        check_member(call, spec, m, structure);
}

// The program's own structures to be filled in: the first ones, for a capacity may promise more.
static void check_out(struct sim_strict_call *call, const struct sim_param *p, const char *first,
                      uint32_t count) {
    for (uint32_t i = 0; i < count && i < 2; i++) {
        const char *structure = first + i * p->spec->size;
        if (check_type(call, p->spec, structure) && p->spec->type)
            check_chain(call, p->spec, structure);
    }
}

static void check_param(struct sim_strict_call *call, const struct sim_param *p, uint64_t v,
                        uint32_t capacity) {
    const char *function = call->function->name;
    const void *pointer = (const void *)(uintptr_t)v;
    bool array = p->kind == PARAM_OUT_ARRAY || p->kind == PARAM_ARRAY;
    bool pointed = array || p->kind == PARAM_IN || p->kind == PARAM_OUT ||
                   p->kind == PARAM_POINTER || p->kind == PARAM_STRING;
    if (pointed && !pointer) {
        if (!p->optional && (!array || capacity))
            found(call, function, p->name, "parameter", "%s is NULL", p->name);
        return;
    }
    if (p->kind == PARAM_HANDLE) {
        bool second = p != call->function->params;
        const char *fault = handle_fault(call, v, p->object);
        if (fault && second && strstr(fault, "another")) {
            char statement[STATEMENT];
            snprintf(statement, sizeof statement, "VUID-%s-commonparent", function);
            sim_strict_found(call, SIM_ERROR, statement, "%s is %s", p->name, fault);
        } else
            check_handle(call, function, p->name, v, p->object, false);
    } else if (p->kind == PARAM_ENUM)
        check_enum(call, function, p->name, p->values, (int32_t)v);
    else if (p->kind == PARAM_PATH)
        check_path(call, function, p->name, v, p->optional);
    else if (p->kind == PARAM_FLOATS)
        check_floats(call, function, p->name, pointer, p->size, true);
    else if (p->kind == PARAM_POSE)
        check_pose(call, function, p->name, pointer);
    else if (p->kind == PARAM_IN)
        check_structure(call, p->spec, pointer);
    else if (p->kind == PARAM_OUT || p->kind == PARAM_OUT_ARRAY)
        check_out(call, p, pointer, p->kind == PARAM_OUT ? 1 : capacity);
}

void sim_strict_check(struct sim_strict_call *call) {
    uint32_t capacity = 0;
    for (int i = 0; i < call->function->count; i++) {
        if (call->function->params[i].kind == PARAM_CAPACITY)
            capacity = (uint32_t)call->v[i];
        check_param(call, &call->function->params[i], call->v[i], capacity);
    }
}
