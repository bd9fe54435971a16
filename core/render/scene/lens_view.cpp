#include "core/render/scene/lens_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/render/scene/detail_levels.h"

namespace camrig::render::scene {
namespace {

constexpr double pi = std::numbers::pi;
/// A fisheye whose picture ends further from the axis than this measures depth from the eye.
constexpr double wide_angle = pi / 3.0;
/// Of the end of the picture: rounding must not cut it, nor what antialiasing looks at beside it.
constexpr double end_margin = 1.02, end_margin_px = 2.0;
/// Where a plane lens ends at the latest: 0.06 deg from the image plane.
constexpr double max_plane_end = 1000.0;
/// What goes on beyond the end takes at most so many pixels; beyond a fold so much of the focal length per unit.
constexpr double max_beyond_px = 2048.0;
constexpr double fold_rise = 4e-3;
/// Of the end: how far beyond it what is not wide is cut.
constexpr double guard_margin = 1.1;
/// The border of the picture is looked at every so many pixels.
constexpr int border_step_px = 8;
constexpr double border_margin_px = 2.0;
/// Bounds of boxes: an edge of a box in so many pieces, together at most so long on the ideal plane.
constexpr int edge_pieces = 4;
constexpr double max_edge = 1.25;
constexpr double slack_px = 2.0;

struct Ball {
    glm::dvec3 middle;
    double radius;
};
Ball ball_around(const glm::dmat4& optical_from_local, const world::Box& box) {
    const glm::dvec3 half = 0.5 * (glm::dvec3(box.max) - glm::dvec3(box.min));
    const glm::dvec3 middle = 0.5 * (glm::dvec3(box.max) + glm::dvec3(box.min));
    double radius = 0.0;
    for (int corner = 0; corner < 4; ++corner) {
        const glm::dvec3 to(half.x, corner & 1 ? half.y : -half.y, corner & 2 ? half.z : -half.z);
        radius = std::max(radius, glm::length(glm::dmat3(optical_from_local) * to));
    }
    return {glm::dvec3(optical_from_local * glm::dvec4(middle, 1.0)), radius};
}

double angle_to_axis(const glm::dvec3& p) {
    return std::atan2(std::hypot(p.x, p.y), p.z);
}

}  // namespace

Result<std::shared_ptr<const LensView>> LensView::create(ImageSize size, const camera::Intrinsics& intrinsics,
                                                         const camera::Lens& lens) {
    auto model = camera::CameraModel::create(size, intrinsics, lens);
    if (!model) return std::unexpected(model.error());
    const auto view = std::shared_ptr<LensView>(new LensView(*model));
    view->find_seen();
    view->find_bend();
    if (!model->every_pixel_valid()) view->find_blind();
    return view;
}

void LensView::find_seen() {
    const camera::LensMap& lens = model_.lens();
    const bool is_angular = lens.formula().is_angular;
    const double focal = std::max(model_.intrinsics().fx, model_.intrinsics().fy);
    const double field = model_.max_field_angle();
    const double margin = end_margin_px / focal;
    end_ = is_angular
               ? std::min(pi, field * end_margin + margin)
               : std::min(max_plane_end, (field < 0.5 * pi ? std::tan(field) : max_plane_end) * end_margin + margin);
    const bool ends_at_fold = end_ >= lens.valid_radius();
    if (ends_at_fold) end_ = lens.valid_radius() * (1.0 - 1e-9);
    is_wide_ = is_angular && end_ > wide_angle;
    const auto slope_of = [&](double radius) { return is_angular && !is_wide_ ? std::tan(radius) : radius; };
    const double last = is_wide_ ? pi : std::numbers::sqrt2 * guard_margin * slope_of(end_);
    // Where the picture ends before the lens does, nothing shows a bend beside it.
    rise_ = fold_rise;
    if (!ends_at_fold)
        rise_ = std::max(rise_, std::min(lens.derivative({end_, 0.0})[0].x, lens.derivative({0.0, end_})[1].y));
    if (last > end_) rise_ = std::min(rise_, max_beyond_px / focal / (last - end_));
    const double end_slope = slope_of(end_);
    guard_ = end_slope * guard_margin;
    if (is_wide_) return;

    slope_low_ = glm::dvec2(std::numeric_limits<double>::infinity());
    slope_high_ = -slope_low_;
    const auto [width, height] = model_.size();
    const auto visit = [&](double x, double y) {
        if (const auto ray = model_.ray({x, y}); ray && ray->z > 0.0) {
            const glm::dvec2 slope = glm::clamp(glm::dvec2(*ray) / ray->z, -end_slope, end_slope);
            slope_low_ = glm::min(slope_low_, slope);
            slope_high_ = glm::max(slope_high_, slope);
        } else {
            slope_low_ = glm::dvec2(-end_slope);
            slope_high_ = glm::dvec2(end_slope);
        }
    };
    const double left = -0.5 - border_margin_px, top = left;
    const double right = width - 0.5 + border_margin_px, bottom = height - 0.5 + border_margin_px;
    for (int i = 0; i < width + border_step_px; i += border_step_px) {
        const double x = std::min(left + i, right);
        visit(x, top), visit(x, bottom);
    }
    for (int i = 0; i < height + border_step_px; i += border_step_px) {
        const double y = std::min(top + i, bottom);
        visit(left, y), visit(right, y);
    }
    visit(right, bottom);
    const glm::dvec2 more = 0.01 * (slope_high_ - slope_low_);
    slope_low_ -= more;
    slope_high_ += more;
}

void LensView::find_bend() {
    constexpr int radii = 32, turns = 8, ways = 4;
    // Between the places that are looked at it may be bent a little more. Edges that are bent less are short.
    constexpr double step = 0.01, between = 1.3, most_share = 0.25;
    const camera::LensMap& lens = model_.lens();
    const bool is_angular = lens.formula().is_angular;
    double most = 0.0;
    for (int i = 0; i < radii * turns * ways; ++i) {
        const double part = (1.0 - 0.5 * step) * (i / (turns * ways) + 1) / radii;
        // Evenly by angle: the end of a plane may be far out, where little bends any more.
        const double radius = is_angular ? end_ * part : std::tan(std::atan(end_) * part);
        const double turn = 2.0 * pi * (i / ways % turns) / turns, way = pi * (i % ways) / ways + turn;
        const double length = step * std::min(end_, 1.0 + radius);
        const glm::dvec2 middle = radius * glm::dvec2(std::cos(turn), std::sin(turn));
        const glm::dvec2 half = 0.5 * length * glm::dvec2(std::cos(way), std::sin(way));
        const auto on_ray = [&](const glm::dvec2& ideal) {
            const glm::dvec3 ray = lens.direction_from_ideal(ideal);
            return is_wide_ ? ray : ray / ray.z;
        };
        const glm::dvec3 from = on_ray(middle - half), to = on_ray(middle + half);
        const auto at = [&](double share) { return pixel_of_ideal(ideal_of(from + (to - from) * share)); };
        const glm::dvec2 a = at(0.0), b = at(1.0);
        const glm::dvec2 along = glm::normalize(b - a), off = at(0.5) - 0.5 * (a + b);
        most = std::max(most, std::abs(along.x * off.y - along.y * off.x) / (length * length));
    }
    bend_ = between * most;
    short_length_ = std::min(std::sqrt(most_bend_px / std::max(bend_, 1e-12)), most_share * std::min(end_, 1.0));
}

void LensView::find_blind() {
    const auto [width, height] = model_.size();
    const auto sees = [&](int x, int y) { return model_.ray({x, y}).has_value(); };
    const auto add = [&](int y, int x0, int x1) {
        if (!blind_.empty() && blind_.back().y == y && blind_.back().x1 == x0) {
            blind_.back().x1 = x1;
        } else {
            blind_.push_back({y, x0, x1});
        }
    };
    const auto near_rim = pixels_near_rim();
    auto next = near_rim.begin();
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width;) {
            while (next != near_rim.end() && *next < std::pair(y, x)) ++next;
            // On to the rim all see what the first one does.
            const int end = next != near_rim.end() && next->first == y ? std::max(next->second, x + 1) : width;
            if (!sees(x, y)) add(y, x, end);
            x = end;
        }
    }
}

