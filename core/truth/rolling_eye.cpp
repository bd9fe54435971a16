#include "core/truth/rolling_eye.h"

#include <algorithm>
#include <cmath>

namespace camrig::truth {

RollingEye::RollingEye(const RowsInTime& rows, const camera::CameraModel& camera) : camera_(camera) {
    // As pictures do (render::view_at).
    const bool zooms = camera.lens().lens().model == camera::LensModel::pinhole;
    for (std::size_t i = 0; i < knots_.size(); ++i) {
        const double row = static_cast<double>(i) * (camera.size().height - 1) / (knots_.size() - 1);
        const auto moment = rows.past->at(rows.first_ns + std::llround(row * static_cast<double>(rows.row_ns)));
        knots_[i] = {glm::transpose(camera::world_from_optical_rotation(moment.state.pose)), moment.state.pose.position,
                     zooms ? moment.state.intrinsics.fx / camera.intrinsics().fx : 1.0};
        if (i == 0) first_ = moment.snapshot;
        last_ = moment.snapshot;
    }
}

glm::dvec3 RollingEye::see(const glm::dvec3& from, const glm::dvec3& to) const {
    double share = 0.5;
    glm::dvec3 seen = at(share, from, to);
    for (int i = 0; i < steps; ++i) {
        const auto pixel = camera_.project(seen);
        if (!pixel) break;
        share = std::clamp(pixel->y / std::max(1, camera_.size().height - 1), 0.0, 1.0);
        seen = at(share, from, to);
    }
    return seen;
}

glm::dvec3 RollingEye::at(double share, const glm::dvec3& from, const glm::dvec3& to) const {
    const glm::dvec3 point = glm::mix(from, to, share);
    const double place = share * static_cast<double>(knots_.size() - 1);
    const auto k = std::min(static_cast<std::size_t>(place), knots_.size() - 2);
    const Knot &a = knots_[k], &b = knots_[k + 1];
    return glm::mix(a.see(point), b.see(point), place - static_cast<double>(k));
}

}  // namespace camrig::truth
