#ifndef ANTIPODE_SIM_HMD_CORE_QUIET_WRITE_H
#define ANTIPODE_SIM_HMD_CORE_QUIET_WRITE_H

#include <stdbool.h>
#include <stddef.h>

// Writes all of it, where it can by one call, so that readers and other writers see it whole. False
// with errno where it cannot: a file that is as long as it may get is an error and no reason to
// die, for the thread is the program's, which has not asked for the signal. Any thread.
bool sim_write_quietly(int fd, const char *bytes, size_t len);

#endif
