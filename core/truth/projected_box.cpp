#include "core/truth/projected_box.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace camrig {
namespace {

/// Halving an arc of the sphere so often leaves less than 1e-7 rad of it.
constexpr int max_depth = 25;
constexpr int rim_points = 720;
/// The rim itself is no longer valid: this much inside of it is.
constexpr double rim_inset = 1e-9;

double angle_between(const glm::dvec3& a, const glm::dvec3& b) {
    return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

/// Keeps of a convex polygon what has keep(distance) >= 0, where distance is linear in the point.
template <typename Distance>
void clip(std::vector<glm::dvec3>& polygon, Distance&& distance) {
    std::vector<glm::dvec3> kept;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const glm::dvec3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
        const double at_a = distance(a), at_b = distance(b);
        if (at_a >= 0.0) kept.push_back(a);
        if ((at_a >= 0.0) != (at_b >= 0.0)) kept.push_back(glm::mix(a, b, at_a / (at_a - at_b)));
    }
    polygon.swap(kept);
}

/// Whether the ray from the origin meets the triangle.
bool meets(const glm::dvec3& direction, const glm::dvec3 (&t)[3]) {
    // The signed volumes over the three edges have one sign, and the plane lies ahead.
    const double u = glm::dot(direction, glm::cross(t[0], t[1]));
    const double v = glm::dot(direction, glm::cross(t[1], t[2]));
    const double w = glm::dot(direction, glm::cross(t[2], t[0]));
    if ((u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0)) return false;
    return (u + v + w) * glm::dot(t[0], glm::cross(t[1], t[2])) > 0.0;
}

}  // namespace

BoxProjector::BoxProjector(const CameraModel& camera, double near_m, double far_m)
    : camera_(camera),
      has_planes_(camera.lens().lens().model != LensModel::equidistant),
      bends_(!camera.lens().is_identity()),
      near_m_(near_m),
      far_m_(far_m > 0.0 ? far_m : std::numeric_limits<double>::infinity()),
      field_angle_(camera.lens().valid_angle()) {
    if (has_planes_ && !camera.lens().folds()) return;
    const double radius = camera.lens().valid_radius() * (1.0 - rim_inset);
    for (int i = 0; i < rim_points; ++i) {
        const double turn = 2.0 * std::numbers::pi * i / rim_points;
        const glm::dvec3 direction =
            camera.lens().direction_from_ideal(radius * glm::dvec2(std::cos(turn), std::sin(turn)));
        if (const Pixel pixel = camera.project(direction)) rim_.push_back({direction, *pixel});
    }
}

bool BoxProjector::between_planes(const glm::dvec3& point) const {
    return !has_planes_ || (point.z >= near_m_ && point.z <= far_m_);
}

BoxProjector::Pixel BoxProjector::pixel_of(const glm::dvec3& point) const {
    return between_planes(point) ? camera_.project(point) : std::nullopt;
}

void BoxProjector::add(std::span<const glm::dvec3> points, const Primitive& primitive, ProjectedBox& box) const {
    std::vector<char> is_seen(points.size());
    bool all_seen = true;
    // Vertices first: most edges then lie well inside of the box and need no following.
    for (const std::uint32_t index : primitive.indices) {
        if (is_seen[index]) continue;
        if (const Pixel pixel = pixel_of(points[index])) {
            box.grow(*pixel);
            is_seen[index] = 1;
        } else {
            all_seen = false;
        }
    }
    if (!all_seen) box.is_clipped = true;
    if (primitive.topology == Topology::points || (all_seen && !bends_)) return;
    const auto& indices = primitive.indices;
    if (primitive.topology == Topology::lines) {
        for (std::size_t i = 0; i + 1 < indices.size(); i += 2)
            add_segment(points[indices[i]], points[indices[i + 1]], box);
        return;
    }
    for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
        const glm::dvec3 corners[3] = {points[indices[i]], points[indices[i + 1]], points[indices[i + 2]]};
        const bool is_whole = is_seen[indices[i]] && is_seen[indices[i + 1]] && is_seen[indices[i + 2]];
        if (!is_whole || bends_) add_triangle(corners, is_whole, box);
    }
}

