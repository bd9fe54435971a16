#pragma once

#include <cmath>

#include "core/base/random.h"
#include "core/camera/lens_map.h"

namespace camrig::camera {

/// Numbers of one stream, in order.
class Draw {
public:
    explicit Draw(std::uint64_t stream) : stream_(stream) {}
    double uniform(double low, double high) { return low + (high - low) * random_unit(20, stream_, n_++); }
    /// Both signs, magnitudes from 10^low to 10^high.
    double decades(double low, double high) {
        const double magnitude = std::pow(10.0, uniform(low, high));
        return uniform(0, 1) < 0.5 ? -magnitude : magnitude;
    }

private:
    std::uint64_t stream_;
    std::uint64_t n_ = 0;
};

/// A lens as calibrations find them, and a good deal stranger: mild to strong barrel and pincushion, moustache shapes,
/// with and without tangential terms, rational models whose numerator and denominator nearly cancel, fisheyes.
inline Lens random_lens(std::uint64_t n) {
    Draw draw(1000 + n);
    const double strength = std::pow(10.0, draw.uniform(-2, 0));
    const double tangential = n % 5 == 0 ? 0.0 : std::pow(10.0, draw.uniform(-5, -1.7));
    const auto k = [&](double size) { return strength * draw.uniform(-size, size); };
    const auto p = [&] { return tangential * draw.uniform(-1, 1); };
    switch (n % 3) {
        case 0: {
            const double k1 = k(0.6), k2 = k(0.4);
            return {LensModel::plumb_bob, {k1, k2, p(), p(), k(0.2)}};
        }
        case 1: {
            // Real rational calibrations have large k and k + 3 pairs that almost cancel (OpenCV often finds |k| > 10).
            const double big = n % 2 ? 1.0 : 10.0;
            const double k4 = k(big), k5 = k(big), k6 = k(0.3 * big);
            return {LensModel::rational_polynomial, {k4 + k(0.5), k5 + k(0.5), p(), p(), k6 + k(0.2), k4, k5, k6}};
        }
        default: {
            const double k1 = k(0.15), k2 = k(0.1), k3 = k(0.05);
            return {LensModel::equidistant, {k1, k2, k3, k(0.02)}};
        }
    }
}

}  // namespace camrig::camera
