#include "core/photo/plate_checks.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <Eigen/Dense>

namespace camrig::photo {
namespace {

constexpr double max_metres = 1e7;
constexpr double max_pixel = 1e6;
/// Points are left out in turn, each with a search of its own, where points times clicked numbers are no more than
/// this: 24 points alone.
constexpr std::size_t most_left_out_work = 24 * 48;
/// Below this share of their spread, points are on a line.
constexpr double flat_share = 1e-4;

bool is_pixel(glm::dvec2 px) {
    return std::abs(px.x) <= max_pixel && std::abs(px.y) <= max_pixel;
}

std::string place(const char* list, std::size_t n, const char* key) {
    return std::string(list) + "[" + std::to_string(n) + "]" + (*key ? "." : "") + key;
}

Result<void> check_numbers(const PlateTask& task) {
    if (task.size.width < 16 || task.size.height < 16) return invalid("size: must be at least 16x16");
    for (std::size_t n = 0; n < task.points.size(); ++n) {
        if (!is_pixel(task.points[n].px)) return invalid(place("points", n, "px") + ": must be within 1e6 pixels");
        for (int i = 0; i < 3; ++i)
            if (!(std::abs(task.points[n].m[i]) <= max_metres))
                return invalid(place("points", n, "m") + ": must be within 1e7 m");
        for (std::size_t before = 0; before < n; ++before)
            if (glm::distance(task.points[n].px, task.points[before].px) < 1e-6 &&
                glm::distance(task.points[n].m, task.points[before].m) < 1e-9)
                return invalid(place("points", n, "") + ": is the same as points[" + std::to_string(before) + "]");
    }
    for (std::size_t n = 0; n < task.heights.size(); ++n) {
        const KnownHeight& each = task.heights[n];
        if (!is_pixel(each.foot_px) || !is_pixel(each.head_px) || glm::distance(each.foot_px, each.head_px) < 1.0)
            return invalid(place("heights", n, "") + ": foot and head must be a pixel apart or more");
        if (!(each.height_m > 0.0 && each.height_m < 1e4))
            return invalid(place("heights", n, "height_m") + ": must be over 0");
        if (!(std::abs(each.z) <= max_metres)) return invalid(place("heights", n, "z") + ": must be within 1e7 m");
    }
    for (std::size_t n = 0; n < task.lines.size(); ++n)
        if (!is_pixel(task.lines[n].from_px) || !is_pixel(task.lines[n].to_px) ||
            glm::distance(task.lines[n].from_px, task.lines[n].to_px) < 1.0)
            return invalid(place("lines", n, "px") + ": its ends must be a pixel apart or more");
    if (task.click_px && !(*task.click_px > 0.0 && *task.click_px < 1e3))
        return invalid("click_px: must be over 0 and below 1000");
    if (task.camera_height_m && !(std::abs(*task.camera_height_m) <= max_metres))
        return invalid("camera_height_m: must be within 1e7 m");
    return {};
}

/// How many dimensions the points fill: 0 in one place, 1 on a line, 2 on a plane.
int dimensions_of(const std::vector<KnownPoint>& points) {
    Eigen::MatrixXd all(3, Eigen::Index(points.size()));
    for (std::size_t n = 0; n < points.size(); ++n)
        all.col(Eigen::Index(n)) << points[n].m.x, points[n].m.y, points[n].m.z;
    all.colwise() -= all.rowwise().mean().eval();
    const Eigen::VectorXd values = Eigen::JacobiSVD<Eigen::MatrixXd>(all).singularValues();
    Eigen::Vector3d spread = Eigen::Vector3d::Zero();  // two points have two
    spread.head(values.size()) = values;
    if (spread[0] < 1e-6) return 0;
    return 1 + (spread[1] > flat_share * spread[0]) + (spread[2] > flat_share * spread[0]);
}

double pixel_spread(const std::vector<KnownPoint>& points) {
    double most = 0.0;
    for (const KnownPoint& each : points) most = std::max(most, glm::distance(each.px, points[0].px));
    return most;
}

/// The task without a point.
PlateTask without(const PlateTask& task, std::size_t point) {
    PlateTask rest = task;
    rest.points.erase(rest.points.begin() + std::ptrdiff_t(point));
    return rest;
}

}  // namespace

Result<void> check_plate_task(const PlateModel& model) {
    const PlateTask& task = model.task();
    if (auto good = check_numbers(task); !good) return good;
    if (auto lens = camera::LensMap::create(task.lens); !lens) return at("lens", lens.error());
    if (task.fit_k1 && (task.lens.model != camera::LensModel::pinhole || task.intrinsics))
        return invalid("fit_k1: the lens is given; leave out lens and intrinsics, or fit_k1");
    if (task.points.empty() && task.heights.empty() && task.lines.empty())
        return invalid("points: none are given; give at least 4 (pixel and metres), or known heights and lines");
    if (task.points.empty() && task.heights.empty() && !task.camera_height_m)
        return invalid("lines: tell nothing of sizes; give points, a known height or camera_height_m too");
    if (task.points.size() >= 2 && task.heights.empty() && task.lines.empty()) {
        const int dimensions = dimensions_of(task.points);
        if (dimensions == 0) return invalid("points: all are the same place; spread them over the ground");
        if (dimensions == 1)
            return invalid("points: all are on one line; give at least one beside it, the further the better");
    }
    if (task.points.size() >= 2 && pixel_spread(task.points) < 2.0)
        return invalid("points: all are the same pixel; spread them over the photo");
    if (model.degrees_of_freedom() < (task.click_px ? 0 : 1))
        return invalid(
            "points: " + std::to_string(model.residual_count()) + " numbers were clicked and " +
            std::to_string(model.step_size()) + " are sought; give " +
            (task.intrinsics ? "at least 4 points" : "at least 4 points (5 with fit_k1), or the focal length"));
    return {};
}

Outlier find_outlier(const PlateModel& model, double click_px) {
    const PlateTask& task = model.task();
    Outlier found;
    if (task.points.size() < 2 || task.points.size() * std::size_t(model.residual_count()) > most_left_out_work)
        return found;
    double best = click_px / 4.0;
    for (std::size_t n = 0; n < task.points.size(); ++n) {
        const PlateTask rest = without(task, n);
        const PlateModel others(rest);
        if (others.degrees_of_freedom() < 1 || !check_plate_task(others)) continue;
        const auto fits = fit_plate(others);
        if (fits.empty()) continue;
        const double click = std::sqrt(fits[0].squares / others.degrees_of_freedom());
        if (!(click < best)) continue;
        best = click;
        const PlateView& view = fits[0].state.view;
        const auto at = view.project(task.points[n].m);
        found = {.point = int(n),
                 .off_px = at ? glm::distance(*at, task.points[n].px) : PlateModel::lost_px,
                 .others_px = click,
                 .over_horizon =
                     view.position.z > task.points[n].m.z && !view.on_ground(task.points[n].px, task.points[n].m.z)};
    }
    return found;
}

Error contradiction(const PlateModel& model, const PlateFit& best, double click_px) {
    const Outlier outlier = find_outlier(model, click_px);
    if (outlier.point >= 0) {
        const std::string at = place("points", std::size_t(outlier.point), "");
        const std::string others = "the others agree to " + short_number(outlier.others_px) + " px";
        if (outlier.over_horizon)
            return {ErrorKind::invalid_argument,
                    at + ".px: is over the horizon of the ground that the other points are on; " + others};
        const std::string far =
            outlier.off_px < 1e4 ? short_number(outlier.off_px) + " px from" : "behind the camera, not";
        return {ErrorKind::invalid_argument, at + ": is " + far + " where the other points have it; " + others};
    }
    const Eigen::VectorXd off = model.residuals(best.state);
    std::string worst;
    double most = -1.0;
    for (std::size_t n = 0; n < model.task().points.size(); ++n) {
        const double px = off.segment<2>(Eigen::Index(2 * n)).norm();
        if (px > most) most = px, worst = "; points[" + std::to_string(n) + "] is the worst";
    }
    return {ErrorKind::invalid_argument, "points: contradict each other: no camera has them nearer than " +
                                             short_number(click_px) + " px" + worst +
                                             "; look for two that are swapped, and for x and y (z is up)"};
}

}  // namespace camrig::photo
