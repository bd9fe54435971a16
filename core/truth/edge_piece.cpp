#include "core/truth/edge_piece.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/camera/lens_traits.h"

namespace camrig::truth {
namespace {

constexpr double pi = std::numbers::pi;
/// The edge of the field itself is no longer valid: this much inside of it is.
constexpr double field_inset = 1e-9;
/// Exactly backwards the equidistant model has no picture, and next to it none that doubles could follow.
constexpr double largest_angle = pi - 1e-5;
/// Below this angle the series are as good as the quotients, which lose digits.
constexpr double small_angle = 0.02;
/// Edges of ordinary meshes are shorter, as seen from the camera; and how much longer than its chord such an arc is.
constexpr double longest_chord = 0.2;
constexpr double arc_of_chord = 1.002;

/// theta / sin(theta), which takes (x, y) of a direction to its ideal point, and minus its derivative by z =
/// cos(theta). Both rise from the axis outwards.
struct Spread {
    double value;
    double by_z;
};
Spread spread_at(double z) {
    const double theta = std::acos(z);
    const double tt = theta * theta;
    if (theta < small_angle) return {1.0 + tt / 6.0 + 7.0 * tt * tt / 360.0, 1.0 / 3.0 + 2.0 * tt / 15.0};
    const double sine_square = (1.0 - z) * (1.0 + z);
    const double value = theta / std::sqrt(sine_square);
    return {value, (1.0 - value * z) / sine_square};
}

camera::LensMap::IdealCurve curve_of_line(const EdgePiece& p) {
    const glm::dvec2 a(p.a), b(p.b), step = b - a;
    const double from_a = glm::dot(a, step), from_b = glm::dot(b, step), square_a = glm::dot(a, a),
                 square_b = glm::dot(b, b);
    camera::Interval s = camera::hull(square_a, square_b);
    if (from_a < 0.0 && from_b > 0.0)  // nearest to the axis in between
        s.low = std::max(0.0, std::min(s.low, square_a - from_a * from_a / glm::dot(step, step)));
    return {camera::hull(a.x, b.x),      camera::hull(a.y, b.y), {step.x, step.x}, {step.y, step.y}, s,
            camera::hull(from_a, from_b)};
}

camera::LensMap::IdealCurve curve_of_arc(const EdgePiece& p, double radius) {
    // A sinusoid exceeds its values at both ends of a piece by this at most.
    const double bulge = 1.0 - std::cos(0.5 * p.length);
    const auto between = [bulge](double a, double b) {
        const camera::Interval range = widened(camera::hull(a, b), bulge);
        return camera::Interval{std::max(range.low, -1.0), std::min(range.high, 1.0)};
    };
    const glm::dvec3 slope_a = glm::cross(p.normal, p.a), slope_b = glm::cross(p.normal, p.b);
    const camera::Interval x = between(p.a.x, p.b.x), y = between(p.a.y, p.b.y), dx = between(slope_a.x, slope_b.x),
                           dy = between(slope_a.y, slope_b.y), dz = between(slope_a.z, slope_b.z);
    camera::Interval z = between(p.a.z, p.b.z);
    z = {std::max(z.low, std::cos(radius)), std::max(z.high, std::cos(radius))};
    const Spread nearest = spread_at(z.high), farthest = spread_at(z.low);
    const camera::Interval spread{nearest.value, farthest.value};
    const camera::Interval bend = dz * camera::Interval{nearest.by_z, farthest.by_z};
    const double inner = std::acos(z.high), outer = std::acos(z.low);
    return {
        x * spread,        y * spread, dx * spread - x * bend, dy * spread - y * bend, {inner * inner, outer * outer},
        dz * spread * -1.0};
}

/// What lies between values `a` and `b` at the ends of a piece of this length, where the slope is in `slope`.
camera::Interval between_ends(double a, double b, camera::Interval slope, double length, camera::Interval natural) {
    const camera::Interval ends = camera::hull(a, b);
    if (slope.low >= 0.0 || slope.high <= 0.0) return ends;
    const double span = slope.high - slope.low, product = slope.high * slope.low * length;
    camera::Interval range = natural;
    if (std::isfinite(span) && std::isfinite(product)) {
        range.high = std::min(range.high, (slope.high * b - slope.low * a - product) / span);
        range.low = std::max(range.low, (slope.high * a - slope.low * b + product) / span);
    }
    return {std::min(range.low, ends.low), std::max(range.high, ends.high)};
}

}  // namespace

EdgeTracer::EdgeTracer(const camera::CameraModel& camera)
    : camera_(camera),
      angular_(sees_behind(camera.lens().lens().model)),
      radius_(camera.lens().valid_radius() * (1.0 - field_inset)) {
    if (angular_) radius_ = std::min(radius_, largest_angle);
}

std::optional<EdgeTracer::Seen> EdgeTracer::see(const glm::dvec3& point) const {
    const auto ideal = camera_.lens().ideal_from_direction(point);
    if (!ideal || !camera_.lens().contains(*ideal)) return std::nullopt;
    return Seen{angular_ ? glm::normalize(point) : glm::dvec3(*ideal, 0.0), pixel_of_ideal(*ideal),
                glm::length(*ideal)};
}

glm::dvec2 EdgeTracer::pixel_of_ideal(const glm::dvec2& ideal) const {
    const glm::dvec2 distorted = camera_.lens().distort(ideal);
    const camera::Intrinsics& k = camera_.intrinsics();
    return {k.fx * distorted.x + k.cx, k.fy * distorted.y + k.cy};
}

glm::dvec2 EdgeTracer::pixel_of(const glm::dvec3& place) const {
    glm::dvec2 ideal(place);
    const double across = angular_ ? glm::length(ideal) : 0.0;
    if (across > 0.0) ideal *= std::atan2(across, place.z) / across;
    return pixel_of_ideal(ideal);
}

std::span<const EdgePiece> EdgeTracer::trace(const glm::dvec3& a, const glm::dvec3& b) {
    count_ = 0;
    if (angular_) {
        trace_arc(a, b);
    } else if (const auto ideal_a = camera_.lens().ideal_from_direction(a),
               ideal_b = camera_.lens().ideal_from_direction(b);
               ideal_a && ideal_b) {
        trace_line(glm::dvec3(*ideal_a, 0.0), glm::dvec3(*ideal_b, 0.0));
    }
    return {pieces_.data(), count_};
}

void EdgeTracer::add(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& normal, double length) {
    EdgePiece& piece = pieces_[count_++];
    piece = {.a = a, .b = b, .normal = normal, .length = length, .at_a = pixel_of(a), .at_b = pixel_of(b)};
    bound(piece);
}

void EdgeTracer::trace_line(const glm::dvec3& a, const glm::dvec3& b) {
    // |a + t (b - a)| <= radius, a quadratic in t.
    const glm::dvec3 step = b - a;
    const double square = glm::dot(step, step);
    if (!(square > 0.0) || !std::isfinite(square)) return;
    const double half = glm::dot(a, step), rest = glm::dot(a, a) - radius_ * radius_;
    double from = 0.0, to = 1.0;
    if (rest > 0.0 || glm::dot(b, b) > radius_ * radius_) {
        const double discriminant = half * half - square * rest;
        if (!(discriminant > 0.0)) return;
        // Never the difference of two near numbers (Press et al., Numerical Recipes, section 5.6).
        const double q = -(half + std::copysign(std::sqrt(discriminant), half));
        const camera::Interval within = camera::hull(q / square, rest / q);
        from = std::max(from, within.low);
        to = std::min(to, within.high);
        if (!(from < to)) return;
    }
    add(a + from * step, a + to * step, glm::dvec3(0.0), 1.0);
}

void EdgeTracer::trace_arc(const glm::dvec3& a, const glm::dvec3& b) {
    const double length_a = glm::length(a), length_b = glm::length(b);
    if (!(length_a > 0.0 && length_b > 0.0)) return;
    const glm::dvec3 first = a / length_a, last = b / length_b, across = glm::cross(first, last);
    const double sine = glm::length(across);
    if (!(sine > 0.0)) return;  // one direction only, or straight through the camera
    const glm::dvec3 normal = across / sine, ahead = glm::cross(normal, first);
    const double angle = std::atan2(sine, glm::dot(first, last));
    const auto direction_at = [&](double turn) { return std::cos(turn) * first + std::sin(turn) * ahead; };
    // The cosine to the axis is most * cos(turn - nearest); within the field it is at least cos(radius).
    const double most = std::hypot(first.z, ahead.z), nearest = std::atan2(ahead.z, first.z), least = std::cos(radius_);
    if (most <= least) return;
    if (-most >= least) return add(first, last, normal, angle);
    const double half = std::acos(least / most);
    for (const double middle : {nearest, nearest + 2.0 * pi}) {
        const double from = std::max(0.0, middle - half), to = std::min(angle, middle + half);
        if (from < to) add(direction_at(from), direction_at(to), normal, to - from);
    }
}

std::pair<EdgePiece, EdgePiece> EdgeTracer::halves(const EdgePiece& piece) const {
    std::pair<EdgePiece, EdgePiece> halves{piece, piece};
    glm::dvec3 middle = 0.5 * (piece.a + piece.b);
    if (angular_) {
        const double half = 0.5 * piece.length;
        middle = glm::normalize(std::cos(half) * piece.a + std::sin(half) * glm::cross(piece.normal, piece.a));
        halves.first.length = halves.second.length = half;
    }
    halves.first.b = halves.second.a = middle;
    halves.first.at_b = halves.second.at_a = pixel_of(middle);
    bound(halves.first);
    bound(halves.second);
    return halves;
}

void EdgeTracer::bound(EdgePiece& piece) const {
    const auto curve = angular_ ? curve_of_arc(piece, radius_) : curve_of_line(piece);
    const camera::LensMap::CurveImage image = camera_.lens().distort_curve(curve);
    const camera::Intrinsics& k = camera_.intrinsics();
    const camera::Interval x =
        between_ends(piece.at_a.x, piece.at_b.x, image.dx * k.fx, piece.length, image.x * k.fx + k.cx);
    const camera::Interval y =
        between_ends(piece.at_a.y, piece.at_b.y, image.dy * k.fy, piece.length, image.y * k.fy + k.cy);
    piece.min = {x.low, y.low};
    piece.max = {x.high, y.high};
}

double EdgeTracer::longest_step() const {
    return angular_ ? longest_chord : std::numeric_limits<double>::infinity();
}

double EdgeTracer::reach(double radius) const {
    // A disc holds the lines between its points; an arc reaches beyond its ends by half of its length at most.
    const double furthest = angular_ ? radius + longest_chord : radius;
    if (furthest > radius_) return std::numeric_limits<double>::infinity();
    const double arcs = angular_ ? spread_at(std::cos(furthest)).value * arc_of_chord : 1.0;
    const camera::Intrinsics& k = camera_.intrinsics();
    return camera_.lens().greatest_stretch(furthest) * std::max(k.fx, k.fy) * arcs;
}

}  // namespace camrig::truth
