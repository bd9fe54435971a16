// The inverse lens map. OpenCV iterates x = (d - tangential(x)) / radial(x) a fixed number of times without looking at
// the result; that converges slowly for strong lenses, diverges for some, and beyond the fold lands anywhere. Here the
// answer is bracketed first, and only an answer whose residual was seen leaves.
#include <algorithm>
#include <cmath>

#include "core/camera/lens_map.h"

namespace camrig::camera {
namespace {

constexpr int max_radial_steps = 120;  // Newton needs 1 to 8; bisection alone at most about 75 from 1e6
constexpr int max_plane_steps = 60;
constexpr int max_halvings = 24;
/// Rounding of one evaluation of the forward map, relative to max(1, |distorted|): no use to ask for less.
constexpr double rounding = 4e-16;
/// Where Newton in the plane stops; a few roundings.
constexpr double enough = 2e-15;
/// Residuals below this are what Newton leaves when it has converged; a step that does not lower one is not halved.
constexpr double converged = 1e-13;
/// Where to start when the radial part alone has its answer at the very edge or none.
constexpr double just_inside = 1.0 - 1e-3;
/// How far beyond the valid disc the path to an answer may lead.
constexpr double detour = 1.05;
/// The table of first guesses ends short of the fold, where the inverse becomes infinitely steep, and at 4 focal
/// lengths from the axis (76 deg without distortion): few pixels lie further out, and those take a few steps more.
constexpr double guess_end = 0.98;
constexpr double max_guess_distorted = 4.0;
/// Squares of anything smaller may underflow; there every lens is the identity.
constexpr double underflow = 1e-150;

bool is_positive_definite(const glm::dmat2& j) {
    return j[0][0] > 0.0 && j[0][0] * j[1][1] - j[1][0] * j[0][1] > 0.0;
}

}  // namespace

void LensMap::fill_guesses() {
    const double step = std::min(guess_end * max_distorted_, max_guess_distorted) / guess_cells;
    double radius = 0.0;
    for (int i = 0; i <= guess_cells; ++i) {
        radius = invert_radial(i * step, radius);
        guesses_[i] = {radius, 1.0 / radial(radius * radius).slope};
    }
    guess_step_ = step;
}

/// Cubic Hermite interpolation of the table; the last entry beyond it.
double LensMap::guess_radius(double distorted) const {
    const double place = distorted / guess_step_;
    if (!(place < guess_cells)) return guesses_[guess_cells].radius;
    const int cell = static_cast<int>(place);
    const double t = place - cell, u = 1.0 - t;
    const Guess& a = guesses_[cell];
    const Guess& b = guesses_[cell + 1];
    return u * u * ((1.0 + 2.0 * t) * a.radius + t * guess_step_ * a.slope) +
           t * t * ((1.0 + 2.0 * u) * b.radius - u * guess_step_ * b.slope);
}

/// The radius r in [0, valid radius) with r * N / D = distorted, for 0 <= distorted < max_distorted_: there the
/// function rises from 0, so the bracket [low, high] always holds the answer; Newton moves inside it, and where it
/// would leave or gains too little the bracket is halved.
double LensMap::invert_radial(double distorted, double guess) const {
    double low = 0.0, high = valid_radius_;
    double r = guess < high ? guess : 0.5 * high;
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
std::optional<glm::dvec2> LensMap::invert_with_tangential(glm::dvec2 distorted, double size) const {
    // The tangential part is at most 3 |p| r^2 long: further out than this no point of the disc is moved.
    const double reach = 3.0 * std::sqrt(p1_ * p1_ + p2_ * p2_) * valid_radius_ * valid_radius_;
    if (!(size < max_distorted_ + reach)) return std::nullopt;
    const auto radial_answer = [&](glm::dvec2 d) {
        const double length = std::sqrt(glm::dot(d, d));
        if (length < underflow) return glm::dvec2(0.0);
        double r = guess_radius(length);
        if (length > guess_cells * guess_step_)
            r = length < max_distorted_ ? std::min(invert_radial(length, r), just_inside * valid_radius_)
                                        : just_inside * valid_radius_;
        return d * (r / length);
    };
    // The radial answer, then once more with the tangential part of the first taken away.
    glm::dvec2 ideal = radial_answer(distorted);
    ideal = radial_answer(distorted - tangential(ideal));

    const double leeway = detour * valid_radius_;
    const double scale = std::max(1.0, size);
    Local here = local(ideal);
    glm::dvec2 residual = distorted - here.distorted;
    double error = glm::dot(residual, residual);
    for (int i = 0; i < max_plane_steps && error > enough * scale * enough * scale; ++i) {
        const glm::dmat2& j = here.derivative;
        const double determinant = j[0][0] * j[1][1] - j[1][0] * j[0][1];
        if (!(determinant > 0.0)) break;
        glm::dvec2 step(j[1][1] * residual.x - j[1][0] * residual.y, j[0][0] * residual.y - j[0][1] * residual.x);
        step /= determinant;
        const int halvings = error < converged * scale * converged * scale ? 1 : max_halvings;
        bool better = false;
        for (int halving = 0; halving < halvings && !better; ++halving, step *= 0.5) {
            const glm::dvec2 next = ideal + step;
            if (!(glm::dot(next, next) < leeway * leeway)) continue;
            const Local there = local(next);
            const glm::dvec2 next_residual = distorted - there.distorted;
            const double next_error = glm::dot(next_residual, next_residual);
            if (!(next_error < error) || !is_positive_definite(there.derivative)) continue;
            ideal = next;
            here = there;
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
    const double size = std::sqrt(glm::dot(distorted, distorted));
    if (identity_)
        return std::isfinite(distorted.x) && std::isfinite(distorted.y) ? std::optional(distorted) : std::nullopt;
    if (!std::isfinite(size)) return std::nullopt;  // so far out no lens of ours shows anything
    if (size < underflow) return distorted;
    if (p1_ != 0.0 || p2_ != 0.0) return invert_with_tangential(distorted, size);
    // Next to a fold the image is flat: directions 1e-8 short of it have the very distorted radius of the fold itself.
    if (!(size <= max_distorted_ * (1.0 + 4 * rounding))) return std::nullopt;
    const double r = invert_radial(size, guess_radius(size));
    const double residual = r * radial(r * r).scale - size;
    const glm::dvec2 ideal = distorted * (r / size);
    if (!contains(ideal) || !(std::abs(residual) < max_residual * std::max(1.0, size))) return std::nullopt;
    return ideal;
}

}  // namespace camrig::camera
