#include "tests/sim_hmd/report.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

char report_path[256];
int report_statements;
static long read_to;
int report_errors;

char *report_news(void) {
    static char text[1 << 16];
    FILE *f = fopen(report_path, "r");
    assert_non_null(f);
    assert_int_equal(fseek(f, read_to, SEEK_SET), 0);
    size_t n = fread(text, 1, sizeof text - 1, f);
    text[n] = '\0';
    read_to += (long)n;
    fclose(f);
    for (const char *at = text; (at = strstr(at, "{\"level\":\"error\"")); at++)
        report_errors++;
    return text;
}

static bool line_says(const char *text, const char *function, const char *statement) {
    char f[128], s[256];
    snprintf(f, sizeof f, "\"function\":\"%s\"", function);
    snprintf(s, sizeof s, "\"statement\":\"%s", statement);
    for (const char *line = text; *line;) {
        const char *end = strchr(line, '\n');
        size_t len = end ? (size_t)(end - line) : strlen(line);
        const char *at_f = strstr(line, f), *at_s = strstr(line, s);
        if (at_f && at_f < line + len && at_s && at_s < line + len)
            return true;
        line += len + (end ? 1 : 0);
    }
    return false;
}

void report_says(const char *file, int line, const char *function, const char *statement) {
    const char *text = report_news();
    if (!line_says(text, function, statement)) {
        fprintf(stderr, "%s:%d: expected %s %s, the report says:\n%s", file, line, function,
                statement, *text ? text : "nothing\n");
        fail();
    }
    report_statements++;
}

void report_says_nothing(const char *file, int line) {
    const char *text = report_news();
    if (strstr(text, "\"level\"")) {
        fprintf(stderr, "%s:%d: expected nothing, the report says:\n%s", file, line, text);
        fail();
    }
}

void report_settings(void) {
    char json[512];
    snprintf(report_path, sizeof report_path, "%s/strict.jsonl", client_folder());
    remove(report_path);
    read_to = 0;
    report_errors = 0;
    snprintf(json, sizeof json,
             "{\"clock\": \"virtual\", \"strict\": true, \"strict_report\": \"%s\", "
             "\"capture\": {\"dir\": \"%s/eyes\", \"frames\": \"::3\"}}",
             report_path, client_folder());
    client_settings(json);
}

void report_start(struct client *c) {
    report_settings();
    client_start(c);
    SAYS_NOTHING();
}

void report_stop(struct client *c) {
    client_stop(c);
    char expected[64];
    char *text = report_news(), *last = strstr(text, "{\"errors\":");
    snprintf(expected, sizeof expected, "{\"errors\":%d,", report_errors);
    if (!last || strncmp(last, expected, strlen(expected)) != 0 || strchr(last, '\n')[1] != '\0') {
        fprintf(stderr, "expected %s… as the last line of:\n%s", expected, text);
        fail();
    }
}
