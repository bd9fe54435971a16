#include "core/render/software/lens_pieces.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/render/software/lens_formula.h"

namespace camrig {
namespace {

/// Halves of an edge are a quarter as bent, about; below this much of what may be, nobody looks again.
constexpr float certain = 0.7f;
/// Edges with a joint are divided until they are no longer than this, in squares of what is straight anyway.
constexpr float joint_length2 = 4.0f;
/// How far at most the inside of a triangle is from its nearest corner, in its longest edges, and some more.
constexpr float reach = 0.6f;
constexpr double beside_px = 1.0;

}  // namespace

void LensPieces::begin_view(const LensView& lens, const ViewTransform& view) {
    lens_ = &lens;
    numbers_ = LensNumbers(lens, view);
    size_ = view.size;
    simple_share_ = static_cast<float>(lens.simple_share());
    made_ = 0;
}

LensPieces::Point LensPieces::point_at(const glm::dvec3& p, const glm::dvec3& shares) const {
    Point made{.p = p, .shares = shares, .w = p.z, .px = glm::dvec2(0.0), .ideal = glm::vec2(0.0f), .radius = 0.0f};
    if (numbers_.is_wide) made.w = std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
    const double inverse = 1.0 / made.w, u = p.x * inverse, v = p.y * inverse;
    const auto seen_at = through_lens<float>(numbers_, static_cast<float>(u), static_cast<float>(v),
                                             numbers_.is_wide ? static_cast<float>(p.z * inverse) : 1.0f);
    const double factor = seen_at.factor;
    made.px = {(u * factor + static_cast<double>(seen_at.aside_x)) * numbers_.k.fx + numbers_.k.cx,
               (v * factor + static_cast<double>(seen_at.aside_y)) * numbers_.k.fy + numbers_.k.cy};
    made.ideal = {seen_at.ideal_x, seen_at.ideal_y};
    made.radius = seen_at.radius;
    return made;
}

ScreenVertex LensPieces::on_screen(const Point& point) const {
    const double inverse = 1.0 / point.w;
    return {.x = static_cast<std::int32_t>(std::lrint(point.px.x * subpixels)),
            .y = static_cast<std::int32_t>(std::lrint(point.px.y * subpixels)),
            .depth = static_cast<float>(numbers_.depth_scale + numbers_.depth_shift * inverse),
            .inverse_z = static_cast<float>(inverse)};
}

template <typename Height>
void LensPieces::cut(std::vector<std::uint32_t>& polygon, const Height& height) {
    // Sutherland and Hodgman, Reentrant Polygon Clipping, 1974.
    kept_.clear();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const std::uint32_t from = polygon[i], to = polygon[(i + 1) % polygon.size()];
        const double a = height(points_[from]), b = height(points_[to]);
        if (a >= 0.0) kept_.push_back(from);
        if ((a >= 0.0) == (b >= 0.0)) continue;
        // Always from the inner to the outer end: the neighbour over this edge finds the same point.
        const Point &in = points_[a >= 0.0 ? from : to], &out = points_[a >= 0.0 ? to : from];
        const double in_height = std::max(a, b), share = in_height / (in_height - std::min(a, b));
        kept_.push_back(static_cast<std::uint32_t>(points_.size()));
        points_.push_back(point_at(in.p + (out.p - in.p) * share, in.shares + (out.shares - in.shares) * share));
    }
    polygon.swap(kept_);
}

void LensPieces::divide(const std::array<glm::dvec3, 3>& corners) {
    points_.clear();
    pieces_.clear();
    for (std::size_t i = 0; i < 3; ++i) {
        // Not of numbers: not seen.
        if (!(glm::dot(corners[i], corners[i]) < 1e60)) return;
        glm::dvec3 shares(0.0);
        shares[static_cast<glm::length_t>(i)] = 1.0;
        points_.push_back(point_at(corners[i], shares));
    }
    polygon_.assign({0, 1, 2});
    if (!numbers_.is_wide) {
        const double near_m = numbers_.near_m, guard = numbers_.guard;
        cut(polygon_, [=](const Point& at) { return at.p.z - near_m; });
        cut(polygon_, [=](const Point& at) { return guard * at.p.z + at.p.x; });
        cut(polygon_, [=](const Point& at) { return guard * at.p.z - at.p.x; });
        cut(polygon_, [=](const Point& at) { return guard * at.p.z + at.p.y; });
        cut(polygon_, [=](const Point& at) { return guard * at.p.z - at.p.y; });
    }
    const std::vector<std::uint32_t> polygon = polygon_;
    for (std::size_t i = 2; i < polygon.size(); ++i)
        divide({{polygon[0], polygon[i - 1], polygon[i]}, {not_known, not_known, not_known}}, 0);
}

