#include <stdlib.h>

#include "sim_hmd/core/swapchains.h"

void sim_session_collect_garbage(struct sim_session *session) {
    if (!session->garbage)
        return;
    vkQueueWaitIdle(session->gpu.queue);
    while (session->garbage) {
        struct sim_garbage *dead = session->garbage;
        session->garbage = dead->next;
        for (int i = 0; i < SIM_MAX_IMAGES; i++)
            ap_gpu_image_destroy(&session->gpu, &dead->image[i]);
        free(dead);
    }
}
