#ifndef ANTIPODE_BASE_UTF8_H
#define ANTIPODE_BASE_UTF8_H

// Text that came from outside. Pure.

// The length of the UTF-8 sequence at text, 1 to 4; 0 where it is none (overlong, a surrogate,
// cut…).
int ap_utf8_length(const char *text);

// What is no UTF-8 and every control character (of both sets) becomes a question mark, in place:
// then it may go to a terminal, onto a line of a file, and into JSON.
void ap_utf8_tidy(char *text);

#endif
