#ifndef ANTIPODE_APP_COMMAND_H
#define ANTIPODE_APP_COMMAND_H

#include <stdbool.h>
#include <stddef.h>

#include "src/base/status.h"

// The program's subcommands: a table in main.c, one file each. Options are declared in a table,
// from which the parser, --help and the shell completion are made, so that they cannot disagree.

enum ap_option_kind {
    AP_OPTION_FLAG,   // bool *
    AP_OPTION_TEXT,   // const char **, points into argv
    AP_OPTION_NUMBER, // double *, finite decimal
    AP_OPTION_CHOICE, // const char **, one of the words in `values` ("h3|s3|e3")
    AP_OPTION_LIST,   // struct ap_text_list *, one more each time the option is given
};

enum { AP_TEXT_LIST_MAX = 64 };

struct ap_text_list {
    const char *text[AP_TEXT_LIST_MAX]; // pointing into argv
    size_t count;
};

struct ap_option {
    const char *name; // without "--"
    enum ap_option_kind kind;
    void *target;       // holds the default; untouched where the option is absent
    const char *values; // what stands for the value in --help ("M", "FILE", "h3|s3|e3")
    const char *help;   // one line
};

struct ap_usage {
    const char *command;  // "track"
    const char *operands; // "LOG…", "" for none
    const char *text;     // paragraphs for --help: what it does, what it writes, exit statuses
    const struct ap_option *options;
    size_t option_count;
    int min_operands, max_operands; // −1: any number
    bool operand_ends_options;      // what follows the first operand is another program's
};

// Parses argv[1…]; operands are moved to argv[1…*operand_count] in order. "--name value",
// "--name=value", "--" ends options, "-" is an operand. --help prints the page and sets *done.
// AP_USAGE: unknown option, missing or bad value, wrong number of operands; says "see antipode
// track --help".
enum ap_status ap_parse_options(struct ap_error *err, const struct ap_usage *usage, int argc,
                                char **argv, int *operand_count, bool *done);

struct ap_command {
    const char *name;
    const char *summary; // one line for `antipode --help`
    enum ap_status (*run)(struct ap_error *err, int argc, char **argv); // argv[0] is the command
};

extern const struct ap_command ap_command_eval, ap_command_simulate, ap_command_track,
    ap_command_walk, ap_command_replay, ap_command_vergence, ap_command_page, ap_command_compare,
    ap_command_play, ap_command_doctor, ap_command_calibrate, ap_command_devices, ap_command_record,
    ap_command_sim, ap_command_bench;

#endif
