#ifndef ANTIPODE_TESTS_DEVICE_MEMORY_FILE_H
#define ANTIPODE_TESTS_DEVICE_MEMORY_FILE_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

// A file that holds these bytes and lies on no disk: opened by name like any other.
struct memory_file {
    int fd;
    char path[32];
};

static inline struct memory_file memory_file(const void *bytes, size_t len) {
    struct memory_file file = {.fd = memfd_create("log", MFD_CLOEXEC)};
    if (file.fd < 0 || write(file.fd, bytes, len) != (ssize_t)len) {
        perror("memory_file");
        abort();
    }
    snprintf(file.path, sizeof file.path, "/dev/fd/%d", file.fd);
    return file;
}

static inline struct memory_file memory_text(const char *text) {
    return memory_file(text, strlen(text));
}

#endif
