#ifndef ANTIPODE_SIM_HMD_CORE_NEGOTIATE_H
#define ANTIPODE_SIM_HMD_CORE_NEGOTIATE_H

#include <stddef.h>
#include <stdint.h>

#include <openxr/openxr.h>

// The loader's handshake, "OpenXR loader - design and operation", section "Loader/Runtime
// Negotiation". Debian's 1.0 development package has no header for it.

// OpenXR 1.1, which Debian's header does not know yet.
#define SIM_API_VERSION XR_MAKE_VERSION(1, 1, 41)

enum { SIM_LOADER_INFO = 1, SIM_RUNTIME_REQUEST = 3, SIM_INTERFACE_VERSION = 1 };

struct sim_loader_info {
    uint32_t structType, structVersion;
    size_t structSize;
    uint32_t minInterfaceVersion, maxInterfaceVersion;
    XrVersion minApiVersion, maxApiVersion;
};

struct sim_runtime_request {
    uint32_t structType, structVersion;
    size_t structSize;
    uint32_t runtimeInterfaceVersion;
    XrVersion runtimeApiVersion;
    PFN_xrGetInstanceProcAddr getInstanceProcAddr;
};

// The library's only exported symbol.
__attribute__((visibility("default"))) XrResult XRAPI_CALL xrNegotiateLoaderRuntimeInterface(
    const struct sim_loader_info *loader, struct sim_runtime_request *request);

#endif
