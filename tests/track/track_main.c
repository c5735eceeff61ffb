#include <signal.h>

#include "src/app/command.h"
#include "src/base/log.h"

// `antipode track` alone, so that its test waits for no other command.
int main(int argc, char **argv) {
    struct ap_error err = {""};
    signal(SIGPIPE, SIG_IGN);
    enum ap_status status = ap_command_track.run(&err, argc, argv);
    if (status && err.text[0])
        ap_log(AP_LOG_ERROR, "%s", err.text);
    return (int)status;
}
