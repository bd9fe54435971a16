#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "core/render/software/geometry.h"

// Points and lines through a lens, as triangles in space that the lens shows as strokes a pixel wide: a point is the
// pixel it lies in; a line has one pixel in each column that it passes, or row where it is steeper. A line is cut until
// the lens bends its pieces no more.
namespace camrig::render::software {
namespace {

/// A piece of a line is straight if its middle lies no further beside the line between its ends; so much broader than
/// a pixel is the line, that a middle between two of its pixels is not lost to both.
constexpr double straight_px = 0.01;
constexpr double half_width_px = 0.5 + straight_px;
/// What is shorter is cut no more; what is longer than this is looked at in the middle of its halves too, since a bend
/// to both sides has a straight middle.
constexpr double shortest_px = 0.5, longest_px = 8.0;
constexpr int most_cuts = 10;

class StrokeQuads {
public:
    StrokeQuads(const scene::SceneView& view, std::vector<VertexValues>& values)
        : view_(view), lens_(*view.lens), values_(values) {}

    std::span<const glm::vec3> corners() const { return corners_; }

    void add_point(const VertexValues& point) {
        if (!is_inside(point.position)) return;
        add({{{&point, {-0.5, -0.5}}, {&point, {-0.5, 0.5}}, {&point, {0.5, 0.5}}, {&point, {0.5, -0.5}}}});
    }

    void add_line(const VertexValues& from, const VertexValues& to) {
        double first = 0.0, last = 1.0;
        for (const glm::dvec4& plane : planes()) {
            const double a = height(plane, from.position), b = height(plane, to.position);
            if (a < 0.0 && b < 0.0) return;
            if (a < 0.0) first = std::max(first, a / (a - b));
            if (b < 0.0) last = std::min(last, a / (a - b));
        }
        if (!(first < last)) return;
        cut({between(from, to, first)}, {between(from, to, last)}, most_cuts);
    }

private:
    struct Corner {
        const VertexValues* at = nullptr;
        glm::dvec2 aside{0.0};  ///< pixels
    };

    std::span<const glm::dvec4> planes() const {
        return std::span(view_.frustum.planes).first(static_cast<std::size_t>(view_.frustum.count));
    }
    static double height(const glm::dvec4& plane, const glm::dvec3& p) {
        return glm::dot(glm::dvec3(plane), p) + plane.w;
    }
    bool is_inside(const glm::dvec3& p) const {
        return std::ranges::all_of(planes(), [&](const glm::dvec4& plane) { return height(plane, p) >= 0.0; });
    }
    glm::dvec2 pixel_of(const glm::dvec3& p) const { return lens_.pixel_of_ideal(lens_.ideal_of(p)); }

    /// An end of a piece, and whether the line goes on there.
    struct End {
        VertexValues at;
        bool goes_on = false;
    };
    void cut(const End& from, const End& to, int cuts_left) {
        const End middle{between(from.at, to.at, 0.5), true};
        const glm::dvec2 a = pixel_of(from.at.position), b = pixel_of(to.at.position), m = pixel_of(middle.at.position);
        const double length = glm::length(b - a);
        const double bend =
            length > 0.0 ? std::abs((b.x - a.x) * (m.y - a.y) - (b.y - a.y) * (m.x - a.x)) / length : 0.0;
        // Its ends may lie beside each other though it goes a long way round.
        const double way = glm::length(m - a) + glm::length(b - m);
        const bool is_straight = way <= shortest_px || (way <= longest_px && bend <= straight_px);
        if (cuts_left > 0 && !is_straight) {
            cut(from, middle, cuts_left - 1);
            cut(middle, to, cuts_left - 1);
            return;
        }
        const bool is_steep = std::abs(b.y - a.y) > std::abs(b.x - a.x);
        const bool runs_up = is_steep ? a.y < b.y : a.x < b.x;
        const End &low = runs_up ? from : to, &high = runs_up ? to : from;
        // So that its front is seen.
        const glm::dvec2 side = is_steep ? glm::dvec2(half_width_px, 0.0) : glm::dvec2(0.0, -half_width_px);
        // Where a flat piece meets a steep one no pixel must be left out.
        const glm::dvec2 on = is_steep ? glm::dvec2(0.0, 0.5) : glm::dvec2(0.5, 0.0);
        const glm::dvec2 before = low.goes_on ? -on : glm::dvec2(0.0), behind = high.goes_on ? on : glm::dvec2(0.0);
        add({{{&low.at, before + side},
              {&low.at, before - side},
              {&high.at, behind - side},
              {&high.at, behind + side}}});
    }