/// The lens sees a disc of the ideal plane, on which it is one-to-one (LensMap): where that disc's rim lies in the
/// picture, and nowhere else, pixels that see something end. These are the ones on both sides of each place where a row
/// meets the rim, by rows.
std::vector<std::pair<int, int>> LensView::pixels_near_rim() const {
    // Between two places that are looked at the rim goes on by less than `step_px`.
    constexpr double step_px = 0.25, far_px = 4.0;
    const auto [width, height] = model_.size();
    const camera::LensMap& lens = model_.lens();
    const camera::LensMap::Formula formula = lens.formula();
    const camera::Intrinsics& k = model_.intrinsics();
    const double radius = lens.valid_radius(), tangential = radius * radius * std::hypot(formula.p1, formula.p2);
    // A circle, and with tangential terms a second one that runs twice as fast (LensMap).
    const double circle = lens.distort({radius, 0.0}).x - 3.0 * formula.p2 * radius * radius;
    const double px_per_rad = std::max(k.fx, k.fy) * (std::abs(circle) + 2.0 * tangential);
    std::vector<std::pair<int, int>> pixels;
    for (double turn = 0.0; turn < 2.0 * pi;) {
        const glm::dvec2 at = lens.distort(radius * glm::dvec2(std::cos(turn), std::sin(turn)));
        const double x = k.fx * at.x + k.cx, y = k.fy * at.y + k.cy;
        const double beside = std::max({-x, x - (width - 1), -y, y - (height - 1)});
        if (beside < far_px) {
            const int row = static_cast<int>(std::lround(y));
            const int first = std::max(static_cast<int>(std::floor(x - step_px)), 0);
            const int last = std::min(static_cast<int>(std::ceil(x + step_px)), width - 1);
            for (int column = first; column <= last && std::abs(y - row) <= step_px; ++column)
                pixels.emplace_back(row, column);
        }
        turn += std::max(step_px, beside - far_px) / px_per_rad;
    }
    std::ranges::sort(pixels);
    pixels.erase(std::ranges::unique(pixels).begin(), pixels.end());
    return pixels;
}

