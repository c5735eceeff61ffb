#include <stdlib.h>
#include <string.h>

#include "sim_hmd/core/session.h"
#include "sim_hmd/ext/messages.h"

// XR_EXT_debug_utils: messages that programs submit go to their messengers, with the names of the
// objects and the session's labels. messages.h has what the runtime itself says to them.

struct messenger {
    struct sim_object object;
    struct sim_messenger messenger;
};

static bool severities_valid(XrDebugUtilsMessageSeverityFlagsEXT flags) {
    const XrDebugUtilsMessageSeverityFlagsEXT all =
        XR_DEBUG_UTILS_MESSAGE_SEVERITY_VERBOSE_BIT_EXT |
        XR_DEBUG_UTILS_MESSAGE_SEVERITY_INFO_BIT_EXT |
        XR_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
        XR_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    return flags && !(flags & ~all);
}

static bool types_valid(XrDebugUtilsMessageTypeFlagsEXT flags) {
    const XrDebugUtilsMessageTypeFlagsEXT all = XR_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT |
                                                XR_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                                                XR_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT |
                                                XR_DEBUG_UTILS_MESSAGE_TYPE_CONFORMANCE_BIT_EXT;
    return flags && !(flags & ~all);
}

static void free_messenger(struct sim_object *object) {
    sim_messenger_forget(&((struct messenger *)object)->messenger);
    free(object);
}