LensPieces::Edge LensPieces::look_at(std::uint32_t from, std::uint32_t to, float bend) const {
    const Point &a = points_[from], &b = points_[to];
    Edge edge;
    const glm::vec2 apart = b.ideal - a.ideal;
    edge.length2 = apart.x * apart.x + apart.y * apart.y;
    if ((bend != not_known && bend <= certain) || edge.length2 <= numbers_.straight_length2) return edge;
    // Half way as it appears: everything here is the same from the other end.
    const double sum = a.w + b.w, share_a = b.w / sum, share_b = a.w / sum;
    edge.middle = point_at(a.p * share_a + b.p * share_b, a.shares * share_a + b.shares * share_b);
    const glm::dvec2 off = edge.middle.px - 0.5 * (a.px + b.px), along = b.px - a.px;
    const double length2 = glm::dot(along, along), off2 = glm::dot(off, off);
    const double slide = std::abs(glm::dot(along, off)) / std::sqrt(std::max(length2, 1e-12));
    const double sag = std::sqrt(std::max(0.0, off2 - slide * slide));
    double most = std::max(sag / LensView::max_sag_px, slide / LensView::max_slide_px);
    if (numbers_.is_wide)
        most = std::max(most, std::abs(1.0 - edge.middle.w * sum / (2.0 * a.w * b.w)) / LensView::max_depth_share);
    edge.shift_px = static_cast<float>(std::sqrt(off2));
    edge.bend = static_cast<float>(most);
    const float simple = simple_share_ * std::min(numbers_.end, 1.0f + std::min(a.radius, b.radius));
    edge.is_long = edge.length2 > simple * simple;
    // Where the lens ends its curve has a joint.
    edge.has_joint = (a.radius > numbers_.end) != (b.radius > numbers_.end);
    edge.is_bent = edge.is_long || !(edge.bend <= 1.0f) ||
                   (edge.has_joint && edge.length2 > joint_length2 * numbers_.straight_length2);
    return edge;
}

bool LensPieces::is_outside(const Piece& piece, const std::array<Edge, 3>& edges) const {
    const Point &a = points_[piece.at[0]], &b = points_[piece.at[1]], &c = points_[piece.at[2]];
    const float longest2 = std::max({edges[0].length2, edges[1].length2, edges[2].length2});
    if (std::min({a.radius, b.radius, c.radius}) - reach * std::sqrt(longest2) > numbers_.seen) return true;
    const auto all = [&](const auto& is_beside) { return is_beside(a) && is_beside(b) && is_beside(c); };
    if (!numbers_.is_wide) {
        const glm::dvec2 low = lens_->slope_low(), high = lens_->slope_high();
        if (all([&](const Point& at) { return at.p.x < low.x * at.p.z; }) ||
            all([&](const Point& at) { return at.p.x > high.x * at.p.z; }) ||
            all([&](const Point& at) { return at.p.y < low.y * at.p.z; }) ||
            all([&](const Point& at) { return at.p.y > high.y * at.p.z; }))
            return true;
    } else if (all([&](const Point& at) { return at.w < numbers_.near_m; })) {
        return true;
    }
    if (edges[0].is_long || edges[1].is_long || edges[2].is_long) return false;
    const double margin = beside_px + 2.0 * std::max({edges[0].shift_px, edges[1].shift_px, edges[2].shift_px});
    const double left = -0.5 - margin, right = size_.width - 0.5 + margin, bottom = size_.height - 0.5 + margin;
    return all([&](const Point& at) { return at.px.x < left; }) ||
           all([&](const Point& at) { return at.px.x > right; }) ||
           all([&](const Point& at) { return at.px.y < left; }) ||
           all([&](const Point& at) { return at.px.y > bottom; });
}

