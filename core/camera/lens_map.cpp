#include "core/camera/lens_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/base/number_text.h"
#include "core/camera/polynomial.h"

namespace camrig::camera {
namespace {

constexpr double pi = std::numbers::pi;
/// Below this angle (or tangent) sin x, atan x and x are the same double; dividing by x is avoided.
constexpr double tiny = 1e-8;
/// How close to a pole the disc may come, relative to its radius. Closer, one unit in the last place of the radius
/// moves the image by so much that no inverse could keep its residual; no picture reaches so far out.
constexpr double pole_margin = 1e-4;

}  // namespace

Result<Lens> make_lens(LensModel model, std::span<const double> coefficients) {
    const auto count = static_cast<std::size_t>(coefficient_count(model));
    if (coefficients.size() != count) {
        return error(ErrorKind::invalid_argument, "lens: " + std::string(to_string(model)) + " takes " +
                                                      std::to_string(count) + " coefficients, not " +
                                                      std::to_string(coefficients.size()));
    }
    Lens lens{model, {}};
    for (std::size_t i = 0; i < count; ++i) {
        if (!std::isfinite(coefficients[i]))
            return error(ErrorKind::invalid_argument, "lens: coefficient " + std::to_string(i) + " is not finite");
        lens.coefficients[i] = coefficients[i];
    }
    return lens;
}

Result<LensMap> LensMap::create(const Lens& lens) {
    const std::string name(to_string(lens.model));
    const int count = coefficient_count(lens.model);
    const auto& k = lens.coefficients;
    for (int i = 0; i < static_cast<int>(k.size()); ++i) {
        const std::string where = "lens: " + name + " coefficient " + std::to_string(i);
        if (!std::isfinite(k[i]) || std::abs(k[i]) > max_coefficient)
            return error(ErrorKind::invalid_argument,
                         where + " is " + number_text(k[i]) + "; it must be finite and within 1e9");
        if (i >= count && k[i] != 0.0) {
            return error(ErrorKind::invalid_argument,
                         where + " is one too many; " + name + " takes " + std::to_string(count));
        }
    }

    LensMap map;
    map.lens_ = lens;
    switch (lens.model) {
        case LensModel::pinhole:
            break;
        case LensModel::rational_polynomial:
            map.d_ = {1.0, k[5], k[6], k[7]};
            map.rational_ = k[5] != 0.0 || k[6] != 0.0 || k[7] != 0.0;
            [[fallthrough]];
        case LensModel::plumb_bob:
            map.n_ = {1.0, k[0], k[1], k[4], 0.0};
            map.p1_ = k[2];
            map.p2_ = k[3];
            break;
        case LensModel::equidistant:
            map.n_ = {1.0, k[0], k[1], k[2], k[3]};
            map.angular_ = true;
            break;
    }
    map.identity_ = !map.angular_ && std::ranges::all_of(k, [](double c) { return c == 0.0; });
    if (map.identity_) return map;
    map.find_valid_radius();
    if (map.valid_radius_ < min_valid_radius) {
        return error(ErrorKind::invalid_argument,
                     "lens: these " + name + " coefficients have no rising branch: the image folds back at " +
                         number_text(map.valid_angle() * 180.0 / pi) +
                         " deg from the axis; check their order, sign and units against the calibration");
    }
    map.fill_guesses();
    return map;
}

void LensMap::find_valid_radius() {
    // d(r N/D)/dr = slope / D^2 with slope = N D + 2 s (N' D - N D'); the radial part rises until the first root of
    // slope or of D. All in s = r^2.
    const Polynomial n(n_.begin(), n_.end());
    const Polynomial d(d_.begin(), d_.end());
    const Polynomial two_s{0.0, 2.0};
    const Polynomial bend = sum(product(camera::derivative(n), d), product(n, camera::derivative(d)), -1.0);
    const Polynomial slope = sum(product(n, d), product(two_s, bend));

    const double limit = angular_ ? pi : max_plane_radius;
    const double p = std::hypot(p1_, p2_);
    double radius = limit;
    const auto ends_at = [&](std::optional<double> root) {
        const bool nearer = root && *root < radius;
        if (nearer) radius = *root;
        return nearer;
    };
    const auto root_of_s = [&](const Polynomial& q) -> std::optional<double> {
        const auto root = smallest_positive_root(q, limit * limit);
        if (!root) return std::nullopt;
        return std::sqrt(*root);
    };
    if (p == 0.0) {
        ends_at(root_of_s(slope));
    } else {
        // Both eigenvalues of the radial part (slope / D^2 along the radius, N / D across it) must exceed 6 p r.
        const Polynomial loss{0.0, -6.0 * p};
        const Polynomial d_of_r = of_square(d);
        ends_at(smallest_positive_root(sum(of_square(slope), product(loss, product(d_of_r, d_of_r))), limit));
        ends_at(smallest_positive_root(sum(of_square(n), product(loss, d_of_r)), limit));
    }
    if (rational_ && ends_at(root_of_s(d))) radius *= 1.0 - pole_margin;
    folds_ = radius < limit;
    valid_radius_ = radius;
    max_distorted_ = radius * radial(radius * radius).scale;
}

double LensMap::valid_angle() const {
    return angular_ ? valid_radius_ : std::atan(valid_radius_);
}

LensMap::Radial LensMap::radial(double s) const {
    double n = n_[4], dn = 0.0;
    for (int i = 3; i >= 0; --i) {
        dn = dn * s + n;
        n = n * s + n_[i];
    }
    if (!rational_) return {n, n + 2.0 * s * dn};
    double d = d_[3], dd = 0.0;
    for (int i = 2; i >= 0; --i) {
        dd = dd * s + d;
        d = d * s + d_[i];
    }
    const double scale = n / d;
    return {scale, scale + 2.0 * s * (dn - scale * dd) / d};
}

glm::dvec2 LensMap::tangential(glm::dvec2 v) const {
    const double xx = v.x * v.x, yy = v.y * v.y, xy = v.x * v.y;
    return {2.0 * p1_ * xy + p2_ * (3.0 * xx + yy), p1_ * (xx + 3.0 * yy) + 2.0 * p2_ * xy};
}

glm::dvec2 LensMap::distort(glm::dvec2 ideal) const {
    if (identity_) return ideal;
    return ideal * radial(glm::dot(ideal, ideal)).scale + tangential(ideal);
}

glm::dmat2 LensMap::derivative(glm::dvec2 ideal) const {
    if (identity_) return glm::dmat2(1.0);
    return local(ideal).derivative;
}

LensMap::Local LensMap::local(glm::dvec2 v) const {
    const double s = glm::dot(v, v);
    const Radial r = radial(s);
    // slope along the radius, scale across it; on the axis both are 1.
    const double along = s > 0.0 ? (r.slope - r.scale) / s : 0.0;
    const double xx = r.scale + along * v.x * v.x + 2.0 * p1_ * v.y + 6.0 * p2_ * v.x;
    const double yy = r.scale + along * v.y * v.y + 6.0 * p1_ * v.y + 2.0 * p2_ * v.x;
    const double xy = along * v.x * v.y + 2.0 * p1_ * v.x + 2.0 * p2_ * v.y;
    return {v * r.scale + tangential(v), glm::dmat2(xx, xy, xy, yy)};
}

std::optional<glm::dvec2> LensMap::ideal_from_direction(const glm::dvec3& v) const {
    if (!angular_) {
        if (!(v.z > 0.0)) return std::nullopt;
        const glm::dvec2 ideal(v.x / v.z, v.y / v.z);
        if (!std::isfinite(ideal.x) || !std::isfinite(ideal.y)) return std::nullopt;
        return ideal;
    }
    const double across = std::hypot(v.x, v.y);
    if (!std::isfinite(across) || !std::isfinite(v.z)) return std::nullopt;
    if (across <= tiny * v.z) return v.z > 0.0 ? std::optional(glm::dvec2(v.x / v.z, v.y / v.z)) : std::nullopt;
    if (across == 0.0) return std::nullopt;
    const double theta = std::atan2(across, v.z);
    return glm::dvec2(v.x / across * theta, v.y / across * theta);
}

glm::dvec3 LensMap::direction_from_ideal(glm::dvec2 ideal) const {
    if (!angular_) {
        // hypot where squares overflow, but it costs more than all the rest here.
        const double square = glm::dot(ideal, ideal) + 1.0;
        const double range = std::isfinite(square) ? std::sqrt(square) : std::hypot(ideal.x, ideal.y, 1.0);
        return glm::dvec3(ideal.x / range, ideal.y / range, 1.0 / range);
    }
    const double theta = std::sqrt(glm::dot(ideal, ideal));
    const double across = theta < tiny ? 1.0 : std::sin(theta) / theta;
    return glm::dvec3(ideal.x * across, ideal.y * across, std::cos(theta));
}

}  // namespace camrig::camera
