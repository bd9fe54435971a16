// The inverse lens map. OpenCV iterates x = (d - tangential(x)) / radial(x) a fixed number of times without looking at
// the result; that converges slowly for strong lenses, diverges for some, and beyond the fold lands anywhere. Here the
// answer is bracketed first, and only an answer whose residual was seen leaves.
#include <algorithm>
#include <cmath>

#include "core/camera/lens_map.h"

namespace camrig {
namespace {

constexpr int max_radial_steps = 120;  // Newton needs 3 to 8; bisection alone at most about 75 from 1e6
constexpr int max_plane_steps = 60;
constexpr int max_halvings = 24;
/// Rounding of one evaluation of the forward map, relative to max(1, |distorted|): no use to ask for less.
constexpr double rounding = 4e-16;
/// How far beyond the valid disc the path to an answer may lead.
constexpr double detour = 1.05;

bool is_positive_definite(const glm::dmat2& j) {
    return j[0][0] > 0.0 && j[0][0] * j[1][1] - j[1][0] * j[0][1] > 0.0;
}

}  // namespace

/// The radius r in [0, valid radius) with r * N / D = distorted, for 0 <= distorted < max_distorted_: there the
/// function rises from 0, so the bracket [low, high] always holds the answer; Newton moves inside it, and where it
/// would leave or gains too little the bracket is halved.
double LensMap::invert_radial(double distorted) const {
    double low = 0.0, high = valid_radius_;
    double r = distorted < high ? distorted : 0.5 * high;
    double last_step = high;
    for (int i = 0; i < max_radial_steps; ++i) {
        const Radial at = radial(r * r);
        const double excess = r * at.scale - distorted;
        if (std::abs(excess) <= rounding * distorted) return r;
        (excess < 0.0 ? low : high) = r;
        double next = r - excess / at.slope;
        double step = std::abs(next - r);
        if (!(next > low && next < high) || !(step <= 0.5 * last_step)) {
            next = 0.5 * (low + high);
            step = 0.5 * (high - low);
        }
        if (next == r || !(next > low && next < high)) return low;
        r = next;
        last_step = step;
    }
    return low;
}

/// With tangential terms: Newton in the plane from the radial answer. The forward map is the gradient of a convex
/// potential on the valid disc, so the Newton direction always lowers the residual; steps are halved until they do. On
/// the way they may go a little beyond the disc as long as the Jacobian stays positive definite (the disc ends where
/// the worst direction folds; held back at its edge, steps along the edge would stall). An answer beyond the disc is
/// refused.
std::optional<glm::dvec2> LensMap::invert_with_tangential(glm::dvec2 distorted) const {
    const double size = std::hypot(distorted.x, distorted.y);
    // The tangential part is at most 3 |p| r^2 long: further out than this no point of the disc is moved.
    const double reach = 3.0 * std::hypot(p1_, p2_) * valid_radius_ * valid_radius_;
    if (!(size < max_distorted_ + reach)) return std::nullopt;
    constexpr double just_inside = 1.0 - 1e-3;
    double start = valid_radius_ * just_inside;
    if (size < max_distorted_) start = std::min(start, invert_radial(size));
    glm::dvec2 ideal = size > 0.0 ? distorted * (start / size) : glm::dvec2(0.0);

    const double leeway = detour * valid_radius_;
    const double scale = std::max(1.0, size);
    glm::dvec2 residual = distorted - distort(ideal);
    double error = glm::dot(residual, residual);
    for (int i = 0; i < max_plane_steps && error > rounding * scale * rounding * scale; ++i) {
        const glm::dmat2 j = derivative(ideal);
        const double determinant = j[0][0] * j[1][1] - j[1][0] * j[0][1];
        if (!(determinant > 0.0)) break;
        glm::dvec2 step(j[1][1] * residual.x - j[1][0] * residual.y, j[0][0] * residual.y - j[0][1] * residual.x);
        step /= determinant;
        bool better = false;
        for (int halving = 0; halving < max_halvings && !better; ++halving, step *= 0.5) {
            const glm::dvec2 next = ideal + step;
            if (!(std::hypot(next.x, next.y) < leeway)) continue;
            const glm::dvec2 next_residual = distorted - distort(next);
            const double next_error = glm::dot(next_residual, next_residual);
            if (!(next_error < error) || (!contains(next) && !is_positive_definite(derivative(next)))) continue;
            ideal = next;
            residual = next_residual;
            error = next_error;
            better = true;
        }
        if (!better) break;
    }
    if (!contains(ideal) || !(std::sqrt(error) < max_residual * scale)) return std::nullopt;
    return ideal;
}

std::optional<glm::dvec2> LensMap::undistort(glm::dvec2 distorted) const {
    if (!std::isfinite(distorted.x) || !std::isfinite(distorted.y)) return std::nullopt;
    if (identity_) return distorted;
    if (p1_ != 0.0 || p2_ != 0.0) return invert_with_tangential(distorted);
    const double size = std::hypot(distorted.x, distorted.y);
    if (size == 0.0) return glm::dvec2(0.0);
    // Next to a fold the image is flat: directions 1e-8 short of it have the very distorted radius of the fold itself.
    if (!(size <= max_distorted_ * (1.0 + 4 * rounding))) return std::nullopt;
    const glm::dvec2 ideal = distorted * (invert_radial(size) / size);
    const glm::dvec2 residual = distorted - distort(ideal);
    if (!contains(ideal) || !(std::hypot(residual.x, residual.y) < max_residual * std::max(1.0, size)))
        return std::nullopt;
    return ideal;
}

}  // namespace camrig
