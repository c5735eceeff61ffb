#ifndef ANTIPODE_SIM_HMD_STRICT_CALL_H
#define ANTIPODE_SIM_HMD_STRICT_CALL_H

#include "sim_hmd/core/handles.h"
#include "sim_hmd/ext/extensions.h"
#include "sim_hmd/strict/strict.h"

// What the parts of the lint know of one another; nobody else includes this.

struct sim_values {
    const int32_t *values;
    const char *const *names;
    size_t count;
};
// NULL: the value has no name. A number of an extension that this header does not know is not
// judged: true, "".
bool sim_value_known(const struct sim_values *values, int64_t value, const char **name);
const char *sim_result_name(XrResult result);

enum sim_member_kind {
    MEMBER_END,
    MEMBER_HANDLE,  // of an object of this type
    MEMBER_HANDLES, // an array of them
    MEMBER_ENUM,
    MEMBER_FLAGS,
    MEMBER_STRUCT,  // within this one
    MEMBER_STRUCTS, // an array of them
    MEMBER_LAYERS,  // an array of pointers to structures of any type
    MEMBER_CHARS,   // char[n] that ends within
    MEMBER_TEXT,    // a pointer to a string
    MEMBER_NAMES,   // an array of those
    MEMBER_ITEMS,   // an array of anything
    MEMBER_POINTER, // not NULL
    MEMBER_FLOATS,
    MEMBER_POSE,
    MEMBER_FOV,
    MEMBER_PATH,
    MEMBER_PATHS,
    MEMBER_TIME,
    MEMBER_NUMBER, // for messages only
};

struct sim_member {
    const char *name;
    enum sim_member_kind kind;
    bool optional;
    enum sim_type object;
    size_t offset, size, count_offset; // count_offset: where an array's length stands
    uint32_t most;                     // elements, where more are refused without a look at them
    uint64_t mask;
    const struct sim_values *values;
    const struct sim_spec *spec;
};

// A structure of the specification.
struct sim_spec {
    const char *name;
    XrStructureType type; // 0: it has none, and no chain
    size_t size;
    const char *extends; // whose chains it may stand in; NULL: none
    const struct sim_member *members;
};
const struct sim_spec *sim_spec_find(XrStructureType type); // NULL: not in the table
const char *sim_structure_name(XrStructureType type);       // NULL: the header does not know it
// The extension that a value belongs to by its number (1000nnnvvv); NULL: core, or unknown.
const char *sim_extension_of(int64_t value);

enum sim_param_kind {
    PARAM_VALUE,
    PARAM_HANDLE,
    PARAM_IN,  // a structure that is read
    PARAM_OUT, // a structure that is written: type and next are read
    PARAM_OUT_ARRAY,
    PARAM_POINTER,
    PARAM_STRING,
    PARAM_CAPACITY,
    PARAM_ARRAY, // may be NULL where the capacity is zero
    PARAM_ENUM,
    PARAM_PATH,
    PARAM_FLOATS, // by value; the call has its address
    PARAM_POSE,   // likewise
};

struct sim_param {
    const char *name;
    enum sim_param_kind kind;
    bool optional;
    enum sim_type object; // 0: not looked at
    size_t size;          // of floats
    const struct sim_values *values;
    const struct sim_spec *spec;
};

enum { SIM_MAX_PARAMS = 6 };

struct sim_strict_function {
    const char *name;
    int count;
    struct sim_param params[SIM_MAX_PARAMS];
    PFN_xrVoidFunction real; // set once, before anybody has the wrapper
};

// One call under way: the arguments as numbers (of those that are none their addresses), and what
// was found in it.
struct sim_strict_call {
    struct sim_strict_function *function;
    uint64_t v[SIM_MAX_PARAMS];
    XrResult result;
    int errors;
};
#define SIM_ARG(call, type, i) ((type)(uintptr_t)(call)->v[i])

// strict.c
void sim_strict_found(struct sim_strict_call *call, enum sim_level level, const char *statement,
                      const char *format, ...) AP_PRINTF(4, 5);
void sim_strict_report(enum sim_level level, const char *function, const char *statement,
                       const char *format, ...) AP_PRINTF(4, 5);
int sim_strict_errors_here(void); // of sim_strict in this thread since the last question
void sim_strict_enable(const char *extension);
bool sim_strict_enabled(const char *extension);

// check.c
void sim_strict_check(struct sim_strict_call *call);
// The arguments for a message, with what the structures hold.
void sim_strict_describe(const struct sim_strict_call *call, char *text, size_t size);

// results.c
void sim_strict_judge(struct sim_strict_call *call);

// usage.c
void sim_strict_usage(struct sim_strict_call *call, bool after);
void sim_strict_usage_reset(void);
void sim_strict_usage_finish(void); // what the end of the instance or of the process shows

// swapchains.c; the lock of usage.c is held.
void sim_strict_swapchain_call(struct sim_strict_call *call);
// The program submitted the swapchain's image. True where it was drawn since the frame was begun.
bool sim_strict_swapchain_submitted(struct sim_strict_call *call, XrSwapchain swapchain);
void sim_strict_swapchains_begin_frame(void);
void sim_strict_swapchains_finish(const char *function);
void sim_strict_swapchains_reset(void);

#endif
