#include "tests/memory.h"

#include <limits.h>
#include <stdatomic.h>
#include <stdlib.h>

static atomic_long wishes, refused;
static atomic_long from = -1, to = -1; // the wishes that are refused, by number

void memory_refuse(long wish, bool all_after) {
    long first = atomic_load(&wishes) + wish;
    atomic_store(&refused, 0);
    atomic_store(&to, all_after ? LONG_MAX : first + 1);
    atomic_store(&from, first);
}

long memory_allow(void) {
    atomic_store(&to, -1);
    return atomic_load(&refused);
}

long memory_wishes(void) {
    return atomic_load(&wishes);
}

static bool refuse(void) {
    long wish = atomic_fetch_add(&wishes, 1);
    bool no = wish >= atomic_load(&from) && wish < atomic_load(&to);
    atomic_fetch_add(&refused, no);
    return no;
}

void *__real_malloc(size_t size);
void *__real_calloc(size_t n, size_t size);
void *__real_realloc(void *old, size_t size);
void *__real_reallocarray(void *old, size_t n, size_t size);
char *__real_strdup(const char *text);
char *__real_strndup(const char *text, size_t len);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t n, size_t size);
void *__wrap_realloc(void *old, size_t size);
void *__wrap_reallocarray(void *old, size_t n, size_t size);
char *__wrap_strdup(const char *text);
char *__wrap_strndup(const char *text, size_t len);

void *__wrap_malloc(size_t size) {
    return refuse() ? NULL : __real_malloc(size);
}
void *__wrap_calloc(size_t n, size_t size) {
    return refuse() ? NULL : __real_calloc(n, size);
}
void *__wrap_realloc(void *old, size_t size) {
    return refuse() ? NULL : __real_realloc(old, size);
}
void *__wrap_reallocarray(void *old, size_t n, size_t size) {
    return refuse() ? NULL : __real_reallocarray(old, n, size);
}
char *__wrap_strdup(const char *text) {
    return refuse() ? NULL : __real_strdup(text);
}
char *__wrap_strndup(const char *text, size_t len) {
    return refuse() ? NULL : __real_strndup(text, len);
}
