#ifndef ANTIPODE_TESTS_MEMORY_H
#define ANTIPODE_TESTS_MEMORY_H

#include <stdbool.h>

// Memory that is not there. A test that is linked with memory.c and memory_args (meson.build)
// refuses what it, and what is linked into it, wishes for; libraries get what they want. Any
// thread.

// From now on the wish of this number (0: the next) is refused, with all_after those behind it,
// too.
void memory_refuse(long wish, bool all_after);
// From now on nothing is. How many wishes were refused since memory_refuse.
long memory_allow(void);
// Wishes so far, refused or not.
long memory_wishes(void);

#endif
