#include "core/camera/polynomial.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/result.h"

namespace camrig::camera {
namespace {

constexpr std::size_t max_degree = 16;
/// A bisection of doubles from 1e12 down to one unit in the last place of 1e-20 takes 160 halvings.
constexpr int max_halvings = 200;

/// The sign of p(x); 0 where rounding in Horner's rule could have made it (Higham, Accuracy and Stability of Numerical
/// Algorithms, section 5.1: the error is below 2n * unit roundoff * sum |a_i| x^i).
int sign_at(std::span<const double> p, double x) {
    double value = 0.0, magnitude = 0.0;
    for (std::size_t i = p.size(); i-- > 0;) {
        value = value * x + p[i];
        magnitude = magnitude * x + std::abs(p[i]);
    }
    const double doubt = 2.0 * static_cast<double>(p.size()) * std::numeric_limits<double>::epsilon() * magnitude;
    if (std::abs(value) <= doubt) return 0;
    return value > 0.0 ? 1 : -1;
}

double bisect(std::span<const double> p, double low, double high, int sign_low) {
    for (int i = 0; i < max_halvings; ++i) {
        const double middle = low + 0.5 * (high - low);
        if (middle <= low || middle >= high) break;
        const int sign = sign_at(p, middle);
        if (sign == 0) return middle;
        (sign == sign_low ? low : high) = middle;
    }
    return low;
}

/// All roots in (0, limit], rising; a doubtful point is a root.
std::vector<double> positive_roots(std::span<const double> p, double limit) {
    while (!p.empty() && p.back() == 0.0) p = p.first(p.size() - 1);
    if (p.size() < 2) return {};
    std::vector<double> stops = positive_roots(derivative(p), limit);
    stops.push_back(limit);

    std::vector<double> roots;
    double low = 0.0;
    int sign_low = sign_at(p, low);
    for (const double high : stops) {
        if (high <= low) continue;
        const int sign_high = sign_at(p, high);
        if (sign_high == 0)
            roots.push_back(high);
        else if (sign_low != 0 && sign_high != sign_low)
            roots.push_back(bisect(p, low, high, sign_low));
        low = high;
        sign_low = sign_high;
    }
    return roots;
}

}  // namespace

Polynomial product(std::span<const double> a, std::span<const double> b) {
    if (a.empty() || b.empty()) return {};
    Polynomial out(a.size() + b.size() - 1, 0.0);
    for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t k = 0; k < b.size(); ++k) out[i + k] += a[i] * b[k];
    return out;
}

Polynomial sum(std::span<const double> a, std::span<const double> b, double factor) {
    Polynomial out(std::max(a.size(), b.size()), 0.0);
    for (std::size_t i = 0; i < a.size(); ++i) out[i] = a[i];
    for (std::size_t i = 0; i < b.size(); ++i) out[i] += factor * b[i];
    return out;
}

Polynomial derivative(std::span<const double> p) {
    Polynomial out;
    for (std::size_t i = 1; i < p.size(); ++i) out.push_back(static_cast<double>(i) * p[i]);
    return out;
}

Polynomial of_square(std::span<const double> p) {
    Polynomial out(p.empty() ? 0 : 2 * p.size() - 1, 0.0);
    for (std::size_t i = 0; i < p.size(); ++i) out[2 * i] = p[i];
    return out;
}

std::optional<double> smallest_positive_root(std::span<const double> p, double limit) {
    CHECK(p.size() <= max_degree + 1);
    const std::vector<double> roots = positive_roots(p, limit);
    if (roots.empty()) return std::nullopt;
    return roots.front();
}

}  // namespace camrig::camera
