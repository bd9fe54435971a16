#pragma once

#include <optional>
#include <span>
#include <vector>

namespace camrig::camera {

/// A real polynomial, coefficients from the constant term upwards.
using Polynomial = std::vector<double>;

Polynomial product(std::span<const double> a, std::span<const double> b);
/// a + factor * b.
Polynomial sum(std::span<const double> a, std::span<const double> b, double factor = 1.0);
Polynomial derivative(std::span<const double> p);
/// p(x * x).
Polynomial of_square(std::span<const double> p);

/// The smallest root in (0, limit], or none. A point where the polynomial is zero as far as its own rounding error
/// lets one tell (it touches zero without crossing) counts as a root, so the answer errs towards "there is one".
/// Nothing is sampled: between two neighbouring roots of the derivative a polynomial is monotonic, so its sign at those
/// decides; the roots of the derivative are found the same way, down to degree one.
/// Degree at most 16; coefficients finite, and so small that no term overflows at `limit`.
std::optional<double> smallest_positive_root(std::span<const double> p, double limit);

}  // namespace camrig::camera
