#include "core/photo/plate_model.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/gtc/quaternion.hpp>

namespace camrig::photo {
namespace {

bool has_level_line(const PlateTask& task) {
    return std::ranges::any_of(task.lines, [](const AxisLine& line) { return line.axis != Axis::z; });
}

glm::dmat3 turned(const glm::dvec3& about) {
    const double angle = glm::length(about);
    return angle > 0.0 ? glm::mat3_cast(glm::angleAxis(angle, about / angle)) : glm::dmat3(1.0);
}

/// Of two clicks with the line through the vanishing point that fits them best: what of their distances from it no
/// other line would make good has the error of one click. In the plane in front of the camera, or, for a lens that sees
/// more than a plane holds, on the sphere.
double line_residual(const PlateView& view, const AxisLine& line) {
    const auto one = view.ray(line.from_px), other = view.ray(line.to_px);
    if (!one || !other) return PlateModel::lost_px;
    const glm::dvec3 axis(line.axis == Axis::x, line.axis == Axis::y, line.axis == Axis::z);
    const glm::dvec3 to = glm::transpose(view.world_from_optical) * axis;
    if (view.lens.formula().is_angular) {
        const glm::dvec3 a = glm::cross(*one, to), b = glm::cross(*other, to);
        return view.k.fx * glm::dot(glm::cross(*one, *other), to) / std::sqrt(glm::dot(a, a) + glm::dot(b, b));
    }
    const glm::dvec3 p = *one / one->z, q = *other / other->z;
    const glm::dvec2 a = to.z * glm::dvec2(p) - glm::dvec2(to), b = to.z * glm::dvec2(q) - glm::dvec2(to);
    return view.k.fx * glm::dot(glm::cross(p, q), to) / std::sqrt(glm::dot(a, a) + glm::dot(b, b));
}

}  // namespace

const char* name_of(PlateUnknown unknown) {
    constexpr const char* names[]{"turn_x_rad", "turn_y_rad", "turn_z_rad", "x_m", "y_m", "z_m", "focal_share", "k1"};
    return names[int(unknown)];
}

const char* name_of(PlateGrade grade) {
    constexpr const char* names[]{"good", "fair", "poor"};
    return names[int(grade)];
}

PlateModel::PlateModel(const PlateTask& task) : task_(&task) {
    using enum PlateUnknown;
    unknowns_ = {turn_x, turn_y};
    if (!task.points.empty() || has_level_line(task)) unknowns_.push_back(turn_z);
    if (!task.points.empty()) unknowns_.insert(unknowns_.end(), {x, y});
    if (!task.camera_height_m) unknowns_.push_back(z);
    if (!task.intrinsics) unknowns_.push_back(focal);
    if (task.fit_k1) unknowns_.push_back(k1);
}

bool PlateModel::seeks(PlateUnknown unknown) const {
    return std::ranges::find(unknowns_, unknown) != unknowns_.end();
}

PlateState PlateModel::moved(const PlateState& from, const Eigen::VectorXd& step) const {
    PlateState to = from;
    glm::dvec3 turn(0.0);
    for (std::size_t n = 0; n < unknowns_.size(); ++n) {
        const double by = step[Eigen::Index(n)];
        switch (unknowns_[n]) {
            case PlateUnknown::turn_x:
            case PlateUnknown::turn_y:
            case PlateUnknown::turn_z:
                turn[int(unknowns_[n])] = by;
                break;
            case PlateUnknown::x:
            case PlateUnknown::y:
            case PlateUnknown::z:
                to.view.position[int(unknowns_[n]) - int(PlateUnknown::x)] += by;
                break;
            case PlateUnknown::focal:
                to.view.k.fx *= std::exp(by);
                to.view.k.fy *= std::exp(by);
                break;
            case PlateUnknown::k1: {
                to.k1 += by;
                // A lens that cannot be sees nothing: the search steps back.
                const auto lens = camera::LensMap::create({camera::LensModel::plumb_bob, {to.k1}});
                if (lens)
                    to.view.lens = *lens;
                else
                    to.view.k.fx = std::numeric_limits<double>::quiet_NaN();
            }
        }
    }
    to.view.world_from_optical = turned(turn) * from.view.world_from_optical;
    for (std::size_t n = 0; n < to.feet.size(); ++n) {
        const auto at = Eigen::Index(unknowns_.size() + 2 * n);
        to.feet[n] += glm::dvec2(step[at], step[at + 1]);
    }
    return to;
}

Eigen::VectorXd PlateModel::residuals(const PlateState& state) const {
    Eigen::VectorXd all(residual_count());
    Eigen::Index next = 0;
    const auto put = [&](const glm::dvec3& point, glm::dvec2 clicked) {
        const auto at = state.view.project(point);
        const bool seen = at && std::isfinite(at->x) && std::isfinite(at->y);
        const glm::dvec2 off = seen ? glm::clamp(clicked - *at, -lost_px, lost_px) : glm::dvec2(lost_px);
        all[next++] = off.x;
        all[next++] = off.y;
    };
    for (const KnownPoint& each : task_->points) put(each.m, each.px);
    for (std::size_t n = 0; n < task_->heights.size(); ++n) {
        const KnownHeight& each = task_->heights[n];
        put({state.feet[n], each.z}, each.foot_px);
        put({state.feet[n], each.z + each.height_m}, each.head_px);
    }
    for (const AxisLine& each : task_->lines) {
        const double off = line_residual(state.view, each);
        all[next++] = std::isfinite(off) ? off : lost_px;
    }
    return all;
}

Eigen::MatrixXd PlateModel::jacobian(const PlateState& state) const {
    Eigen::MatrixXd all(residual_count(), step_size());
    const double far = 1.0 + glm::length(state.view.position);
    for (int n = 0; n < step_size(); ++n) {
        const bool is_metres = n >= int(unknowns_.size()) || (unknowns_[std::size_t(n)] >= PlateUnknown::x &&
                                                              unknowns_[std::size_t(n)] <= PlateUnknown::z);
        const double by = is_metres ? 1e-6 * far : 1e-6;
        Eigen::VectorXd step = Eigen::VectorXd::Zero(step_size());
        step[n] = by;
        const Eigen::VectorXd up = residuals(moved(state, step));
        step[n] = -by;
        all.col(n) = (up - residuals(moved(state, step))) / (2.0 * by);
    }
    return all;
}

}  // namespace camrig::photo