    void add(const std::array<Corner, 4>& quad) {
        std::array<glm::dvec3, 4> at;
        for (std::size_t i = 0; i < quad.size(); ++i) {
            const auto moved = moved_by(quad[i].at->position, quad[i].aside);
            if (!moved) return;
            at[i] = *moved;
        }
        for (std::size_t i = 0; i < quad.size(); ++i) {
            corners_.emplace_back(at[i]);
            values_.push_back(*quad[i].at);
            values_.back().position = at[i];
        }
    }

    /// The point as deep as p that the lens shows so many pixels beside it; none where it shows all around p as a line.
    std::optional<glm::dvec3> moved_by(const glm::dvec3& p, const glm::dvec2& pixels) const {
        const double distance = glm::length(p);
        const glm::dvec3 ahead = p / distance;
        const glm::dvec3 other = std::abs(ahead.x) < 0.5 ? glm::dvec3(1.0, 0.0, 0.0) : glm::dvec3(0.0, 1.0, 0.0);
        const glm::dvec3 u = glm::normalize(glm::cross(other, ahead)), v = glm::cross(ahead, u);
        const double step = 1e-5 * distance;
        const auto slope = [&](const glm::dvec3& along) {
            return (pixel_of(p + along * step) - pixel_of(p - along * step)) / (2.0 * step);
        };
        const glm::dmat2 pixel_from_moved(slope(u), slope(v));
        if (!(std::abs(glm::determinant(pixel_from_moved)) > 1e-9 / (distance * distance))) return std::nullopt;
        // The second time from where the first one led: the slope is that at p.
        const glm::dmat2 moved_from_pixel = glm::inverse(pixel_from_moved);
        glm::dvec2 by = moved_from_pixel * pixels;
        const auto moved = [&] { return p + u * by.x + v * by.y; };
        by += moved_from_pixel * (pixels - (pixel_of(moved()) - pixel_of(p)));
        const glm::dvec3 found = moved();
        return found * (lens_.is_wide() ? distance / glm::length(found) : p.z / found.z);
    }

    const scene::SceneView& view_;
    const scene::LensView& lens_;
    std::vector<VertexValues>& values_;
    std::vector<glm::vec3> corners_;
};

}  // namespace

void ViewGeometry::add_ray_strokes(const ViewDraw& draw, const TriangleRule& rule) {
    const world::Primitive& source = *draw.primitive->source;
    const auto end_of = [&](std::uint32_t vertex) { return end_of_stroke(draw, vertex); };
    StrokeQuads quads(view_, clipped_);
    if (source.topology == world::Topology::points) {
        for (const std::uint32_t vertex : source.indices) quads.add_point(end_of(vertex));
    } else {
        for (std::size_t i = 0; i + 1 < source.indices.size(); i += 2)
            quads.add_line(end_of(source.indices[i]), end_of(source.indices[i + 1]));
    }
    const auto count = static_cast<std::uint32_t>(quads.corners().size());
    std::vector<std::uint32_t> all(count);
    std::iota(all.begin(), all.end(), 0u);
    lens_vertices_.resize(std::max<std::size_t>(lens_vertices_.size(), draw.vertex_count + count));
    place_vertices(lens_, transform().size, glm::dmat4(1.0), quads.corners().data(), all, wide_lanes_,
                   lens_vertices_.data() + draw.vertex_count);
    for (auto& corners : made_by_clipping_) corners.clear();
    for (std::uint32_t first = draw.vertex_count; first < draw.vertex_count + count; first += 4) add_halves(first);
    assemble_rays(made_by_clipping_, lens_vertices_.data(), rule, lens_, *rays_, wide_lanes_, outline_scratch_,
                  triangles_, ray_triangles_);
}

}  // namespace camrig::render::software
