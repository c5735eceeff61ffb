#ifndef ANTIPODE_APP_SIM_H
#define ANTIPODE_APP_SIM_H

#include <stdbool.h>
#include <stdint.h>

#include "src/app/command.h"
#include "src/app/live_options.h"
#include "src/app/logs.h"

// `antipode sim`: sim.c reads the command line and tells how it ended, sim_settings.c writes the
// simulated headset's settings, sim_capture.c looks after the folder of pictures, sim_process.c
// runs the program.

struct ap_sim_options {
    const char *headset; // NULL: standard
    struct ap_text_list poses, inputs, recentre_s;
    struct ap_live_options live;
    bool devices;      // what is plugged in, whatever it is
    const char *hands; // NULL: none recorded
    struct ap_log_options logs;
    const char *clock;
    double refresh_hz; // NAN: the profile's
    double frames;     // NAN: no limit
    const char *capture, *capture_frames;
    const char *format, *log, *layout; // NULL: not given
    bool layers, lens, force, draw_all, window, strict;
    const char *controllers; // NULL: the runtime's choice
    double timeout_s;        // NAN: none
    bool hold_stdin;
};

// Settles what can be known before the program runs, and writes the settings file. AP_USAGE,
// AP_INPUT (files named by --headset, --poses, --input), AP_ENVIRONMENT. strict_report: where the
// runtime is to write what it found, NULL without --strict.
enum ap_status ap_sim_check(struct ap_error *err, const struct ap_sim_options *options);
enum ap_status ap_sim_write_settings(struct ap_error *err, const struct ap_sim_options *options,
                                     const char *path, const char *strict_report);

// Makes --capture's folder. AP_USAGE where it holds a capture already and there is no --force,
// which takes an earlier capture's files away.
enum ap_status ap_sim_capture_prepare(struct ap_error *err, const struct ap_sim_options *options);
bool ap_sim_capture_is_empty(const char *dir);

struct ap_sim_process {
    char *const *argv;
    double timeout_s; // NAN: none
    bool hold_stdin;
};

struct ap_sim_end {
    bool timed_out;
    int signal; // that ended the program; 0: it exited
    int status; // what a shell would say
};

// Starts the program in this process's environment and waits for its end; SIGINT, SIGTERM and
// SIGHUP go on to it. AP_ENVIRONMENT where it cannot be started. Call it from the only thread.
enum ap_status ap_sim_run_process(struct ap_error *err, const struct ap_sim_process *process,
                                  struct ap_sim_end *end);

#endif
