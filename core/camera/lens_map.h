#pragma once

#include <array>
#include <limits>
#include <optional>
#include <span>

#include <glm/glm.hpp>

#include "core/base/result.h"
#include "core/camera/interval.h"
#include "core/camera/lens.h"

namespace camrig::camera {

/// A lens of `model` from a list of coefficients; refuses a wrong count and what is not finite.
Result<Lens> make_lens(LensModel model, std::span<const double> coefficients);

/// The mathematics of one lens, exactly as OpenCV (calib3d and its fisheye module) and ROS define the coefficients.
///
/// A viewing direction is first a point of the *ideal plane*:
///     pinhole, plumb_bob, rational_polynomial   (X / Z, Y / Z), only for Z > 0
///     equidistant                               theta * (X, Y) / |(X, Y)|, theta the angle to the axis, up to 180 deg
/// and the lens moves it to a point of the *distorted plane* (focal length 1), s = |ideal|^2:
///     distorted = ideal * N(s) / D(s) + tangential
///     plumb_bob             N = 1 + k1 s + k2 s^2 + k3 s^3, D = 1
///     rational_polynomial   the same N, D = 1 + k4 s + k5 s^2 + k6 s^3
///     equidistant           N = 1 + k1 s + k2 s^2 + k3 s^3 + k4 s^4, D = 1
///     tangential            (2 p1 x y + p2 (s + 2 x^2), p1 (s + 2 y^2) + 2 p2 x y)
///
/// Real calibrations fold: beyond some radius the polynomial falls again and two directions share one pixel. The *valid
/// radius* is that of the largest disc of the ideal plane about the axis on which the map is one-to-one; outside of it
/// a direction has no pixel and a pixel no direction. It is found from the roots of polynomials, never by sampling.
/// With tangential terms the map is the gradient of a potential (its Jacobian is symmetric), so it is one-to-one where
/// the Jacobian is positive definite; its eigenvalues are at least those of the radial part less 6 |p| r, and the disc
/// ends where that bound does. (Exact in the worst direction of every barrel lens, and nowhere too large.)
///
/// Immutable; any thread.
class LensMap {
public:
    /// Refuses coefficients that are not finite or beyond 1e9, nonzero ones after the model's count, and a lens whose
    /// image folds so close to the axis (valid radius below min_valid_radius) that there is no rising branch to use.
    static Result<LensMap> create(const Lens& lens);
    /// The lens that changes nothing.
    LensMap() = default;

    const Lens& lens() const { return lens_; }
    /// The numbers of the formulas above, for those who evaluate them in their own arithmetic.
    struct Formula {
        bool is_angular = false;  ///< the ideal plane holds angles
        std::array<double, 5> numerator{1.0, 0.0, 0.0, 0.0, 0.0};
        std::array<double, 4> denominator{1.0, 0.0, 0.0, 0.0};
        double p1 = 0.0, p2 = 0.0;
    };
    Formula formula() const { return {angular_, n_, d_, p1_, p2_}; }
    /// True when distorted and ideal plane are the same for every direction with Z > 0.
    bool is_identity() const { return identity_; }

    /// Radius of the valid disc, exclusive; infinite for a pinhole. Never above max_plane_radius (plane models) or pi.
    double valid_radius() const { return valid_radius_; }
    /// Whether the disc ends where the map folds or has a pole, and not at a limit of ours.
    bool folds() const { return folds_; }
    /// Angle to the axis of the directions at the valid radius.
    double valid_angle() const;
    bool contains(glm::dvec2 ideal) const { return glm::dot(ideal, ideal) < valid_radius_ * valid_radius_; }

    /// Forward map, and its Jacobian d(distorted) / d(ideal). Plain formulas: also beyond the valid radius.
    glm::dvec2 distort(glm::dvec2 ideal) const;
    glm::dmat2 derivative(glm::dvec2 ideal) const;
    /// A piece of a curve in the ideal plane, as ranges of what its points and their derivatives by the curve's
    /// parameter are: x, y, dx, dy, s = x^2 + y^2 and half_ds = x dx + y dy, half the derivative of s.
    struct IdealCurve {
        Interval x, y, dx, dy, s, half_ds;
    };
    /// The same of its image under distort(): ranges that hold all of it; infinite ones where the piece
    /// is too long for the formulas to tell.
    struct CurveImage {
        Interval x, y, dx, dy;
    };
    CurveImage distort_curve(const IdealCurve& curve) const;
    /// Not less than the norm of derivative() anywhere within `radius` of the axis: two points there are moved to
    /// places at most so many times as far apart.
    double greatest_stretch(double radius) const;
    /// The one ideal point inside the valid disc that distort() moves here, with a residual below
    /// max_residual * max(1, |distorted|); none where there is no such point.
    std::optional<glm::dvec2> undistort(glm::dvec2 distorted) const;

    /// Ideal point of a direction of any length in the optical frame; none for a zero or not finite vector, and
    /// for directions the model does not know (Z <= 0, or exactly backwards). Not limited to the valid disc.
    std::optional<glm::dvec2> ideal_from_direction(const glm::dvec3& direction) const;
    /// Unit direction of an ideal point.
    glm::dvec3 direction_from_ideal(glm::dvec2 ideal) const;

    /// Directions within 1e-6 rad of the image plane have no place in a plane model with distortion.
    static constexpr double max_plane_radius = 1e6;
    static constexpr double min_valid_radius = 1e-3;
    static constexpr double max_residual = 1e-9;
    static constexpr double max_coefficient = 1e9;

private:
    struct Radial {
        double scale;  ///< N / D
        double slope;  ///< d(radius distorted) / d(radius ideal)
    };
    struct Local {
        glm::dvec2 distorted;
        glm::dmat2 derivative;
    };
    struct RadialRange {
        Interval scale;  ///< N / D
        Interval along;  ///< 2 d(N / D) / ds
    };
    Radial radial(double s) const;
    /// None where D may be 0.
    std::optional<RadialRange> radial_range(Interval s) const;
    glm::dvec2 tangential(glm::dvec2 ideal) const;
    Local local(glm::dvec2 ideal) const;
    void find_valid_radius();
    void fill_guesses();
    double guess_radius(double distorted) const;
    double invert_radial(double distorted, double guess) const;
    std::optional<glm::dvec2> invert_with_tangential(glm::dvec2 distorted, double size) const;

    Lens lens_;
    bool identity_ = true;
    bool angular_ = false;   ///< the ideal plane holds angles
    bool rational_ = false;  ///< D is not 1
    bool folds_ = false;
    std::array<double, 5> n_{1.0, 0.0, 0.0, 0.0, 0.0};
    std::array<double, 4> d_{1.0, 0.0, 0.0, 0.0};
    double p1_ = 0.0;
    double p2_ = 0.0;
    double valid_radius_ = std::numeric_limits<double>::infinity();
    double max_distorted_ = std::numeric_limits<double>::infinity();  ///< radial part at the valid radius

    /// Samples of the inverse radial map, only to start Newton from: radius and its derivative every guess_step_.
    struct Guess {
        double radius;
        double slope;
    };
    static constexpr int guess_cells = 64;
    std::array<Guess, guess_cells + 1> guesses_{};
    double guess_step_ = 0.0;
};

}  // namespace camrig::camera
