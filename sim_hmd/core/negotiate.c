#include "sim_hmd/core/negotiate.h"

#include <string.h>

#include "sim_hmd/core/instance.h"
#include "sim_hmd/strict/strict.h"
#include "src/base/log.h"

XrResult XRAPI_CALL xrNegotiateLoaderRuntimeInterface(const struct sim_loader_info *loader,
                                                      struct sim_runtime_request *request) {
    if (!loader || !request || loader->structType != SIM_LOADER_INFO ||
        loader->structVersion != 1 || loader->structSize != sizeof *loader ||
        request->structType != SIM_RUNTIME_REQUEST || request->structVersion != 1 ||
        request->structSize != sizeof *request)
        return XR_ERROR_INITIALIZATION_FAILED;
    if (loader->minInterfaceVersion > SIM_INTERFACE_VERSION ||
        loader->maxInterfaceVersion < SIM_INTERFACE_VERSION ||
        loader->minApiVersion > SIM_API_VERSION || loader->maxApiVersion < XR_MAKE_VERSION(1, 0, 0))
        return XR_ERROR_INITIALIZATION_FAILED;
    ap_log_set_prefix("antipode-sim");
    request->runtimeInterfaceVersion = SIM_INTERFACE_VERSION;
    request->runtimeApiVersion =
        loader->maxApiVersion < XR_MAKE_VERSION(1, 1, 0) ? XR_CURRENT_API_VERSION : SIM_API_VERSION;
    request->getInstanceProcAddr = xrGetInstanceProcAddr;
    return XR_SUCCESS;
}

// When a function may be asked for.
enum when { ALWAYS, INSTANCE, VERSION_1_1 };

// The core; extensions bring their own lists (extensions.h).
struct entry {
    const char *name;
    PFN_xrVoidFunction function;
    enum when when;
};

#define ENTRY(name, when) {#name, (PFN_xrVoidFunction)name, when},
static const struct entry entries[] = {SIM_CORE_FUNCTIONS(ENTRY)};

static bool may_ask(const struct sim_instance *instance, enum when when) {
    return when == ALWAYS || (instance && (when == INSTANCE || instance->minor >= 1));
}

// NULL: no such function, or none that may be asked for yet.
static PFN_xrVoidFunction find(const struct sim_instance *instance, const char *name) {
    for (size_t i = 0; i < sizeof entries / sizeof *entries; i++)
        if (strcmp(entries[i].name, name) == 0)
            return may_ask(instance, entries[i].when) ? entries[i].function : NULL;
    return instance ? sim_extension_function(instance->enabled, name) : NULL;
}

XrResult XRAPI_CALL xrGetInstanceProcAddr(XrInstance handle, const char *name,
                                          PFN_xrVoidFunction *function) {
    SIM_LOCKED;
    if (!name || !function)
        return sim_strict(XR_ERROR_VALIDATION_FAILURE, "xrGetInstanceProcAddr",
                          name ? "VUID-xrGetInstanceProcAddr-function-parameter"
                               : "VUID-xrGetInstanceProcAddr-name-parameter",
                          "%s is NULL", name ? "function" : "name");
    *function = NULL;
    const struct sim_instance *instance = sim_instance_get(handle);
    if (handle && !instance)
        return XR_ERROR_HANDLE_INVALID;
    *function = find(instance, name);
    if (*function) {
        *function = sim_strict_wrap(name, *function);
        return XR_SUCCESS;
    }
    sim_strict_no_function(name);
    return instance ? XR_ERROR_FUNCTION_UNSUPPORTED : XR_ERROR_HANDLE_INVALID;
}