XrResult XRAPI_CALL xrCreateDebugUtilsMessengerEXT(XrInstance handle,
                                                   const XrDebugUtilsMessengerCreateInfoEXT *info,
                                                   XrDebugUtilsMessengerEXT *out) {
    SIM_LOCKED;
    struct sim_instance *instance = sim_instance_get(handle);
    if (!instance)
        return XR_ERROR_HANDLE_INVALID;
    if (!sim_is(info, XR_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT) || !out)
        return XR_ERROR_VALIDATION_FAILURE;
    struct sim_messenger messenger;
    XrResult result = sim_messenger_init(info, &messenger);
    if (result != XR_SUCCESS)
        return result;
    struct messenger *m = calloc(1, sizeof *m);
    if (!m)
        return XR_ERROR_OUT_OF_MEMORY;
    m->messenger = messenger;
    if (!sim_object_add(&m->object, SIM_DEBUG_MESSENGER, &instance->object, free_messenger)) {
        free(m);
        return XR_ERROR_LIMIT_REACHED;
    }
    sim_messenger_begin(&m->messenger);
    *out = SIM_HANDLE(XrDebugUtilsMessengerEXT, m);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL xrDestroyDebugUtilsMessengerEXT(XrDebugUtilsMessengerEXT handle) {
    SIM_LOCKED;
    struct messenger *m = sim_object_get(sim_raw(handle), SIM_DEBUG_MESSENGER);
    if (!m)
        return XR_ERROR_HANDLE_INVALID;
    sim_object_destroy(&m->object);
    return XR_SUCCESS;
}

static const struct {
    XrObjectType xr;
    enum sim_type type;
} object_types[] = {
    {XR_OBJECT_TYPE_INSTANCE, SIM_INSTANCE},
    {XR_OBJECT_TYPE_SESSION, SIM_SESSION},
    {XR_OBJECT_TYPE_SWAPCHAIN, SIM_SWAPCHAIN},
    {XR_OBJECT_TYPE_SPACE, SIM_SPACE},
    {XR_OBJECT_TYPE_ACTION_SET, SIM_ACTION_SET},
    {XR_OBJECT_TYPE_ACTION, SIM_ACTION},
    {XR_OBJECT_TYPE_HAND_TRACKER_EXT, SIM_HAND_TRACKER},
    {XR_OBJECT_TYPE_DEBUG_UTILS_MESSENGER_EXT, SIM_DEBUG_MESSENGER},
};

// A live object of this type that belongs to the instance.
static struct sim_object *object_of(const struct sim_instance *instance, XrObjectType type,
                                    uint64_t handle) {
    struct sim_object *object = NULL;
    for (size_t i = 0; i < sizeof object_types / sizeof *object_types; i++)
        if (object_types[i].xr == type)
            object = sim_object_get(handle, object_types[i].type);
    const struct sim_object *root = object;
    while (root && root->parent)
        root = root->parent;
    return root == &instance->object ? object : NULL;
}

// Names of objects that are gone make room, before there is more of it.
static void forget_dead(struct sim_instance *instance) {
    struct sim_names *names = &instance->names;
    for (uint32_t i = names->count; names->count == names->capacity && i-- > 0;)
        if (!object_of(instance, names->at[i].type, names->at[i].handle))
            sim_names_set(names, names->at[i].type, names->at[i].handle, NULL);
}

XrResult XRAPI_CALL xrSetDebugUtilsObjectNameEXT(XrInstance handle,
                                                 const XrDebugUtilsObjectNameInfoEXT *info) {
    SIM_LOCKED;
    struct sim_instance *instance = sim_instance_get(handle);
    if (!instance)
        return XR_ERROR_HANDLE_INVALID;
    if (!sim_is(info, XR_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT) ||
        info->objectType == XR_OBJECT_TYPE_UNKNOWN || !info->objectHandle)
        return XR_ERROR_VALIDATION_FAILURE;
    if (!object_of(instance, info->objectType, info->objectHandle))
        return XR_ERROR_HANDLE_INVALID;
    forget_dead(instance);
    return sim_names_set(&instance->names, info->objectType, info->objectHandle, info->objectName);
}

// A message with all it points to, so that the lock need not be held while programs' callbacks run,
// which may call the runtime.
struct message {
    XrDebugUtilsMessengerCallbackDataEXT data;
    XrDebugUtilsObjectNameInfoEXT *objects;
    XrDebugUtilsLabelEXT *labels;
    struct sim_messenger *to; // copies
    uint32_t to_count;
};

static void finish(struct message *m) {
    for (uint32_t i = 0; m->objects && i < m->data.objectCount; i++)
        free((void *)(uintptr_t)m->objects[i].objectName);
    for (uint32_t i = 0; m->labels && i < m->data.sessionLabelCount; i++)
        free((void *)(uintptr_t)m->labels[i].labelName);
    free(m->objects);
    free(m->labels);
    free(m->to);
}

// The runtime's names of the objects, the program's own where there are none.
static bool copy_objects(const struct sim_instance *instance,
                         const XrDebugUtilsMessengerCallbackDataEXT *data, struct message *m) {
    m->objects = calloc(data->objectCount ? data->objectCount : 1, sizeof *m->objects);
    if (!m->objects)
        return false;
    for (uint32_t i = 0; i < data->objectCount; i++) {
        m->objects[i] = data->objects[i];
        m->objects[i].next = NULL;
        const char *name = sim_names_get(&instance->names, data->objects[i].objectType,
                                         data->objects[i].objectHandle);
        name = name ? name : data->objects[i].objectName;
        m->objects[i].objectName = name ? strdup(name) : NULL;
    }
    m->data.objects = m->objects;
    return true;
}

// The labels of the session among the objects, the newest first; those submitted where there is
// none.
static bool copy_labels(const struct sim_instance *instance,
                        const XrDebugUtilsMessengerCallbackDataEXT *data, struct message *m) {
    const struct sim_session *session = NULL;
    for (uint32_t i = 0; !session && i < data->objectCount; i++)
        if (data->objects[i].objectType == XR_OBJECT_TYPE_SESSION)
            session = (const struct sim_session *)object_of(instance, XR_OBJECT_TYPE_SESSION,
                                                            data->objects[i].objectHandle);
    uint32_t count = session ? session->labels.count : data->sessionLabelCount;
    m->labels = calloc(count ? count : 1, sizeof *m->labels);
    if (!m->labels)
        return false;
    for (uint32_t i = 0; i < count; i++) {
        const char *text =
            session ? session->labels.text[count - 1 - i] : data->sessionLabels[i].labelName;
        m->labels[i] = (XrDebugUtilsLabelEXT){.type = XR_TYPE_DEBUG_UTILS_LABEL_EXT,
                                              .labelName = text ? strdup(text) : NULL};
    }
    m->data.sessionLabelCount = count;
    m->data.sessionLabels = m->labels;
    return true;
}

static bool copy_messengers(const struct sim_instance *instance,
                            XrDebugUtilsMessageSeverityFlagsEXT severity,
                            XrDebugUtilsMessageTypeFlagsEXT types, struct message *m) {
    uint32_t count = 0;
    for (const struct sim_object *o = instance->object.first_child; o; o = o->next)
        count += o->type == SIM_DEBUG_MESSENGER;
    m->to = calloc(count ? count : 1, sizeof *m->to);
    if (!m->to)
        return false;
    for (const struct sim_object *o = instance->object.first_child; o; o = o->next) {
        if (o->type != SIM_DEBUG_MESSENGER)
            continue;
        const struct sim_messenger *to = &((const struct messenger *)o)->messenger;
        if (to->severities & severity && to->types & types)
            m->to[m->to_count++] = *to;
    }
    return true;
}

static XrResult take_message(XrInstance handle, XrDebugUtilsMessageSeverityFlagsEXT severity,
                             XrDebugUtilsMessageTypeFlagsEXT types,
                             const XrDebugUtilsMessengerCallbackDataEXT *data, struct message *m) {
    SIM_LOCKED;
    const struct sim_instance *instance = sim_instance_get(handle);
    if (!instance)
        return XR_ERROR_HANDLE_INVALID;
    if (!severities_valid(severity) || !types_valid(types) ||
        !sim_is(data, XR_TYPE_DEBUG_UTILS_MESSENGER_CALLBACK_DATA_EXT) || !data->message ||
        (data->objectCount && !data->objects) || (data->sessionLabelCount && !data->sessionLabels))
        return XR_ERROR_VALIDATION_FAILURE;
    m->data = *data;
    m->data.next = NULL;
    m->data.sessionLabelCount = 0;
    if (copy_messengers(instance, severity, types, m) && copy_objects(instance, data, m) &&
        copy_labels(instance, data, m))
        return XR_SUCCESS;
    return XR_ERROR_OUT_OF_MEMORY;
}

XrResult XRAPI_CALL xrSubmitDebugUtilsMessageEXT(XrInstance handle,
                                                 XrDebugUtilsMessageSeverityFlagsEXT severity,
                                                 XrDebugUtilsMessageTypeFlagsEXT types,
                                                 const XrDebugUtilsMessengerCallbackDataEXT *data) {
    struct message m = {0};
    XrResult result = take_message(handle, severity, types, data, &m);
    for (uint32_t i = 0; result == XR_SUCCESS && i < m.to_count; i++)
        m.to[i].callback(severity, types, &m.data, m.to[i].user);
    finish(&m);
    return result;
}

static XrResult add_label(XrSession handle, const XrDebugUtilsLabelEXT *label, bool single) {
    struct sim_session *session;
    XrResult result = sim_session_get(handle, &session);
    if (result != XR_SUCCESS)
        return result;
    if (!sim_is(label, XR_TYPE_DEBUG_UTILS_LABEL_EXT) || !label->labelName)
        return XR_ERROR_VALIDATION_FAILURE;
    return sim_labels_push(&session->labels, label->labelName, single);
}

XrResult XRAPI_CALL xrSessionBeginDebugUtilsLabelRegionEXT(XrSession handle,
                                                           const XrDebugUtilsLabelEXT *label) {
    SIM_LOCKED;
    return add_label(handle, label, false);
}

XrResult XRAPI_CALL xrSessionInsertDebugUtilsLabelEXT(XrSession handle,
                                                      const XrDebugUtilsLabelEXT *label) {
    SIM_LOCKED;
    return add_label(handle, label, true);
}

XrResult XRAPI_CALL xrSessionEndDebugUtilsLabelRegionEXT(XrSession handle) {
    SIM_LOCKED;
    struct sim_session *session;
    XrResult result = sim_session_get(handle, &session);
    if (result == XR_SUCCESS)
        sim_labels_pop(&session->labels);
    return result;
}

const struct sim_function sim_functions_EXT_debug_utils[] = {
    SIM_FUNCTION(xrSetDebugUtilsObjectNameEXT),
    SIM_FUNCTION(xrCreateDebugUtilsMessengerEXT),
    SIM_FUNCTION(xrDestroyDebugUtilsMessengerEXT),
    SIM_FUNCTION(xrSubmitDebugUtilsMessageEXT),
    SIM_FUNCTION(xrSessionBeginDebugUtilsLabelRegionEXT),
    SIM_FUNCTION(xrSessionEndDebugUtilsLabelRegionEXT),
    SIM_FUNCTION(xrSessionInsertDebugUtilsLabelEXT),
    {0},
};
