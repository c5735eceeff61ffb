#include "src/device/live/rules.h"

int main(void) {
    ap_live_write_rules(stdout);
    return fflush(stdout) != 0;
}