void LensPieces::divide(const Piece& piece, int depth) {
    std::array<Edge, 3> edges;
    for (std::size_t i = 0; i < 3; ++i) edges[i] = look_at(piece.at[i], piece.at[(i + 1) % 3], piece.bend[i]);
    if (is_outside(piece, edges)) return;
    const int bent = edges[0].is_bent + edges[1].is_bent + edges[2].is_bent;
    if (bent == 0 || depth == max_depth || made_ >= max_pieces) {
        // Still long: it surrounds the eye, or what lies right behind a fisheye.
        if (!edges[0].is_long && !edges[1].is_long && !edges[2].is_long) add(piece);
        return;
    }
    std::array<std::uint32_t, 3> middle{};
    std::array<float, 3> half{};  // the bend of each edge's halves, and of what runs beside it inside the piece
    for (std::size_t i = 0; i < 3; ++i) {
        const bool is_known = edges[i].is_bent && !edges[i].is_long && !edges[i].has_joint;
        // Beside a fold what slides along an edge may lie across its halves.
        const float most = std::max(edges[i].bend, edges[i].shift_px / static_cast<float>(LensView::max_sag_px));
        half[i] = is_known ? 0.25f * most : not_known;
        if (!edges[i].is_bent) continue;
        middle[i] = static_cast<std::uint32_t>(points_.size());
        points_.push_back(edges[i].middle);
    }
    if (bent == 3) {
        const auto [a, b, c] = piece.at;
        const auto [ab, bc, ca] = middle;
        divide({{a, ab, ca}, {half[0], half[1], half[2]}}, depth + 1);
        divide({{ab, b, bc}, {half[0], half[1], half[2]}}, depth + 1);
        divide({{ca, bc, c}, {half[0], half[1], half[2]}}, depth + 1);
        divide({{bc, ca, ab}, {half[0], half[1], half[2]}}, depth + 1);
        return;
    }
    // Turned so that the first edge is bent, and with two of them the second too.
    std::size_t i = 0;
    while (!edges[i].is_bent || (bent == 2 && !edges[(i + 1) % 3].is_bent)) ++i;
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    const std::uint32_t a = piece.at[i], b = piece.at[j], c = piece.at[k];
    const std::uint32_t ab = middle[i], bc = middle[j];
    constexpr float straight = 0.0f;
    if (bent == 1) {
        divide({{a, ab, c}, {half[i], not_known, straight}}, depth + 1);
        divide({{ab, b, c}, {half[i], straight, not_known}}, depth + 1);
    } else {
        divide({{ab, b, bc}, {half[i], half[j], not_known}}, depth + 1);
        divide({{a, ab, bc}, {half[i], not_known, not_known}}, depth + 1);
        divide({{a, bc, c}, {not_known, half[j], straight}}, depth + 1);
    }
}

bool LensPieces::is_beyond_end(const Piece& piece) const {
    float inner2 = std::numeric_limits<float>::infinity(), longest2 = 0.0f;
    for (std::size_t i = 0; i < 3; ++i) {
        const Point &a = points_[piece.at[i]], &b = points_[piece.at[(i + 1) % 3]];
        inner2 = std::min(inner2, a.radius * a.radius);
        longest2 = std::max(longest2, glm::dot(b.ideal - a.ideal, b.ideal - a.ideal));
    }
    // No edge comes nearer to the axis than its middle would, and a triangle around the axis has longer ones.
    const float seen2 = numbers_.seen * numbers_.seen;
    return longest2 < seen2 && inner2 - 0.25f * longest2 > seen2;
}

void LensPieces::add(const Piece& piece) {
    const auto keep = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        pieces_.push_back({a, b, c});
        ++made_;
    };
    const auto [a, b, c] = piece.at;
    const double near_m = numbers_.near_m;
    if (is_beyond_end(piece)) return;
    const auto is_near = [&](std::uint32_t i) { return points_[i].w < near_m; };
    if (!numbers_.is_wide || (!is_near(a) && !is_near(b) && !is_near(c))) {
        keep(a, b, c);
        return;
    }
    polygon_.assign({a, b, c});
    cut(polygon_, [=](const Point& at) { return at.w - near_m; });
    for (std::size_t i = 2; i < polygon_.size(); ++i) keep(polygon_[0], polygon_[i - 1], polygon_[i]);
}

}  // namespace camrig