glm::dvec2 LensView::ideal_of(const glm::dvec3& p) const {
    const auto ideal = model_.lens().ideal_from_direction(p);
    // Exactly backwards, where a fisheye sees one point on all sides.
    return ideal ? *ideal : glm::dvec2(pi, 0.0);
}

glm::dvec2 LensView::pixel_of_ideal(glm::dvec2 ideal) const {
    const double radius = glm::length(ideal);
    glm::dvec2 distorted;
    if (radius > end_) {
        const glm::dvec2 last = ideal * (end_ / radius);
        distorted = model_.lens().distort(last) + rise_ * (ideal - last);
    } else {
        distorted = model_.lens().distort(ideal);
    }
    const camera::Intrinsics& k = model_.intrinsics();
    return {k.fx * distorted.x + k.cx, k.fy * distorted.y + k.cy};
}

Frustum LensView::frustum(double near_m, double far_m) const {
    const auto side = [](double x, double y, double z) { return glm::dvec4(glm::normalize(glm::dvec3(x, y, z)), 0.0); };
    Frustum frustum;
    frustum.planes[0] = side(1.0, 0.0, -slope_low_.x);
    frustum.planes[1] = side(-1.0, 0.0, slope_high_.x);
    frustum.planes[2] = side(0.0, 1.0, -slope_low_.y);
    frustum.planes[3] = side(0.0, -1.0, slope_high_.y);
    frustum.planes[4] = glm::dvec4(0.0, 0.0, 1.0, -near_m);
    frustum.planes[5] = glm::dvec4(0.0, 0.0, -1.0, far_m);
    frustum.count = far_m > near_m ? 6 : 5;
    return frustum;
}

bool LensView::may_see(const glm::dmat4& optical_from_local, const world::Box& box, double far_m) const {
    const Ball ball = ball_around(optical_from_local, box);
    const double distance = glm::length(ball.middle);
    // Not of a number: may be seen.
    if (!(distance > ball.radius)) return true;
    if (far_m > 0.0 && distance - ball.radius > far_m) return false;
    return !(angle_to_axis(ball.middle) - std::asin(ball.radius / distance) > end_);
}

