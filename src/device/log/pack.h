#ifndef ANTIPODE_DEVICE_LOG_PACK_H
#define ANTIPODE_DEVICE_LOG_PACK_H

#include <stdio.h>

#include "src/device/log/unpack.h"

// Bytes into a stream, packed on the way. Errors of the stream stay with the stream.

struct ap_packer;

// By a file's name: ".gz", ".zst".
enum ap_packing ap_packing_of_name(const char *path);

// NULL where there is no memory. With AP_PACKING_NONE bytes go as they are.
struct ap_packer *ap_packer_create(enum ap_packing packing, FILE *stream);
// Drops what has not been written.
void ap_packer_destroy(struct ap_packer *packer);

// False where the packing itself fails.
bool ap_packer_write(struct ap_packer *packer, const void *bytes, size_t len);
// Everything so far and the end; nothing more may follow.
bool ap_packer_finish(struct ap_packer *packer);

#endif
