// No shader that draws calls an inverse or hyperbolic built-in, or pow: no driver gets those right.
#include <ctype.h>
#include <dirent.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/file.h"

static const char *const FORBIDDEN[] = {"acos",  "asin", "atan", "acosh", "asinh",
                                        "atanh", "cosh", "sinh", "tanh",  "pow"};

static bool is_word(char c) {
    return isalnum((unsigned char)c) || c == '_';
}

static int count(const char *file, const char *text, const char *word) {
    int found = 0;
    size_t n = strlen(word);
    for (const char *p = text; (p = strstr(p, word)) != NULL; p += n) {
        bool starts = p == text || !is_word(p[-1]);
        if (starts && !is_word(p[n])) {
            printf("%s: uses %s\n", file, word);
            found++;
        }
    }
    return found;
}

int main(void) {
    const char *root = getenv("ANTIPODE_SOURCE");
    if (!root) {
        printf("skipped: ANTIPODE_SOURCE is not set\n");
        return 77;
    }
    char dir[4096];
    snprintf(dir, sizeof dir, "%s/shaders", root);
    DIR *list = opendir(dir);
    int found = 0, read = 0;
    for (struct dirent *e = list ? readdir(list) : NULL; e; e = readdir(list)) {
        // What the built-ins cost and miss is measured by the one shader that draws nothing.
        if (e->d_name[0] == '.' || strcmp(e->d_name, "meson.build") == 0 ||
            strcmp(e->d_name, "logmap_builtin.glsl") == 0)
            continue;
        char *path = ap_path_join(dir, e->d_name), *text = NULL;
        size_t len = 0;
        if (path && ap_file_read(NULL, path, 1 << 20, &text, &len) == AP_OK) {
            read++;
            if (strcmp(e->d_name, "logmap_test.comp") != 0 && strstr(text, "logmap_builtin.glsl")) {
                printf("%s: includes logmap_builtin.glsl\n", e->d_name);
                found++;
            }
            for (size_t i = 0; i < sizeof FORBIDDEN / sizeof *FORBIDDEN; i++)
                found += count(e->d_name, text, FORBIDDEN[i]);
        }
        free(text);
        free(path);
    }
    if (list)
        closedir(list);
    printf("%d shader files, %d forbidden built-ins (expected 0)\n", read, found);
    return found != 0 || read < 6;
}
