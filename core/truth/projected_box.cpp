#include "core/truth/projected_box.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "core/camera/lens_traits.h"

namespace camrig::truth {
namespace {

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

glm::dvec2 tolerance_of(const ProjectedBox& box) {
    return glm::max(glm::dvec2(BoxProjector::tolerance_px), BoxProjector::tolerance_share * (box.max - box.min));
}

}  // namespace

BoxProjector::BoxProjector(const camera::CameraModel& camera, double near_m, double far_m)
    : camera_(camera),
      tracer_(camera),
      has_planes_(!sees_behind(camera.lens().lens().model)),
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
        if (const auto pixel = camera.project(direction)) rim_.push_back({direction, *pixel});
    }
}

bool BoxProjector::between_planes(const glm::dvec3& point) const {
    return !has_planes_ || (point.z >= near_m_ && point.z <= far_m_);
}

Result<void> BoxProjector::add(std::span<const glm::dvec3> points, const world::Primitive& primitive,
                               ProjectedBox& box) {
    seen_.assign(points.size(), std::nullopt);
    bool all_seen = true;
    // Vertices first: most edges then lie well inside of the box and need no following.
    for (const std::uint32_t index : primitive.indices) {
        if (seen_[index]) continue;
        if (between_planes(points[index])) seen_[index] = tracer_.see(points[index]);
        if (seen_[index]) {
            box.grow(seen_[index]->pixel);
        } else {
            all_seen = false;
        }
    }
    if (!all_seen) box.is_clipped = true;
    if (primitive.topology == world::Topology::points || (all_seen && !bends_)) return {};
    reach_ = bends_ ? tracer_.reach(greatest_radius()) : 0.0;
    candidates_.clear();
    const std::size_t corners = primitive.topology == world::Topology::lines ? 2 : 3;
    const std::span indices(primitive.indices);
    for (std::size_t i = 0; i + corners <= indices.size(); i += corners)
        add_surface(indices.subspan(i, corners), points, box);
    return halve_the_worst(box);
}

double BoxProjector::greatest_radius() const {
    double radius = 0.0;
    for (const auto& vertex : seen_)
        if (vertex) radius = std::max(radius, vertex->radius);
    return radius;
}

/// One line or triangle.
void BoxProjector::add_surface(std::span<const std::uint32_t> corners, std::span<const glm::dvec3> points,
                               ProjectedBox& box) {
    const bool is_whole = std::ranges::all_of(corners, [&](std::uint32_t i) { return seen_[i].has_value(); });
    const bool is_line = corners.size() == 2;
    if (is_whole && bends_) {
        for (std::size_t i = 0; i < (is_line ? 1 : corners.size()); ++i) {
            const std::uint32_t a = corners[i], b = corners[(i + 1) % corners.size()];
            if (!stays_inside(*seen_[a], *seen_[b], box)) add_edge(points[a], points[b], box);
        }
    } else if (!is_whole) {
        std::vector<glm::dvec3> polygon;
        for (const std::uint32_t corner : corners) polygon.push_back(points[corner]);
        if (has_planes_) {
            clip(polygon, [this](const glm::dvec3& p) { return p.z - near_m_; });
            if (std::isfinite(far_m_)) clip(polygon, [this](const glm::dvec3& p) { return far_m_ - p.z; });
        }
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            if (!bends_) {
                if (const auto pixel = camera_.project(polygon[i])) box.grow(*pixel);
            } else {
                add_edge(polygon[i], polygon[(i + 1) % polygon.size()], box);
            }
        }
    }
    if (!is_line && !rim_.empty() && (!is_whole || may_reach_rim(corners)))
        add_rim({points[corners[0]], points[corners[1]], points[corners[2]]}, box);
}

/// A field of more than a half sphere may end inside of a triangle whose corners are all seen.
bool BoxProjector::may_reach_rim(std::span<const std::uint32_t> corners) const {
    if (field_angle_ <= 0.5 * std::numbers::pi) return false;
    const Seen &a = *seen_[corners[0]], &b = *seen_[corners[1]], &c = *seen_[corners[2]];
    // The triangle lies within the longer of two sides from its first corner; an arc is at most pi / 2 chords long.
    const double side =
        0.5 * std::numbers::pi * std::max(glm::distance(a.place, b.place), glm::distance(a.place, c.place));
    return side >= 0.5 * std::numbers::pi || a.radius + side >= field_angle_;
}

/// No picture of an edge between two seen vertices is further from the nearer one than half of what the lens can make
/// of their distance.
bool BoxProjector::stays_inside(const Seen& a, const Seen& b, const ProjectedBox& box) const {
    const double length = glm::distance(a.place, b.place);
    if (length > tracer_.longest_step()) return false;
    const double margin = 0.5 * reach_ * length;
    const auto is_deep = [&](glm::dvec2 pixel) {
        return glm::all(glm::greaterThanEqual(pixel - margin, box.min)) &&
               glm::all(glm::lessThanEqual(pixel + margin, box.max));
    };
    return is_deep(a.pixel) && is_deep(b.pixel);
}

void BoxProjector::add_edge(const glm::dvec3& a, const glm::dvec3& b, ProjectedBox& box) {
    for (const EdgePiece& piece : tracer_.trace(a, b)) {
        box.grow(piece.at_a);
        box.grow(piece.at_b);
        consider(piece, box);
    }
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

/// How far the piece may reach beyond the box, in tolerances.
double BoxProjector::excess_of(const EdgePiece& piece, const ProjectedBox& box) {
    const glm::dvec2 beyond = glm::max(box.min - piece.min, piece.max - box.max) / tolerance_of(box);
    return std::max(beyond.x, beyond.y);
}

void BoxProjector::consider(const EdgePiece& piece, const ProjectedBox& box) {
    const double excess = excess_of(piece, box);
    if (excess <= 1.0) return;
    candidates_.push_back({piece, excess});
    std::ranges::push_heap(candidates_, {}, &Candidate::excess);
}

Result<void> BoxProjector::halve_the_worst(ProjectedBox& box) {
    while (!candidates_.empty()) {
        std::ranges::pop_heap(candidates_, {}, &Candidate::excess);
        const EdgePiece piece = candidates_.back().piece;
        candidates_.pop_back();
        const double excess = excess_of(piece, box);  // the box has grown since
        if (excess <= 1.0) continue;
        if (halvings_ >= max_halvings) {
            char text[160];
            std::snprintf(text, sizeof text, "its full box may be up to %.2g times the allowed %g px larger", excess,
                          tolerance_px);
            return error(ErrorKind::resource_exhausted,
                         std::string(text) + ", and is not known better after " + std::to_string(max_halvings) +
                             " halvings of edges: the lens magnifies too much far beside its axis; a `far` plane, a "
                             "larger `near` or a lens that folds (a smaller valid angle) ends what it sees there");
        }
        ++halvings_;
        const auto [first, second] = tracer_.halves(piece);
        box.grow(first.at_b);
        consider(first, box);
        consider(second, box);
    }
    return {};
}

}  // namespace camrig::truth
