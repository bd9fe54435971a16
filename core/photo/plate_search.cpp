#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Dense>

#include "core/photo/plate_model.h"

// Where the search begins. A camera's place follows from its rotation and focal length by linear equations (it is the
// point nearest to all lines of sight), so only these are tried out: all over the sphere, the
// horizon level, which needs no case for points
// on a plane or in space, for heights or for lines. The best of them are improved by Levenberg and Marquardt's method.
namespace camrig::photo {
namespace {

constexpr double deg = std::numbers::pi / 180.0;
constexpr std::array focal_shares{0.25, 0.4, 0.6, 0.9, 1.3, 2.0, 3.2, 5.0, 9.0};  ///< of the longer side
constexpr double pan_step_deg = 20.0, tilt_step_deg = 15.0;
constexpr std::size_t most_starts = 20, most_finished = 6;
constexpr int first_turns = 8, most_turns = 200;
constexpr std::size_t most_points_tried = 12;

struct Start {
    PlateState state;
    double score = 0.0;
};

/// Adds that `direction` from the camera at `c` passes through point + foot: normal equations of
/// (1 - d d^T)(point + foot - c) = 0.
struct Sightings {
    Eigen::MatrixXd normal;
    Eigen::VectorXd right;

    explicit Sightings(std::size_t heights)
        : normal(Eigen::MatrixXd::Zero(Eigen::Index(3 + 2 * heights), Eigen::Index(3 + 2 * heights))),
          right(Eigen::VectorXd::Zero(Eigen::Index(3 + 2 * heights))) {}

