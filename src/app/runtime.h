#ifndef ANTIPODE_APP_RUNTIME_H
#define ANTIPODE_APP_RUNTIME_H

#include <jansson.h>
#include <stdbool.h>

#include "src/base/status.h"

// Which OpenXR runtime the loader will find, and how to point it at the simulated headset. These
// set environment variables: call them before other threads start.

// The program's own folder's idea of where the simulated headset's manifest lies (build folder or
// installation); malloc'ed. AP_ENVIRONMENT where it is missing.
enum ap_status ap_runtime_manifest(struct ap_error *err, char **path);

// What the loader would use: XR_RUNTIME_JSON, else active_runtime.json in the XDG folders or
// /etc; malloc'ed path, NULL where nothing is configured.
char *ap_runtime_configured(void);

// Makes the simulated headset the loader's runtime, with the settings file at the path (NULL: its
// defaults).
enum ap_status ap_runtime_use_simulated(struct ap_error *err, const char *settings_path);

// Folder of the shipped headset profiles and of other shared files ("headsets"), malloc'ed; NULL
// where there is none.
char *ap_shared_path(const char *name);

#endif
