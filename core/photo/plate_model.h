#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "core/photo/plate_task.h"
#include "core/photo/plate_view.h"

namespace camrig::photo {

/// A state of the search: the camera, and where those of known height stand.
struct PlateState {
    PlateView view;
    double k1 = 0.0;
    std::vector<glm::dvec2> feet;  ///< one of each height
};

/// A task as numbers: which of them are sought, how a step moves the state, and what is left over of the clicks.
class PlateModel {
public:
    explicit PlateModel(const PlateTask& task);

    const PlateTask& task() const { return *task_; }
    std::span<const PlateUnknown> unknowns() const { return unknowns_; }
    bool seeks(PlateUnknown unknown) const;
    /// Those of the camera, then two of each height.
    int step_size() const { return int(unknowns_.size() + 2 * task_->heights.size()); }
    int residual_count() const {
        return int(2 * task_->points.size() + 4 * task_->heights.size() + task_->lines.size());
    }
    /// Residuals that nothing sought makes good.
    int degrees_of_freedom() const { return residual_count() - step_size(); }

    PlateState moved(const PlateState& from, const Eigen::VectorXd& step) const;
    /// Pixels; lost_px of what the camera cannot see. Points first, then heights (foot, head), then lines.
    Eigen::VectorXd residuals(const PlateState& state) const;
    /// Of the residuals by the step, at 0.
    Eigen::MatrixXd jacobian(const PlateState& state) const;

    static constexpr double lost_px = 1e5;

private:
    const PlateTask* task_;
    std::vector<PlateUnknown> unknowns_;
};

struct PlateFit {
    PlateState state;
    double squares = 0.0;  ///< of the residuals
};
/// The states in which the search ends, best first, many of them the same; none where it finds nothing that sees all
/// that was clicked at.
std::vector<PlateFit> fit_plate(const PlateModel& model);

}  // namespace camrig::photo
