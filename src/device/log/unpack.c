#include "src/device/log/unpack.h"

#include <stdlib.h>
#include <string.h>
#define ZLIB_CONST // next_in is const
#include <zlib.h>
#include <zstd.h>

// What zstd -1 … -22 and --long=27 write; more memory a file must not ask for.
enum { ZSTD_WINDOW_LOG_MAX = 27, GZIP_WINDOW = 15 + 16, STEP_MAX = 1 << 30 };

struct ap_unpacker {
    enum ap_packing packing;
    bool is_whole;
    z_stream zlib;
    ZSTD_DCtx *zstd;
};

enum ap_packing ap_packing_of(const unsigned char *bytes, size_t len) {
    static const unsigned char gzip[] = {0x1f, 0x8b}, zstd[] = {0x28, 0xb5, 0x2f, 0xfd};
    if (len >= sizeof gzip && memcmp(bytes, gzip, sizeof gzip) == 0)
        return AP_PACKING_GZIP;
    if (len >= sizeof zstd && memcmp(bytes, zstd, sizeof zstd) == 0)
        return AP_PACKING_ZSTD;
    return AP_PACKING_NONE;
}

struct ap_unpacker *ap_unpacker_create(enum ap_packing packing) {
    struct ap_unpacker *u = calloc(1, sizeof *u);
    if (!u)
        return NULL;
    u->packing = packing;
    if (packing == AP_PACKING_GZIP && inflateInit2(&u->zlib, GZIP_WINDOW) == Z_OK)
        return u;
    if (packing == AP_PACKING_ZSTD)
        u->zstd = ZSTD_createDCtx();
    if (u->zstd &&
        !ZSTD_isError(ZSTD_DCtx_setParameter(u->zstd, ZSTD_d_windowLogMax, ZSTD_WINDOW_LOG_MAX)))
        return u;
    ZSTD_freeDCtx(u->zstd);
    free(u);
    return NULL;
}

void ap_unpacker_destroy(struct ap_unpacker *u) {
    if (!u)
        return;
    if (u->packing == AP_PACKING_GZIP)
        inflateEnd(&u->zlib);
    ZSTD_freeDCtx(u->zstd);
    free(u);
}

static bool step_gzip(struct ap_unpacker *u, const void *in, size_t *in_len, void *out,
                      size_t *out_len, const char **why) {
    if (u->is_whole && *in_len) { // another one after the first
        inflateReset(&u->zlib);
        u->is_whole = false;
    }
    unsigned in_max = *in_len < STEP_MAX ? (unsigned)*in_len : STEP_MAX;
    unsigned out_max = *out_len < STEP_MAX ? (unsigned)*out_len : STEP_MAX;
    u->zlib.next_in = in;
    u->zlib.avail_in = in_max;
    u->zlib.next_out = out;
    u->zlib.avail_out = out_max;
    int code = inflate(&u->zlib, Z_NO_FLUSH);
    *in_len = in_max - u->zlib.avail_in;
    *out_len = out_max - u->zlib.avail_out;
    u->is_whole = code == Z_STREAM_END;
    *why = code == Z_MEM_ERROR ? "out of memory for unpacking" : "its gzip data are damaged";
    return code == Z_OK || code == Z_STREAM_END || code == Z_BUF_ERROR;
}

static bool step_zstd(struct ap_unpacker *u, const void *in, size_t *in_len, void *out,
                      size_t *out_len, const char **why) {
    ZSTD_inBuffer from = {.src = in, .size = *in_len};
    ZSTD_outBuffer to = {.dst = out, .size = *out_len};
    size_t left = ZSTD_decompressStream(u->zstd, &to, &from);
    if (ZSTD_isError(left)) {
        *why = ZSTD_getErrorName(left);
        return false;
    }
    if (from.pos || to.pos)
        u->is_whole = left == 0;
    *in_len = from.pos;
    *out_len = to.pos;
    return true;
}

bool ap_unpacker_step(struct ap_unpacker *u, const void *in, size_t *in_len, void *out,
                      size_t *out_len, const char **why) {
    return u->packing == AP_PACKING_GZIP ? step_gzip(u, in, in_len, out, out_len, why)
                                         : step_zstd(u, in, in_len, out, out_len, why);
}

bool ap_unpacker_is_whole(const struct ap_unpacker *u) {
    return u->is_whole;
}
