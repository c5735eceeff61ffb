#include "xr/loader.h"

#include <dlfcn.h>
#include <stdbool.h>
#include <string.h>

struct ap_xr_loader ap_xrl;

// dlsym gives an object pointer; POSIX lets it hold a function's address, ISO C has no cast for it.
static bool find(void *library, const char *name, void *function) {
    void *address = dlsym(library, name);
    memcpy(function, &address, sizeof address);
    return address != NULL;
}

enum ap_status ap_xr_loader_open(struct ap_error *err) {
    static bool open;
    if (open)
        return AP_OK;
    void *library = dlopen("libopenxr_loader.so.1", RTLD_NOW | RTLD_LOCAL);
    if (!library)
        return ap_fail(err, AP_ENVIRONMENT,
                       "the OpenXR loader is missing: install libopenxr-loader1 (%s)", dlerror());
    struct ap_xr_loader loader;
    const char *missing = NULL;
#define AP_XR_FIND(name)                                                                           \
    if (!find(library, "xr" #name, &loader.name))                                                  \
        missing = "xr" #name;
    AP_XR_FUNCTIONS(AP_XR_FIND)
#undef AP_XR_FIND
    if (missing)
        return ap_fail(err, AP_ENVIRONMENT, "the OpenXR loader has no %s: install a newer one",
                       missing);
    ap_xrl = loader;
    open = true;
    return AP_OK;
}
