#include <errno.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/app/command.h"
#include "src/base/log.h"

static const struct ap_command *const commands[] = {
    &ap_command_simulate, &ap_command_eval,      &ap_command_track,   &ap_command_walk,
    &ap_command_replay,   &ap_command_vergence,  &ap_command_page,    &ap_command_compare,
    &ap_command_play,     &ap_command_calibrate, &ap_command_devices, &ap_command_record,
    &ap_command_sim,      &ap_command_doctor,    &ap_command_bench,
};

enum { COMMAND_COUNT = sizeof commands / sizeof commands[0] };

static void print_help(FILE *out) {
    fprintf(out, "usage: antipode COMMAND [options]\n\n"
                 "Walk about in curved space with a VR headset, hands where you feel them.\n\n");
    for (int i = 0; i < COMMAND_COUNT; i++)
        fprintf(out, "  %-10s %s\n", commands[i]->name, commands[i]->summary);
    fprintf(out,
            "\n'antipode COMMAND --help' tells more. Exit statuses: 0; 1 finished with reported "
            "errors or\ndifferences; 2 usage; 3 input; 4 environment.\n");
}

// What was printed has left only once it is flushed: a full disk may show itself no earlier.
static enum ap_status finish_output(enum ap_status st) {
    errno = 0;
    bool lost = fflush(stdout) || ferror(stdout);
    if (st || !lost)
        return st; // who failed has said so
    ap_log(AP_LOG_ERROR, "cannot write to standard output%s%s", errno ? ": " : "",
           errno ? strerror(errno) : "");
    return AP_ENVIRONMENT;
}

int main(int argc, char **argv) {
    // A reader that goes away (`antipode track … | head`) is a write error, told as one.
    signal(SIGPIPE, SIG_IGN);
    // So is a file that may grow no further (`ulimit -f`).
    signal(SIGXFSZ, SIG_IGN);
    // The OpenXR loader repeats at length what our own one line says; XR_LOADER_DEBUG=error asks it
    // to. Under `sim` it is another program's loader, which says what it always says.
    if (argc < 2 || strcmp(argv[1], "sim") != 0)
        setenv("XR_LOADER_DEBUG", "none", 0);
    if (argc < 2) {
        print_help(stderr);
        return AP_USAGE;
    }
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0) {
        print_help(stdout);
        return (int)finish_output(AP_OK);
    }
    if (strcmp(argv[1], "--version") == 0) {
        printf("antipode %s\n", ANTIPODE_VERSION);
        return (int)finish_output(AP_OK);
    }
    for (int i = 0; i < COMMAND_COUNT; i++) {
        if (strcmp(argv[1], commands[i]->name) != 0)
            continue;
        struct ap_error err = {""};
        enum ap_status st = commands[i]->run(&err, argc - 1, argv + 1);
        if (st && err.text[0])
            ap_log(AP_LOG_ERROR, "%s: %s", commands[i]->name, err.text);
        return (int)finish_output(st);
    }
    ap_log(AP_LOG_ERROR, "no command '%s' (see antipode --help)", argv[1]);
    return AP_USAGE;
}
