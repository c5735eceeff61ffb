#include "src/device/log/pack.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>
#include <zstd.h>

struct ap_packer {
    enum ap_packing packing;
    FILE *stream;
    bool has_gzip;
    z_stream gzip;
    ZSTD_CCtx *zstd;
    unsigned char out[1 << 15];
};

static bool ends_so(const char *path, const char *end) {
    size_t n = strlen(path), m = strlen(end);
    return n > m && strcmp(path + n - m, end) == 0;
}

enum ap_packing ap_packing_of_name(const char *path) {
    return ends_so(path, ".gz")    ? AP_PACKING_GZIP
           : ends_so(path, ".zst") ? AP_PACKING_ZSTD
                                   : AP_PACKING_NONE;
}

struct ap_packer *ap_packer_create(enum ap_packing packing, FILE *stream) {
    enum { WINDOW_BITS = 15, GZIP_HEADER = 16, MEMORY = 8 };
    struct ap_packer *p = calloc(1, sizeof *p);
    if (!p)
        return NULL;
    p->packing = packing;
    p->stream = stream;
    if (packing == AP_PACKING_GZIP)
        p->has_gzip = deflateInit2(&p->gzip, Z_DEFAULT_COMPRESSION, Z_DEFLATED,
                                   WINDOW_BITS + GZIP_HEADER, MEMORY, Z_DEFAULT_STRATEGY) == Z_OK;
    else if (packing == AP_PACKING_ZSTD)
        p->zstd = ZSTD_createCCtx();
    if ((packing == AP_PACKING_GZIP && !p->has_gzip) || (packing == AP_PACKING_ZSTD && !p->zstd)) {
        ap_packer_destroy(p);
        return NULL;
    }
    return p;
}

void ap_packer_destroy(struct ap_packer *p) {
    if (!p)
        return;
    if (p->has_gzip)
        deflateEnd(&p->gzip);
    ZSTD_freeCCtx(p->zstd);
    free(p);
}

static bool write_gzip(struct ap_packer *p, const void *bytes, size_t len, int flush) {
    int r = Z_OK;
    p->gzip.next_in = (unsigned char *)(uintptr_t)bytes;
    p->gzip.avail_in = (uInt)len;
    do {
        p->gzip.next_out = p->out;
        p->gzip.avail_out = sizeof p->out;
        r = deflate(&p->gzip, flush);
        fwrite(p->out, 1, sizeof p->out - p->gzip.avail_out, p->stream);
    } while (r != Z_STREAM_ERROR && p->gzip.avail_out == 0);
    return r == (flush == Z_FINISH ? Z_STREAM_END : Z_OK) || (r == Z_BUF_ERROR && len == 0);
}

static bool write_zstd(struct ap_packer *p, const void *bytes, size_t len, ZSTD_EndDirective end) {
    ZSTD_inBuffer in = {bytes, len, 0};
    size_t left;
    do {
        ZSTD_outBuffer out = {p->out, sizeof p->out, 0};
        left = ZSTD_compressStream2(p->zstd, &out, &in, end);
        if (ZSTD_isError(left))
            return false;
        fwrite(p->out, 1, out.pos, p->stream);
    } while (end == ZSTD_e_end ? left > 0 : in.pos < in.size);
    return true;
}

bool ap_packer_write(struct ap_packer *p, const void *bytes, size_t len) {
    switch (p->packing) {
    case AP_PACKING_GZIP:
        return len == 0 || write_gzip(p, bytes, len, Z_NO_FLUSH);
    case AP_PACKING_ZSTD:
        return write_zstd(p, bytes, len, ZSTD_e_continue);
    case AP_PACKING_NONE:
        break;
    }
    fwrite(bytes, 1, len, p->stream);
    return true;
}

bool ap_packer_finish(struct ap_packer *p) {
    if (p->packing == AP_PACKING_GZIP)
        return write_gzip(p, NULL, 0, Z_FINISH);
    return p->packing == AP_PACKING_NONE || write_zstd(p, NULL, 0, ZSTD_e_end);
}
