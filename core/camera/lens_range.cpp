#include <algorithm>
#include <cmath>
#include <limits>

#include "core/camera/lens_map.h"

// What the formulas of lens_map.cpp can give over a piece of a curve, in interval arithmetic.
namespace camrig::camera {
namespace {

/// Horner's rule over a range gets tighter with shorter ranges.
constexpr int stretch_rings = 32;
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr Interval everything{-infinity, infinity};

}  // namespace

std::optional<LensMap::RadialRange> LensMap::radial_range(Interval s) const {
    Interval n{n_[4], n_[4]}, dn{0.0, 0.0};
    for (int i = 3; i >= 0; --i) {
        dn = dn * s + n;
        n = n * s + n_[i];
    }
    if (!rational_) return RadialRange{n, dn * 2.0};
    Interval d{d_[3], d_[3]}, dd{0.0, 0.0};
    for (int i = 2; i >= 0; --i) {
        dd = dd * s + d;
        d = d * s + d_[i];
    }
    // Within the valid disc D is positive; over a long range its bound need not be.
    if (!(d.low > 0.0)) return std::nullopt;
    const Interval scale = n / d;
    return RadialRange{scale, (dn - scale * dd) * 2.0 / d};
}

LensMap::CurveImage LensMap::distort_curve(const IdealCurve& c) const {
    if (identity_) return {c.x, c.y, c.dx, c.dy};
    const auto radial = radial_range(c.s);
    if (!radial) return {everything, everything, everything, everything};
    const auto [scale, along] = *radial;
    const Interval bend = along * c.half_ds;
    CurveImage image{c.x * scale, c.y * scale, c.dx * scale + c.x * bend, c.dy * scale + c.y * bend};
    if (p1_ == 0.0 && p2_ == 0.0) return image;
    const Interval xx = square(c.x), yy = square(c.y), xy = c.x * c.y;
    const Interval half_dxx = c.x * c.dx, half_dyy = c.y * c.dy, dxy = c.dx * c.y + c.x * c.dy;
    image.x = image.x + xy * (2.0 * p1_) + (xx * 3.0 + yy) * p2_;
    image.y = image.y + (xx + yy * 3.0) * p1_ + xy * (2.0 * p2_);
    image.dx = image.dx + dxy * (2.0 * p1_) + (half_dxx * 6.0 + half_dyy * 2.0) * p2_;
    image.dy = image.dy + (half_dxx * 2.0 + half_dyy * 6.0) * p1_ + dxy * (2.0 * p2_);
    return image;
}

double LensMap::greatest_stretch(double radius) const {
    if (identity_) return 1.0;
    double most = 0.0;
    for (int ring = 0; ring < stretch_rings; ++ring) {
        const double inner = radius * ring / stretch_rings, outer = radius * (ring + 1) / stretch_rings;
        const Interval s{inner * inner, outer * outer};
        const auto radial = radial_range(s);
        if (!radial) return infinity;
        // The eigenvalues of the radial part: across the radius and along it.
        const auto [scale, along] = *radial;
        most = std::max({most, scale.magnitude(), (scale + along * s).magnitude()});
    }
    return most + 6.0 * std::hypot(p1_, p2_) * radius;
}

}  // namespace camrig::camera