    void add(const glm::dvec3& direction, const glm::dvec3& point, int foot) {
        const Eigen::Vector3d d(direction.x, direction.y, direction.z), at(point.x, point.y, point.z);
        const Eigen::Matrix3d off = Eigen::Matrix3d::Identity() - d * d.transpose();
        normal.topLeftCorner<3, 3>() += off;
        right.head<3>() += off * at;
        if (foot < 0) return;
        const Eigen::Index n = 3 + 2 * foot;
        normal.block<2, 2>(n, n) += off.topLeftCorner<2, 2>();
        normal.block<3, 2>(0, n) -= off.leftCols<2>();
        normal.block<2, 3>(n, 0) -= off.topRows<2>();
        right.segment<2>(n) -= (off * at).head<2>();
    }
    void fix(int unknown, double value) {
        right -= normal.col(unknown) * value;
        normal.row(unknown).setZero();
        normal.col(unknown).setZero();
        normal(unknown, unknown) = 1.0;
        right[unknown] = value;
    }
};

/// Puts the camera, whose rotation and focal length are given, where it fits best. `rays` are those of the clicks at
/// points, feet and heads.
void place(PlateState& state, const PlateModel& model, std::span<const glm::dvec3> rays) {
    const PlateTask& task = model.task();
    Sightings sightings(task.heights.size());
    const std::size_t points = std::min(task.points.size(), most_points_tried);
    const glm::dmat3& r = state.view.world_from_optical;
    for (std::size_t n = 0; n < points; ++n) sightings.add(r * rays[n], task.points[n].m, -1);
    for (std::size_t n = 0; n < task.heights.size(); ++n) {
        const KnownHeight& each = task.heights[n];
        sightings.add(r * rays[points + 2 * n], {0, 0, each.z}, int(n));
        sightings.add(r * rays[points + 2 * n + 1], {0, 0, each.z + each.height_m}, int(n));
    }
    for (int n = 0; n < 2; ++n)
        if (!model.seeks(PlateUnknown(int(PlateUnknown::x) + n))) sightings.fix(n, 0.0);
    if (task.camera_height_m) sightings.fix(2, *task.camera_height_m);
    const Eigen::VectorXd at = sightings.normal.ldlt().solve(sightings.right);
    state.view.position = {at[0], at[1], at[2]};
    for (std::size_t n = 0; n < state.feet.size(); ++n)
        state.feet[n] = {at[Eigen::Index(3 + 2 * n)], at[Eigen::Index(4 + 2 * n)]};
}

std::vector<glm::dvec3> rays_of(const PlateTask& task, const PlateView& view) {
    std::vector<glm::dvec3> rays;
    const auto add = [&](glm::dvec2 px) { rays.push_back(view.ray(px).value_or(glm::dvec3(0, 0, 1))); };
    for (std::size_t n = 0; n < std::min(task.points.size(), most_points_tried); ++n) add(task.points[n].px);
    for (const KnownHeight& each : task.heights) {
        add(each.foot_px);
        add(each.head_px);
    }
    return rays;
}

/// Robust: one click that is far off must not hide the place that fits the others.
double score_of(const PlateModel& model, const PlateState& state) {
    const double scale = 0.1 * std::max(model.task().size.width, model.task().size.height);
    double score = 0.0;
    for (const double off : model.residuals(state)) score += off * off / (off * off + scale * scale);
    return score;
}

void try_rotations(const PlateModel& model, const PlateState& with_focal, std::vector<Start>& starts) {
    const std::vector<glm::dvec3> rays = rays_of(model.task(), with_focal.view);
    const bool any_pan = model.seeks(PlateUnknown::turn_z);
    for (double pan = 0.0; pan < (any_pan ? 360.0 : 1.0); pan += pan_step_deg)
        for (double tilt = -90.0; tilt <= 75.0; tilt += tilt_step_deg) {
            Start start{with_focal, 0.0};
            const auto pose = camera::pose_from_angles(glm::dvec3(0.0), {pan * deg, tilt * deg, 0.0});
            start.state.view.world_from_optical = camera::world_from_optical_rotation(*pose);
            place(start.state, model, rays);
            start.score = score_of(model, start.state);
            if (std::isfinite(start.score)) starts.push_back(std::move(start));
        }
}

std::vector<Start> starts_of(const PlateModel& model) {
    const PlateTask& task = model.task();
    PlateState first;
    first.feet.resize(task.heights.size());
    if (const auto lens =
            camera::LensMap::create(task.fit_k1 ? camera::Lens{camera::LensModel::plumb_bob, {}} : task.lens))
        first.view.lens = *lens;
    std::vector<Start> starts;
    if (task.intrinsics) {
        first.view.k = *task.intrinsics;
        try_rotations(model, first, starts);
    } else {
        const glm::dvec2 middle =
            task.principal_px.value_or(0.5 * glm::dvec2(task.size.width - 1, task.size.height - 1));
        for (const double share : focal_shares) {
            const double focal = share * std::max(task.size.width, task.size.height);
            first.view.k = {focal, focal, middle.x, middle.y};
            try_rotations(model, first, starts);
        }
    }
    std::ranges::stable_sort(starts, {}, &Start::score);
    if (starts.size() > most_starts) starts.resize(most_starts);
    return starts;
}

/// Levenberg-Marquardt with Marquardt's scaling (Nielsen's damping). What cannot be seen costs so much that no step
/// goes there.
PlateFit improved(const PlateModel& model, PlateState state, int turns) {
    Eigen::VectorXd off = model.residuals(state);
    double squares = off.squaredNorm(), damping = 1e-3, growth = 2.0;
    for (int turn = 0; turn < turns; ++turn) {
        const Eigen::MatrixXd j = model.jacobian(state);
        const Eigen::VectorXd slope = j.transpose() * off;
        Eigen::MatrixXd normal = j.transpose() * j;
        normal.diagonal() += damping * normal.diagonal() + Eigen::VectorXd::Constant(normal.rows(), 1e-12);
        const Eigen::VectorXd step = normal.ldlt().solve(-slope);
        if (!step.allFinite()) break;
        const PlateState next = model.moved(state, step);
        const Eigen::VectorXd next_off = model.residuals(next);
        const double next_squares = next_off.squaredNorm();
        if (next_squares < squares) {
            const bool is_done = squares - next_squares <= 1e-14 * squares + 1e-22;
            state = next;
            off = next_off;
            squares = next_squares;
            damping = std::max(damping / 5.0, 1e-12);
            growth = 2.0;
            if (is_done) break;
        } else {
            damping *= growth;
            growth *= 2.0;
            if (damping > 1e12) break;
        }
    }
    return {state, squares};
}

}  // namespace

std::vector<PlateFit> fit_plate(const PlateModel& model) {
    std::vector<PlateFit> fits;
    for (const Start& start : starts_of(model)) fits.push_back(improved(model, start.state, first_turns));
    std::ranges::stable_sort(fits, {}, &PlateFit::squares);
    if (fits.size() > most_finished) fits.resize(most_finished);
    for (PlateFit& fit : fits) fit = improved(model, fit.state, most_turns);
    std::erase_if(fits, [](const PlateFit& fit) { return !(std::sqrt(fit.squares) < PlateModel::lost_px); });
    std::ranges::stable_sort(fits, {}, &PlateFit::squares);
    return fits;
}

}  // namespace camrig::photo
