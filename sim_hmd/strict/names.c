#include "sim_hmd/strict/spec.h"

// After the above, which says which platforms are looked at.
#include <openxr/openxr_reflection.h>

// Names of values, structures and extensions, from the header's own lists.

#define VALUE_OF(name, value) value,
#define NAME_OF(name, value) #name,
#define VALUES(T)                                                                                  \
    static const int32_t numbers_##T[] = {XR_LIST_ENUM_##T(VALUE_OF)};                             \
    static const char *const names_##T[] = {XR_LIST_ENUM_##T(NAME_OF)};                            \
    const struct sim_values sim_values_##T = {numbers_##T, names_##T,                              \
                                              sizeof numbers_##T / sizeof *numbers_##T};
VALUES(XrActionType)
VALUES(XrEnvironmentBlendMode)
VALUES(XrEyeVisibility)
VALUES(XrFormFactor)
VALUES(XrHandEXT)
VALUES(XrHandJointSetEXT)
VALUES(XrHandJointsMotionRangeEXT)
VALUES(XrObjectType)
VALUES(XrReferenceSpaceType)
VALUES(XrResult)
VALUES(XrViewConfigurationType)
VALUES(XrVisibilityMaskTypeKHR)

#define STRUCTURE(name, value) {value, #name},
static const struct {
    int32_t type;
    const char *name;
} structures[] = {XR_LIST_STRUCTURE_TYPES(STRUCTURE)};

const char *sim_structure_name(XrStructureType type) {
    for (size_t i = 0; i < sizeof structures / sizeof *structures; i++)
        if (structures[i].type == (int32_t)type)
            return structures[i].name;
    return NULL;
}

#define EXTENSION(name, number) {number, #name},
static const struct {
    int32_t number;
    const char *name;
} extensions[] = {XR_LIST_EXTENSIONS(EXTENSION)};

const char *sim_extension_of(int64_t value) {
    for (size_t i = 0; value >= 1000000000 && i < sizeof extensions / sizeof *extensions; i++)
        if (extensions[i].number == (value - 1000000000) / 1000 + 1)
            return extensions[i].name;
    return NULL;
}

enum { PLAUSIBLE_EXTENSIONS = 2000 };

bool sim_value_known(const struct sim_values *values, int64_t value, const char **name) {
    *name = "";
    for (size_t i = 0; i < values->count; i++)
        if (values->values[i] == value && value != INT32_MAX) {
            *name = values->names[i];
            return true;
        }
    int64_t number = (value - 1000000000) / 1000 + 1;
    return value >= 1000000000 && number <= PLAUSIBLE_EXTENSIONS && !sim_extension_of(value);
}

const char *sim_result_name(XrResult result) {
    const char *name;
    return sim_value_known(&sim_values_XrResult, result, &name) && *name ? name
                                                                         : "an unknown result";
}
