#include <inttypes.h>

#include "src/base/number.h"
#include "src/device/poselog.h"

void ap_poselog_write_header(FILE *stream) {
    fputs("t_ns,device,px,py,pz,qx,qy,qz,qw,trigger,squeeze,select,reset\n", stream);
}

void ap_poselog_write_row(FILE *stream, const char *device, const struct ap_sample *sample) {
    const struct ap_pose *pose = &sample->pose;
    const double numbers[9] = {pose->p.x, pose->p.y, pose->p.z,       pose->q.x,      pose->q.y,
                               pose->q.z, pose->q.w, sample->trigger, sample->squeeze};
    fprintf(stream, "%" PRId64 ",%s", sample->t_ns, device);
    for (int i = 0; i < 9; i++) {
        char text[AP_DOUBLE_TEXT_MAX];
        ap_format_double(text, numbers[i]);
        fprintf(stream, ",%s", text);
    }
    fprintf(stream, ",%d,%d\n", sample->select ? 1 : 0, sample->reset ? 1 : 0);
}
