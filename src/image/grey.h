#ifndef ANTIPODE_IMAGE_GREY_H
#define ANTIPODE_IMAGE_GREY_H

#include "src/image/image.h"

// Pictures of one channel of 16 bits: what the readers and writers of this folder share.

// Room for the values of a picture whose rgb is made, all 0. AP_ENVIRONMENT.
enum ap_status ap_image_make_grey(struct ap_error *err, struct ap_image *image);

// rgb from grey, rounded to the nearest.
void ap_image_show_grey(struct ap_image *image);

enum ap_status ap_pam_write_grey(struct ap_error *err, const char *path,
                                 const struct ap_grey *grey);

#endif
