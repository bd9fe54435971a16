#include "core/photo/calibrate_plate.h"

#include <cmath>
#include <string>

#include <boost/math/distributions/chi_squared.hpp>

#include "core/photo/plate_checks.h"
#include "core/photo/plate_uncertainty.h"

namespace camrig::photo {
namespace {

/// Clicks that are further off than this share of the photo's diagonal belong to no camera.
constexpr double wild_share = 0.01;
/// One click is to blame where the others are so many times better without it.
constexpr double outlier_factor = 4.0;
constexpr double suspicious_px = 1.5;
/// A stated click error is believed unless the residuals are that improbable.
constexpr double believed = 0.999;
constexpr double good_share = 0.02, fair_share = 0.05;

bool is_elsewhere(const PlateView& one, const PlateView& other, double way) {
    const glm::dmat3 turn = glm::transpose(one.world_from_optical) * other.world_from_optical;
    const double cosine = 0.5 * (turn[0][0] + turn[1][1] + turn[2][2] - 1.0);
    return glm::distance(one.position, other.position) > 0.02 * way || cosine < 0.999;
}

/// A second camera that the clicks allow: as probable as one in twenty beside the best.
Result<void> check_only_one(const PlateModel& model, const std::vector<PlateFit>& fits, double click_px) {
    const PlateTask& task = model.task();
    if (task.points.empty()) return {};
    const PlateView& best = fits[0].state.view;
    double way = 0.0;
    for (const KnownPoint& each : task.points) way = std::max(way, glm::distance(each.m, best.position));
    const double margin = 6.0 * click_px * click_px;
    for (const PlateFit& each : fits) {
        if (each.squares > fits[0].squares + margin) break;
        if (!is_elsewhere(best, each.state.view, way)) continue;
        const auto text = [](const glm::dvec3& p) {
            return "[" + short_number(p.x) + ", " + short_number(p.y) + ", " + short_number(p.z) + "]";
        };
        return error(ErrorKind::invalid_argument,
                     "points: fit a camera at " + text(best.position) + " and one at " +
                         text(each.state.view.position) +
                         " alike; give one more, away from the others or of another height");
    }
    return {};
}

/// Without points nothing tells a level line's two ways apart: the camera that looks along x rather than against it.
void prefer_ahead(const PlateTask& task, std::vector<PlateFit>& fits) {
    if (!task.points.empty()) return;
    std::size_t best = 0;
    const auto ahead = [&](std::size_t n) { return fits[n].state.view.world_from_optical[2].x; };
    for (std::size_t n = 1; n < fits.size() && fits[n].squares <= 1.001 * fits[0].squares + 1e-6; ++n)
        if (ahead(n) > ahead(best) + 1e-6) best = n;
    std::swap(fits[0], fits[best]);
}

void fill_residuals(const PlateModel& model, const PlateState& state, PlateCalibration& calibration) {
    const PlateTask& task = model.task();
    const Eigen::VectorXd off = model.residuals(state);
    Eigen::Index next = 0;
    const auto pair = [&](std::string of) {
        const glm::dvec2 each(off[next], off[next + 1]);
        calibration.residuals.push_back({std::move(of), glm::length(each), each});
        next += 2;
    };
    for (std::size_t n = 0; n < task.points.size(); ++n) pair("points[" + std::to_string(n) + "]");
    for (std::size_t n = 0; n < task.heights.size(); ++n) {
        pair("heights[" + std::to_string(n) + "].foot_px");
        pair("heights[" + std::to_string(n) + "].head_px");
    }
    for (std::size_t n = 0; n < task.lines.size(); ++n)
        calibration.residuals.push_back({"lines[" + std::to_string(n) + "]", std::abs(off[next++]), {}});
    calibration.rms_px = std::sqrt(off.squaredNorm() / double(off.size()));
}

void judge(const PlateModel& model, double squares, PlateCalibration& calibration) {
    const std::optional<double> share = calibration.person_share_95;
    calibration.grade = share && *share <= good_share   ? PlateGrade::good
                        : share && *share <= fair_share ? PlateGrade::fair
                                                        : PlateGrade::poor;
    const PlateTask& task = model.task();
    const std::string where =
        task.points.empty() && task.heights.empty() ? "in the lower half of the photo" : "where it was clicked";
    const std::string on_ground =
        calibration.ground_m_95 ? short_number(*calibration.ground_m_95) + " m on the ground" : "";
    const std::string sizes =
        share ? "people are right within " + short_number(100.0 * *share) + " % of their height" +
                    (on_ground.empty() ? " " : " and " + on_ground + " ") + where + " (95 of 100)"
              : "nobody is seen whole " + where +
                    (on_ground.empty() ? "" : ", where " + on_ground + " are uncertain (95 of 100)");
    const int dof = calibration.degrees_of_freedom;
    const double seen_px = dof > 0 ? std::sqrt(squares / dof) : 0.0;
    const bool is_unlikely =
        calibration.is_click_stated && dof > 0 &&
        squares / (calibration.click_px * calibration.click_px) > quantile(boost::math::chi_squared(dof), believed);
    std::string doubt;
    if (is_unlikely || (!calibration.is_click_stated && seen_px > suspicious_px)) {
        const Outlier outlier = find_outlier(model, seen_px);
        if (outlier.point >= 0 && outlier.others_px * outlier_factor < seen_px) {
            doubt = "points[" + std::to_string(outlier.point) + "] is " + short_number(outlier.off_px) +
                    " px from where the others have it, which agree to " + short_number(outlier.others_px) + " px";
        } else if (is_unlikely) {
            doubt = "clicks are off by " + short_number(seen_px) + " px and not by the " +
                    short_number(calibration.click_px) + " that were stated";
        }
    }
    if (!doubt.empty()) calibration.grade = PlateGrade::poor;
    calibration.verdict = std::string(name_of(calibration.grade)) + ": " + (doubt.empty() ? "" : doubt + "; ") + sizes;
}

}  // namespace

Result<PlateCalibration> calibrate_plate(const PlateTask& task) {
    const PlateModel model(task);
    if (auto good = check_plate_task(model); !good) return std::unexpected(good.error());
    std::vector<PlateFit> fits = fit_plate(model);
    if (fits.empty())
        return error(ErrorKind::invalid_argument,
                     "points: no camera sees them there; look for swapped points, and for x and y (z is up)");
    prefer_ahead(task, fits);
    const PlateFit& best = fits[0];
    PlateCalibration calibration;
    calibration.size = task.size;
    calibration.degrees_of_freedom = model.degrees_of_freedom();
    const int dof = calibration.degrees_of_freedom;
    const double seen_px = dof > 0 ? std::sqrt(best.squares / dof) : 0.0;
    if (seen_px > wild_share * std::hypot(task.size.width, task.size.height))
        return std::unexpected(contradiction(model, best, seen_px));
    calibration.is_click_stated = task.click_px.has_value();
    calibration.click_px = task.click_px.value_or(seen_px);
    if (auto done = find_uncertainty(model, best.state, calibration); !done) return std::unexpected(done.error());
    if (auto good = check_only_one(model, fits, calibration.click_px); !good) return std::unexpected(good.error());
    const PlateView& view = best.state.view;
    calibration.intrinsics = view.k;
    calibration.lens = view.lens.lens();
    calibration.pose = pose_of(view);
    fill_residuals(model, best.state, calibration);
    judge(model, best.squares, calibration);
    return calibration;
}

}  // namespace camrig::photo
