#pragma once

#include "core/sensor/sensor_spec.h"

namespace camrig::sensor {

/// Where in each 2x2 of a mosaic red is; blue is diagonally opposite.
struct RedPlace {
    int x = 0, y = 0;
};
constexpr RedPlace red_place(ColorFilter filter) {
    switch (filter) {
        case ColorFilter::grbg:
            return {1, 0};
        case ColorFilter::gbrg:
            return {0, 1};
        case ColorFilter::bggr:
            return {1, 1};
        default:
            return {0, 0};
    }
}

/// The colour of a photosite of a mosaic: 0 red, 1 green, 2 blue.
constexpr int color_at(ColorFilter filter, int x, int y) {
    const RedPlace red = red_place(filter);
    const int off_red = ((x ^ red.x) & 1) + ((y ^ red.y) & 1);
    return off_red;
}

}  // namespace camrig::sensor
