// Preloaded into sanitized tests: libraries stay loaded to the end of the process, so that
// LeakSanitizer can name the module of a leak (the Vulkan loader closes its driver, whose own leaks
// then come from "unknown module" and no suppression fits).
int dlclose(void *handle);
int dlclose(void *handle) {
    (void)handle;
    return 0;
}