void BoxProjector::add_segment(glm::dvec3 a, glm::dvec3 b, ProjectedBox& box) const {
    if (has_planes_) {
        std::vector<glm::dvec3> ends{a, b, b};  // a polygon without area
        clip(ends, [this](const glm::dvec3& p) { return p.z - near_m_; });
        if (std::isfinite(far_m_)) clip(ends, [this](const glm::dvec3& p) { return far_m_ - p.z; });
        if (ends.size() < 2) return;
        a = ends.front();
        b = *std::ranges::max_element(ends, {}, [&](const glm::dvec3& p) { return glm::length(p - a); });
    }
    const Pixel at_a = camera_.project(a), at_b = camera_.project(b);
    if (at_a) box.grow(*at_a);
    if (at_b) box.grow(*at_b);
    walk(a, at_a, b, at_b, 0, box);
}

void BoxProjector::add_triangle(const glm::dvec3 (&corners)[3], bool is_whole, ProjectedBox& box) const {
    std::vector<glm::dvec3> polygon(std::begin(corners), std::end(corners));
    if (!is_whole && has_planes_) {
        clip(polygon, [this](const glm::dvec3& p) { return p.z - near_m_; });
        if (std::isfinite(far_m_)) clip(polygon, [this](const glm::dvec3& p) { return far_m_ - p.z; });
    }
    std::vector<Pixel> pixels;
    for (const glm::dvec3& corner : polygon) {
        pixels.push_back(camera_.project(corner));
        if (pixels.back()) box.grow(*pixels.back());
    }
    if (bends_ || !is_whole) {
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const std::size_t next = (i + 1) % polygon.size();
            walk(polygon[i], pixels[i], polygon[next], pixels[next], 0, box);
        }
    }
    if (!is_whole && !rim_.empty()) add_rim(corners, box);
}

/// Where a surface goes on beyond the field, its picture ends at the rim of the field, which no edge need touch.
void BoxProjector::add_rim(const glm::dvec3 (&corners)[3], ProjectedBox& box) const {
    glm::dvec3 middle(0.0);
    for (const glm::dvec3& corner : corners) {
        if (corner == glm::dvec3(0.0)) return;
        middle += glm::normalize(corner);
    }
    double reach = 0.0;
    for (const glm::dvec3& corner : corners) reach = std::max(reach, angle_between(middle, corner));
    const double off_axis = angle_between(middle, glm::dvec3(0.0, 0.0, 1.0));
    const bool is_small = reach < std::numbers::pi / 2;
    if (is_small && (off_axis - reach > field_angle_ || off_axis + reach < field_angle_)) return;
    for (const RimPoint& rim : rim_) {
        const bool is_inside =
            glm::all(glm::greaterThanEqual(rim.pixel, box.min)) && glm::all(glm::lessThanEqual(rim.pixel, box.max));
        if (!is_inside && meets(rim.direction, corners)) box.grow(rim.pixel);
    }
}

/// Follows the picture of the arc between two directions. Only directions count, so halving the arc halves the work
/// evenly, however near one end is.
void BoxProjector::walk(const glm::dvec3& a, const Pixel& at_a, const glm::dvec3& b, const Pixel& at_b, int depth,
                        ProjectedBox& box) const {
    if (depth >= max_depth) return;
    const double length_a = glm::length(a), length_b = glm::length(b);
    if (length_a == 0.0 || length_b == 0.0) return;
    const glm::dvec3 sum = a / length_a + b / length_b;
    if (glm::length(sum) < 1e-12) return;  // through the camera itself
    const glm::dvec3 middle = glm::normalize(sum);
    if (at_a && at_b) {
        if (!bends_) return;
        const double chord = glm::distance(*at_a, *at_b);
        if (chord <= max_chord_px) return;
        const auto is_deep = [&](glm::dvec2 pixel) {
            return glm::all(glm::greaterThan(pixel - chord, box.min)) &&
                   glm::all(glm::lessThan(pixel + chord, box.max));
        };
        if (is_deep(*at_a) && is_deep(*at_b)) return;
    } else if (!at_a && !at_b) {
        // Both ends are outside of the field: the arc between them may still cross it.
        const double half = 0.5 * angle_between(a, b);
        if (angle_between(middle, glm::dvec3(0.0, 0.0, 1.0)) - half >= field_angle_) return;
    }
    const Pixel at_middle = camera_.project(middle);
    if (at_middle) box.grow(*at_middle);
    walk(a, at_a, middle, at_middle, depth + 1, box);
    walk(middle, at_middle, b, at_b, depth + 1, box);
}

}  // namespace camrig
