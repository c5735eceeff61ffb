#include "src/app/command.h"

#include <stdio.h>
#include <string.h>

#include "src/base/number.h"

static const char *kind_word(const struct ap_option *o) {
    return o->kind == AP_OPTION_FLAG ? "" : o->values;
}

static void print_help(const struct ap_usage *u) {
    printf("usage: antipode %s%s%s%s\n\n%s\n", u->command, u->option_count ? " [options]" : "",
           u->operands[0] ? " " : "", u->operands, u->text);
    if (u->option_count)
        printf("\noptions:\n");
    for (size_t i = 0; i < u->option_count; i++) {
        const struct ap_option *o = &u->options[i];
        char left[64];
        snprintf(left, sizeof left, "--%s %s", o->name, kind_word(o));
        printf("  %-26s %s\n", left, o->help);
    }
    printf("  %-26s %s\n", "--help", "this page");
}

static const struct ap_option *find_option(const struct ap_usage *u, const char *name, size_t len) {
    for (size_t i = 0; i < u->option_count; i++)
        if (strlen(u->options[i].name) == len && strncmp(u->options[i].name, name, len) == 0)
            return &u->options[i];
    return NULL;
}

static bool is_choice(const char *values, const char *word) {
    size_t n = strlen(word);
    for (const char *v = values; n > 0;) {
        size_t len = strcspn(v, "|");
        if (len == n && strncmp(v, word, n) == 0)
            return true;
        if (v[len] == '\0')
            break;
        v += len + 1;
    }
    return false;
}

static enum ap_status add_text(struct ap_error *err, const struct ap_option *o, const char *value) {
    struct ap_text_list *list = o->target;
    if (list->count == AP_TEXT_LIST_MAX)
        return ap_fail(err, AP_USAGE, "--%s: at most %d of them", o->name, AP_TEXT_LIST_MAX);
    list->text[list->count++] = value;
    return AP_OK;
}

static enum ap_status set_option(struct ap_error *err, const struct ap_usage *u,
                                 const struct ap_option *o, const char *value) {
    double number;
    switch (o->kind) {
    case AP_OPTION_FLAG:
        *(bool *)o->target = true;
        return AP_OK;
    case AP_OPTION_NUMBER:
        if (!ap_parse_double(value, strlen(value), &number))
            return ap_fail(err, AP_USAGE,
                           "--%s: expected a number, not '%s' (see antipode %s --help)", o->name,
                           value, u->command);
        *(double *)o->target = number;
        return AP_OK;
    case AP_OPTION_CHOICE:
        if (!is_choice(o->values, value))
            return ap_fail(err, AP_USAGE, "--%s: expected one of %s, not '%s'", o->name, o->values,
                           value);
        break;
    case AP_OPTION_LIST:
        return add_text(err, o, value);
    case AP_OPTION_TEXT:
        break;
    }
    *(const char **)o->target = value;
    return AP_OK;
}

// One "--name[=value]" at argv[i]; *used is the number of words it takes.
static enum ap_status parse_option(struct ap_error *err, const struct ap_usage *u, int argc,
                                   char **argv, int i, int *used) {
    const char *name = argv[i] + 2;
    size_t len = strcspn(name, "=");
    bool inline_value = name[len] == '=';
    const struct ap_option *o = find_option(u, name, len);
    if (argv[i][1] != '-' || !o)
        return ap_fail(err, AP_USAGE, "unknown option %s (see antipode %s --help)", argv[i],
                       u->command);
    *used = 1;
    if (o->kind == AP_OPTION_FLAG) {
        if (inline_value)
            return ap_fail(err, AP_USAGE, "--%s takes no value", o->name);
        return set_option(err, u, o, NULL);
    }
    if (inline_value)
        return set_option(err, u, o, name + len + 1);
    if (i + 1 >= argc)
        return ap_fail(err, AP_USAGE, "--%s: a value is missing: %s", o->name, kind_word(o));
    *used = 2;
    return set_option(err, u, o, argv[i + 1]);
}

enum ap_status ap_parse_options(struct ap_error *err, const struct ap_usage *usage, int argc,
                                char **argv, int *operand_count, bool *done) {
    int operands = 0;
    bool only_operands = false;
    *done = false;
    for (int i = 1; i < argc;) {
        int used = 1;
        if (only_operands || argv[i][0] != '-' || strcmp(argv[i], "-") == 0) {
            argv[1 + operands++] = argv[i];
            only_operands |= usage->operand_ends_options;
        } else if (strcmp(argv[i], "--") == 0) {
            only_operands = true;
        } else if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) {
            print_help(usage);
            *done = true;
            return AP_OK;
        } else {
            enum ap_status st = parse_option(err, usage, argc, argv, i, &used);
            if (st)
                return st;
        }
        i += used;
    }
    if (operands < usage->min_operands)
        return ap_fail(err, AP_USAGE, "%s is missing (see antipode %s --help)", usage->operands,
                       usage->command);
    if (usage->max_operands >= 0 && operands > usage->max_operands)
        return ap_fail(err, AP_USAGE, "'%s' is one operand too many (see antipode %s --help)",
                       argv[1 + usage->max_operands], usage->command);
    *operand_count = operands;
    return AP_OK;
}
