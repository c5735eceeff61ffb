#ifndef ANTIPODE_DEVICE_LOG_UNPACK_H
#define ANTIPODE_DEVICE_LOG_UNPACK_H

#include <stdbool.h>
#include <stddef.h>

// gzip and zstd, a piece at a time. No files, no clock: bytes in, bytes out.

struct ap_unpacker;

enum ap_packing { AP_PACKING_NONE, AP_PACKING_GZIP, AP_PACKING_ZSTD };

// By a file's first bytes.
enum ap_packing ap_packing_of(const unsigned char *bytes, size_t len);

// NULL where there is no memory. AP_PACKING_NONE is not allowed.
struct ap_unpacker *ap_unpacker_create(enum ap_packing packing);
void ap_unpacker_destroy(struct ap_unpacker *unpacker);

// Takes *in_len bytes or fewer from `in` and puts *out_len or fewer into `out`; both become what
// was really taken and put. False: this cannot be unpacked, for the reason in *why (a literal).
bool ap_unpacker_step(struct ap_unpacker *unpacker, const void *in, size_t *in_len, void *out,
                      size_t *out_len, const char **why);

// Between two packed files, or at the end of the last one: more may follow, but need not.
bool ap_unpacker_is_whole(const struct ap_unpacker *unpacker);

#endif
