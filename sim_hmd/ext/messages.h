#ifndef ANTIPODE_SIM_HMD_EXT_MESSAGES_H
#define ANTIPODE_SIM_HMD_EXT_MESSAGES_H

#include <openxr/openxr.h>

// What the runtime itself says to the messengers of XR_EXT_debug_utils: the lines of its log (type
// general) and the findings of the lint (type validation). A message waits until the runtime's lock
// is given up, for a callback may call the runtime. Any thread.

struct sim_messenger {
    struct sim_messenger *next;
    XrDebugUtilsMessageSeverityFlagsEXT severities;
    XrDebugUtilsMessageTypeFlagsEXT types;
    PFN_xrDebugUtilsMessengerCallbackEXT callback;
    void *user;
};

// XR_ERROR_VALIDATION_FAILURE.
XrResult sim_messenger_init(const XrDebugUtilsMessengerCreateInfoEXT *info,
                            struct sim_messenger *messenger);

// Between the two calls it hears the runtime.
void sim_messenger_begin(struct sim_messenger *messenger);
// What waits for it is delivered all the same; after sim_messenger_forget it is not.
void sim_messenger_end(struct sim_messenger *messenger);
void sim_messenger_forget(struct sim_messenger *messenger);

// id: of the kind of message. Texts are copied, and cut at 600 bytes. Dropped where 64 wait.
void sim_message(XrDebugUtilsMessageSeverityFlagsEXT severity, XrDebugUtilsMessageTypeFlagsEXT type,
                 const char *id, const char *function, const char *text);

#endif