std::optional<PixelRect> LensView::pixels_of(const glm::dmat4& optical_from_local, const world::Box& box,
                                             double near_m) const {
    const auto [width, height] = model_.size();
    const PixelRect whole{0, 0, width, height};
    std::array<glm::dvec3, 8> corners;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec4 local((corner & 1 ? box.max : box.min).x, (corner & 2 ? box.max : box.min).y,
                               (corner & 4 ? box.max : box.min).z, 1.0);
        corners[static_cast<std::size_t>(corner)] = glm::dvec3(optical_from_local * local);
    }
    if (is_wide_) {
        // What reaches the eye, or lies behind it, surrounds its picture.
        const Ball ball = ball_around(optical_from_local, box);
        const double distance = glm::length(ball.middle);
        if (!(distance > ball.radius + near_m)) return whole;
        if (!(angle_to_axis(ball.middle) + std::asin(ball.radius / distance) < pi)) return whole;
    } else if (!std::ranges::all_of(corners, [&](const glm::dvec3& p) { return p.z > near_m; })) {
        return whole;
    }
    // The picture of a body ends where that of its edges does.
    glm::dvec2 low(std::numeric_limits<double>::infinity()), high(-low);
    double bend = 0.0;
    for (int from = 0; from < 8; ++from) {
        for (const int axis : {1, 2, 4}) {
            if ((from & axis) != 0) continue;
            const auto depth = [&](const glm::dvec3& p) { return is_wide_ ? glm::length(p) : p.z; };
            glm::dvec3 a = corners[static_cast<std::size_t>(from)], b = corners[static_cast<std::size_t>(from | axis)];
            a /= depth(a);
            b /= depth(b);
            const glm::dvec2 first = ideal_of(a), last = ideal_of(b);
            if (!(glm::distance(first, last) < max_edge * (1.0 + std::min(glm::length(first), glm::length(last)))))
                return whole;
            std::array<glm::dvec2, edge_pieces + 1> at;
            for (int i = 0; i <= edge_pieces; ++i) {
                at[static_cast<std::size_t>(i)] = pixel_of_ideal(ideal_of(a + (b - a) * (double(i) / edge_pieces)));
                low = glm::min(low, at[static_cast<std::size_t>(i)]);
                high = glm::max(high, at[static_cast<std::size_t>(i)]);
            }
            // Between two of them an edge leaves their hull by an eighth of its bend, where that is about the same.
            for (std::size_t i = 1; i < edge_pieces; ++i)
                bend = std::max(bend, glm::length(at[i] - 0.5 * (at[i - 1] + at[i + 1])));
        }
    }
    const auto inside = [](double value, int size) { return static_cast<int>(std::clamp(value, 0.0, double(size))); };
    const double slack = slack_px + bend;
    const PixelRect rect{inside(std::floor(low.x - slack), width), inside(std::floor(low.y - slack), height),
                         inside(std::ceil(high.x + slack) + 1.0, width),
                         inside(std::ceil(high.y + slack) + 1.0, height)};
    if (rect.width() <= 0 || rect.height() <= 0) return std::nullopt;
    return rect;
}

double LensView::error_px(const ViewTransform& view, const glm::dmat4& optical_from_local, const world::Box& box,
                          double error_m) const {
    const camera::LensMap& lens = model_.lens();
    if (!is_wide_) return detail_error_px(view, optical_from_local, box, error_m) * lens.greatest_stretch(end_);
    const Ball ball = ball_around(optical_from_local, box);
    const double distance = glm::length(ball.middle);
    if (!(distance > ball.radius)) return std::numeric_limits<double>::infinity();
    const double angle = std::min(end_, angle_to_axis(ball.middle) + std::asin(ball.radius / distance));
    // An angle across the radius is theta / sin(theta) as long on the ideal plane.
    const double across = angle / std::max(1e-3, std::sin(std::max(angle, 1e-3)));
    return error_m / (distance - ball.radius) * std::max(view.intrinsics.fx, view.intrinsics.fy) * across *
           lens.greatest_stretch(angle);
}

}  // namespace camrig::render::scene
