#include "core/base/black_body.h"

namespace camrig {
namespace {

/// Linear sRGB at luminance 1.
std::array<double, 3> black_body(double kelvin) {
    const double t = 1000 / kelvin;
    const double x = kelvin <= 4000 ? -0.2661239 * t * t * t - 0.2343589 * t * t + 0.8776956 * t + 0.179910
                                    : -3.0258469 * t * t * t + 2.1070379 * t * t + 0.2226347 * t + 0.240390;
    const double y = kelvin <= 2222   ? -1.1063814 * x * x * x - 1.34811020 * x * x + 2.18555832 * x - 0.20219683
                     : kelvin <= 4000 ? -0.9549476 * x * x * x - 1.37418593 * x * x + 2.09137015 * x - 0.16748867
                                      : 3.0817580 * x * x * x - 5.87338670 * x * x + 3.75112997 * x - 0.37001483;
    const double big_x = x / y, big_z = (1 - x - y) / y;
    return {3.2404542 * big_x - 1.5371385 - 0.4985314 * big_z, -0.9692660 * big_x + 1.8760108 + 0.0415560 * big_z,
            0.0556434 * big_x - 0.2040259 + 1.0572252 * big_z};
}

}  // namespace

std::array<double, 3> white_balance_of(double kelvin) {
    const auto neutral = black_body(6500), taken = black_body(kelvin);
    return {neutral[0] / taken[0] * taken[1] / neutral[1], 1.0, neutral[2] / taken[2] * taken[1] / neutral[1]};
}

}  // namespace camrig
