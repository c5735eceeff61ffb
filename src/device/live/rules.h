#ifndef ANTIPODE_DEVICE_LIVE_RULES_H
#define ANTIPODE_DEVICE_LIVE_RULES_H

#include <stdio.h>

#include "src/device/live/io.h"

// udev's rules that give whoever sits at the machine access to the devices that drivers know. They
// are made of the drivers' own tables, so that there is one list.

#define AP_LIVE_RULES_FILE "70-antipode.rules"

// The whole file that is installed. Errors stay with the stream.
void ap_live_write_rules(FILE *stream);

// The one line that a device needs, without a newline.
void ap_live_rule(const struct ap_live_place *place, char *text, size_t size);

// Whether the installed file has a rule for it.
bool ap_live_rules_cover(const struct ap_live_place *place);

// A sentence: that it cannot be opened and which rule is missing where. driver NULL: none.
void ap_live_denied_text(const struct ap_live_place *place, const struct ap_driver *driver,
                         char *text, size_t size);

#endif
