#include <algorithm>
#include <cmath>

#include "core/render/software/geometry.h"

// Points and lines as triangles of their pixels' size, so that what comes after knows nothing of them. The rule is
// OpenGL's (4.5, 14.4.1 and 14.5.1) for a width of one pixel: a point is the pixel it lies in; a line has one pixel in
// each column that it passes, or row where it is steeper, from the diamond it starts in to before the one it ends in.
namespace camrig::render::software {
namespace {

constexpr std::int32_t half_pixel = subpixels / 2;

std::int32_t middle_of_pixel(std::int32_t at) {
    return (at + half_pixel) & -subpixels;
}

/// Where the line reaches to or from along its longer direction, in which it runs up or down: to the middle of the
/// pixel whose diamond the end lies in, if it is past that.
std::int32_t reach_of(std::int32_t along, std::int32_t across, bool runs_up) {
    const std::int32_t past = along - middle_of_pixel(along);
    const bool is_in_diamond = std::abs(past) + std::abs(across - middle_of_pixel(across)) < half_pixel;
    return is_in_diamond && (runs_up ? past > 0 : past < 0) ? along - past : along;
}

}  // namespace

VertexValues between(const VertexValues& a, const VertexValues& b, double share) {
    const auto to = static_cast<float>(share), from = 1.0f - to;
    VertexValues made{.position = a.position + (b.position - a.position) * share,
                      .normal = a.normal * from + b.normal * to,
                      .color = a.color * from + b.color * to,
                      .local = a.local * from + b.local * to,
                      .local_ahead = a.local_ahead * from + b.local_ahead * to,
                      .coordinates = {},
                      .light = a.light * from + b.light * to,
                      .light_behind = a.light_behind * from + b.light_behind * to,
                      .ambient = a.ambient * from + b.ambient * to};
    for (std::size_t i = 0; i < made.coordinates.size(); ++i)
        made.coordinates[i] = a.coordinates[i] * from + b.coordinates[i] * to;
    return made;
}

VertexValues ViewGeometry::end_of_stroke(const ViewDraw& draw, std::uint32_t vertex) const {
    VertexValues values = values_of(draw, vertex);
    values.position = glm::dvec3(draw.optical_from_local * glm::dvec4(draw.positions[vertex], 1.0));
    return values;
}

void ViewGeometry::add_strokes(const ViewDraw& draw) {
    // They have no back, and no neighbours.
    const TriangleRule rule{.draw = static_cast<std::uint32_t>(draws_.size()),
                            .first_vertex = draw.first_vertex,
                            .is_double_sided = true,
                            .keeps_thin = has_outlines_};
    if (rays_ != nullptr) return add_ray_strokes(draw, rule);
    const world::Primitive& source = *draw.primitive->source;
    const auto end_of = [&](std::uint32_t vertex) { return end_of_stroke(draw, vertex); };
    vertices_.resize(vertices_.size() + draw.vertex_count);  // the mesh's own, which nothing shows
    for (auto& corners : made_by_clipping_) corners.clear();
    if (source.topology == world::Topology::points) {
        for (const std::uint32_t vertex : source.indices) add_point(draw, end_of(vertex));
    } else {
        for (std::size_t i = 0; i + 1 < source.indices.size(); i += 2)
            add_line(draw, end_of(source.indices[i]), end_of(source.indices[i + 1]));
    }
    outside_.assign(vertices_.size() - draw.first_vertex, 0);
    assemble(made_by_clipping_, vertices_.data() + draw.first_vertex, outside_.data(), rule, wide_lanes_,
             outline_scratch_, triangles_, to_clip_);
}

void ViewGeometry::add_point(const ViewDraw& draw, const VertexValues& point) {
    const Frustum& frustum = view_.frustum;
    for (int i = 0; i < frustum.count; ++i) {
        const glm::dvec4& plane = frustum.planes[static_cast<std::size_t>(i)];
        if (!(glm::dot(glm::dvec3(plane), point.position) + plane.w >= 0.0)) return;
    }
    const ScreenVertex at = on_screen(point.position);
    // A middle that is half a pixel before the point is in, one half a pixel behind it is not.
    constexpr std::int32_t before = half_pixel - 1, behind = half_pixel + 1;
    add_quad(draw, {{{at, &point, -before, -before},
                     {at, &point, -before, behind},
                     {at, &point, behind, behind},
                     {at, &point, behind, -before}}});
}

void ViewGeometry::add_line(const ViewDraw& draw, const VertexValues& from, const VertexValues& to) {
    double first = 0.0, last = 1.0;
    const Frustum& frustum = view_.frustum;
    for (int i = 0; i < frustum.count; ++i) {
        const glm::dvec4& plane = frustum.planes[static_cast<std::size_t>(i)];
        const double a = glm::dot(glm::dvec3(plane), from.position) + plane.w;
        const double b = glm::dot(glm::dvec3(plane), to.position) + plane.w;
        if (!(a >= 0.0 || b >= 0.0)) return;
        if (a < 0.0) first = std::max(first, a / (a - b));
        if (b < 0.0) last = std::min(last, a / (a - b));
    }
    if (!(first < last)) return;
    const VertexValues begin = between(from, to, first), end = between(from, to, last);
    ScreenVertex a = on_screen(begin.position), b = on_screen(end.position);
    const bool is_steep = std::abs(b.y - a.y) > std::abs(b.x - a.x);
    const auto along = [&](ScreenVertex& of) -> std::int32_t& { return is_steep ? of.y : of.x; };
    const auto across = [&](ScreenVertex& of) -> std::int32_t& { return is_steep ? of.x : of.y; };
    const bool runs_up = along(a) < along(b);
    const std::int32_t start = reach_of(along(a), across(a), runs_up), stop = reach_of(along(b), across(b), runs_up);
    // Of the two ends of a row of pixels the lower one is in: so is the start.
    along(a) = start + (runs_up ? 0 : 1);
    along(b) = stop + (runs_up ? 0 : 1);
    const auto corner = [&](const ScreenVertex& at, const VertexValues& values, std::int32_t side) {
        return QuadCorner{at, &values, is_steep ? side : 0, is_steep ? 0 : side};
    };
    const auto& [low, low_values] = runs_up ? std::pair(a, &begin) : std::pair(b, &end);
    const auto& [high, high_values] = runs_up ? std::pair(b, &end) : std::pair(a, &begin);
    // So that its front is seen.
    const std::int32_t side = is_steep ? half_pixel : -half_pixel;
    add_quad(draw, {{corner(low, *low_values, side), corner(low, *low_values, -side), corner(high, *high_values, -side),
                     corner(high, *high_values, side)}});
}

void ViewGeometry::add_quad(const ViewDraw& draw, const std::array<QuadCorner, 4>& corners) {
    const auto first = static_cast<std::uint32_t>(vertices_.size()) - draw.first_vertex;
    for (const QuadCorner& corner : corners) {
        ScreenVertex& vertex = vertices_.emplace_back(corner.at);
        vertex.x += corner.dx;
        vertex.y += corner.dy;
        clipped_.push_back(*corner.values);
    }
    add_halves(first);
}

void ViewGeometry::add_halves(std::uint32_t first) {
    for (const std::uint32_t second : {1u, 2u}) {
        const std::array<std::uint32_t, 3> half_of_it{first, first + second, first + second + 1};
        for (std::size_t c = 0; c < 3; ++c) made_by_clipping_[c].push_back(half_of_it[c]);
    }
}

}  // namespace camrig::render::software
