#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "sim_hmd/core/instance.h"
#include "sim_hmd/strict/call.h"

// What a call was given, in a line for people.

struct text {
    char *at;
    size_t left;
};

static void put(struct text *text, const char *format, ...) AP_PRINTF(2, 3);
static void put(struct text *text, const char *format, ...) {
    va_list args;
    va_start(args, format);
    int n = vsnprintf(text->at, text->left, format, args);
    va_end(args);
    size_t used = n < 0 ? 0 : (size_t)n < text->left ? (size_t)n : text->left ? text->left - 1 : 0;
    text->at += used;
    text->left -= used;
}

static void put_path(struct text *text, const struct sim_strict_call *call, XrPath path) {
    SIM_LOCKED;
    const struct sim_param *p = &call->function->params[0];
    struct sim_object *o = p->kind == PARAM_HANDLE ? sim_object_get(call->v[0], p->object) : NULL;
    while (o && o->parent)
        o = o->parent;
    const char *known = o && o->type == SIM_INSTANCE
                            ? sim_path_text(&((struct sim_instance *)o)->paths, path)
                            : NULL;
    if (known)
        put(text, "\"%s\"", known);
    else
        put(text, "%llu", (unsigned long long)path);
}

static int64_t number(const void *at, size_t size) {
    if (size == 8)
        return *(const int64_t *)at;
    return size == 4 ? *(const int32_t *)at : *(const int8_t *)at;
}

static void put_pose(struct text *text, const XrPosef *p) {
    put(text, "(%g %g %g %g; %g %g %g)", (double)p->orientation.x, (double)p->orientation.y,
        (double)p->orientation.z, (double)p->orientation.w, (double)p->position.x,
        (double)p->position.y, (double)p->position.z);
}

static void put_structure(struct text *text, const struct sim_strict_call *call,
                          const struct sim_spec *spec, const void *structure);

static void put_member(struct text *text, const struct sim_strict_call *call,
                       const struct sim_member *m, const char *structure) {
    const void *at = structure + m->offset;
    put(text, " %s ", m->name);
    switch (m->kind) {
    case MEMBER_HANDLE:
    case MEMBER_FLAGS:
        put(text, "0x%llx", *(const unsigned long long *)at);
        break;
    case MEMBER_PATH:
        put_path(text, call, *(const XrPath *)at);
        break;
    case MEMBER_CHARS:
        put(text, "\"%.*s\"", (int)m->size - 1, (const char *)at);
        break;
    case MEMBER_POSE:
        put_pose(text, at);
        break;
    case MEMBER_STRUCT:
        put_structure(text, call, m->spec, at);
        break;
    case MEMBER_ENUM:
    case MEMBER_TIME:
    case MEMBER_NUMBER:
        put(text, "%lld", (long long)number(at, m->size));
        break;
    case MEMBER_HANDLES:
    case MEMBER_STRUCTS:
    case MEMBER_LAYERS:
    case MEMBER_NAMES:
    case MEMBER_ITEMS:
    case MEMBER_PATHS:
        put(text, "[%u]", *(const uint32_t *)(structure + m->count_offset));
        break;
    default:
        put(text, "..");
    }
}

static void put_structure(struct text *text, const struct sim_strict_call *call,
                          const struct sim_spec *spec, const void *structure) {
    put(text, "{");
    if (spec->type && ((const XrBaseInStructure *)structure)->type != spec->type)
        put(text, " type %d", (int)((const XrBaseInStructure *)structure)->type);
    else
        for (const struct sim_member *m = spec->members; m->kind; m++)
            put_member(text, call, m, structure);
    put(text, " }");
}

static void put_param(struct text *text, const struct sim_strict_call *call, int i) {
    const struct sim_param *p = &call->function->params[i];
    const void *pointer = (const void *)(uintptr_t)call->v[i];
    put(text, "%s%s ", i ? ", " : "", p->name);
    if (p->kind == PARAM_IN && pointer)
        put_structure(text, call, p->spec, pointer);
    else if (p->kind == PARAM_STRING && pointer)
        put(text, "\"%.200s\"", (const char *)pointer);
    else if (p->kind == PARAM_PATH)
        put_path(text, call, call->v[i]);
    else if (p->kind == PARAM_POSE)
        put_pose(text, pointer);
    else if (p->kind == PARAM_FLOATS)
        for (size_t k = 0; k < p->size / sizeof(float); k++)
            put(text, k ? " %g" : "%g", (double)((const float *)pointer)[k]);
    else if (p->kind == PARAM_HANDLE)
        put(text, "0x%llx", (unsigned long long)call->v[i]);
    else if (p->kind == PARAM_VALUE || p->kind == PARAM_CAPACITY || p->kind == PARAM_ENUM)
        put(text, "%lld", (long long)call->v[i]);
    else
        put(text, pointer ? "given" : "NULL");
}

void sim_strict_describe(const struct sim_strict_call *call, char *text, size_t size) {
    struct text t = {text, size};
    text[0] = '\0';
    for (int i = 0; i < call->function->count; i++)
        put_param(&t, call, i);
}
