#ifndef ANTIPODE_IMAGE_COVER_H
#define ANTIPODE_IMAGE_COVER_H

#include <stddef.h>

// How much of each pixel's square a closed curve covers, and how that changes as the curve is
// moved. Private to this folder.

// A curve as a polygon, pixels; and how it is moved: scaled about a point, then shifted.
struct ap_outline {
    const double (*points)[2]; // (i, j), in order, either way round
    size_t count;
    double about_i, about_j;
};
struct ap_outline_place {
    double shift_i, shift_j; // pixels
    double grow_px;          // of a curve whose mean radius is radius_px
    double radius_px;
};

// Of one pixel: the share covered, and its derivatives by what ap_outline_place holds.
struct ap_cover {
    double share, by_i, by_j, by_grow;
};

// Exact for the polygon, to rounding. cover: width·height pixels of the window whose upper left
// pixel is (x0, y0). What lies outside of the window is left out.
void ap_cover_outline(const struct ap_outline *outline, const struct ap_outline_place *place,
                      int x0, int y0, int width, int height, struct ap_cover *cover);

// The polygon's area, > 0, and its centroid.
double ap_outline_area(const struct ap_outline *outline, double *centroid_i, double *centroid_j);

#endif
