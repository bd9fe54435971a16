#include "core/photo/plate_uncertainty.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

#include <Eigen/Dense>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>

namespace camrig::photo {
namespace {

using boost::math::quantile;

constexpr double coverage = 0.95;
constexpr double person_m = 1.75;
/// No click is better than this, whatever the residuals say: what a tenth of a pixel leaves open is not determined.
constexpr double best_click_px = 0.1;
constexpr double singular_share = 1e-11;
constexpr double loose_share = 0.5;  ///< of the focal length, of the way to what was clicked at

double two_sided(const PlateCalibration& of) {
    const double p = 0.5 * (1.0 + coverage);
    return of.is_click_stated ? quantile(boost::math::normal(), p)
                              : quantile(boost::math::students_t(of.degrees_of_freedom), p);
}

double region(const PlateCalibration& of, int count) {
    return of.is_click_stated ? quantile(boost::math::chi_squared(count), coverage)
                              : count * quantile(boost::math::fisher_f(count, of.degrees_of_freedom), coverage);
}

Error undetermined(PlateUnknown what) {
    const char* text = "points: do not determine where the camera is; spread them further over the photo";
    if (what == PlateUnknown::focal)
        text =
            "points: do not determine the focal length (a plane seen straight on shows no perspective, and points "
            "close "
            "together hardly any); give vfov_deg or intrinsics, or points of other heights and depths";
    if (what == PlateUnknown::k1)
        text = "fit_k1: the points do not determine k1; give some near the corners of the photo, or leave it out";
    if (what <= PlateUnknown::turn_z)
        text = "points: do not determine how the camera is turned; spread them further over the photo";
    return {ErrorKind::invalid_argument, text};
}

/// A direction in which no click says anything.
std::optional<PlateUnknown> loose_direction(const PlateModel& model, const Eigen::MatrixXd& j) {
    const Eigen::VectorXd scale = j.colwise().norm().cwiseMax(1e-300);
    const Eigen::MatrixXd scaled = j * scale.cwiseInverse().asDiagonal();
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(scaled, Eigen::ComputeThinV);
    const auto& values = svd.singularValues();
    const Eigen::Index last = values.size() - 1;
    if (values[last] > std::sqrt(singular_share) * values[0]) return std::nullopt;
    const Eigen::VectorXd along = svd.matrixV().col(last).cwiseAbs();
    const auto unknowns = model.unknowns();
    for (const PlateUnknown first : {PlateUnknown::focal, PlateUnknown::k1})
        for (std::size_t n = 0; n < unknowns.size(); ++n)
            if (unknowns[n] == first && along[Eigen::Index(n)] > 0.2) return first;
    Eigen::Index most = 0;
    along.head(Eigen::Index(unknowns.size())).maxCoeff(&most);
    return unknowns[std::size_t(most)];
}

/// Standard deviation of what is computed from a state, by the covariance of the camera's unknowns. NaN: not defined
/// there.
using OfState = std::function<double(const PlateState&)>;
double deviation(const PlateModel& model, const PlateState& state, const Eigen::MatrixXd& covariance,
                 const OfState& value) {
    const Eigen::Index count = covariance.rows();
    Eigen::VectorXd slope(count);
    for (Eigen::Index n = 0; n < count; ++n) {
        const double by = std::clamp(0.01 * std::sqrt(covariance(n, n)), 1e-9, 1e-3);
        Eigen::VectorXd step = Eigen::VectorXd::Zero(model.step_size());
        step[n] = by;
        const double up = value(model.moved(state, step));
        step[n] = -by;
        slope[n] = (up - value(model.moved(state, step))) / (2.0 * by);
    }
    return std::sqrt(std::max(0.0, slope.dot(covariance * slope)));
}

std::vector<glm::dvec3> places_on_ground(const PlateTask& task, const PlateState& state) {
    double lowest = 0.0;
    if (!task.points.empty()) lowest = std::ranges::min(task.points, {}, [](const KnownPoint& p) { return p.m.z; }).m.z;
    std::vector<glm::dvec3> places;
    for (const KnownPoint& each : task.points) places.emplace_back(each.m.x, each.m.y, lowest);
    for (std::size_t n = 0; n < task.heights.size(); ++n) places.emplace_back(state.feet[n], task.heights[n].z);
    return places;
}

/// Where it is asked how right people are: the places clicked at, else the ground in the lower half of the photo.
std::vector<glm::dvec3> judged_places(const PlateTask& task, const PlateState& state) {
    std::vector<glm::dvec3> places = places_on_ground(task, state);
    if (!places.empty()) return places;
    for (const double down : {0.5, 0.75, 1.0})
        for (const double across : {0.0, 0.5, 1.0}) {
            const glm::dvec2 px(across * (task.size.width - 1), down * (task.size.height - 1));
            if (const auto at = state.view.on_ground(px, 0.0)) places.push_back(*at);
        }
    return places;
}

void judge_people(const PlateModel& model, const PlateState& state, const Eigen::MatrixXd& covariance, double widen,
                  PlateCalibration& calibration) {
    const auto worst = [](std::optional<double>& of, double value) {
        if (std::isfinite(value)) of = std::max(of.value_or(0.0), value);
    };
    for (const glm::dvec3& place : judged_places(model.task(), state)) {
        const auto foot = state.view.project(place);
        if (!foot) continue;
        const auto height = [place](const PlateState& of) {
            const auto low = of.view.project(place), high = of.view.project(place + glm::dvec3(0, 0, person_m));
            return low && high ? glm::distance(*low, *high) : std::nan("");
        };
        const double px = height(state);
        if (px > 0.0) worst(calibration.person_share_95, widen * deviation(model, state, covariance, height) / px);
        double squares = 0.0;
        for (int axis = 0; axis < 2; ++axis) {
            const double off = deviation(model, state, covariance, [foot, place, axis](const PlateState& of) {
                const auto at = of.view.on_ground(*foot, place.z);
                return at ? (*at)[axis] : std::nan("");
            });
            squares += off * off;
        }
        worst(calibration.ground_m_95, widen * std::sqrt(squares));
    }
}

void fill_halves(const PlateModel& model, const PlateState& state, const Eigen::MatrixXd& covariance, double widen,
                 PlateCalibration& calibration) {
    const auto unknowns = model.unknowns();
    auto& halves = calibration.half_95;
    for (std::size_t n = 0; n < unknowns.size(); ++n) {
        const double half = widen * std::sqrt(covariance(Eigen::Index(n), Eigen::Index(n)));
        const PlateUnknown unknown = unknowns[n];
        if (unknown == PlateUnknown::focal) halves.focal_px = half * state.view.k.fx;
        if (unknown == PlateUnknown::k1) halves.k1 = half;
        if (unknown >= PlateUnknown::x && unknown <= PlateUnknown::z)
            halves.position_m[int(unknown) - int(PlateUnknown::x)] = half;
    }
    const camera::PanTiltRoll is = camera::angles_of(pose_of(state.view).orientation);
    const auto angle = [&](double camera::PanTiltRoll::* which) {
        return widen * deviation(model, state, covariance, [&](const PlateState& of) {
                   return std::remainder(camera::angles_of(pose_of(of.view).orientation).*which - is.*which,
                                         2.0 * std::numbers::pi);
               });
    };
    halves.angles = {angle(&camera::PanTiltRoll::pan), angle(&camera::PanTiltRoll::tilt),
                     angle(&camera::PanTiltRoll::roll)};
    if (!model.seeks(PlateUnknown::turn_z)) halves.angles.pan = 0.0;
}

/// What is too loose to be called found.
std::optional<PlateUnknown> too_loose(const PlateModel& model, const PlateState& state,
                                      const Eigen::MatrixXd& of_one_px, double px) {
    double way = 1.0;
    for (const glm::dvec3& place : places_on_ground(model.task(), state))
        way = std::max(way, glm::distance(place, state.view.position));
    const auto unknowns = model.unknowns();
    std::optional<PlateUnknown> found;
    for (std::size_t n = 0; n < unknowns.size(); ++n) {
        const double deviation = px * std::sqrt(of_one_px(Eigen::Index(n), Eigen::Index(n)));
        const bool is_place = unknowns[n] >= PlateUnknown::x && unknowns[n] <= PlateUnknown::z;
        const double most = unknowns[n] == PlateUnknown::k1 ? 1.0 : loose_share * (is_place ? way : 1.0);
        if (deviation > most) found = unknowns[n];
    }
    return found;
}

}  // namespace

Result<void> find_uncertainty(const PlateModel& model, const PlateState& state, PlateCalibration& calibration) {
    const Eigen::MatrixXd j = model.jacobian(state);
    if (const auto loose = loose_direction(model, j)) return std::unexpected(undetermined(*loose));
    const auto count = Eigen::Index(model.unknowns().size());
    const Eigen::MatrixXd normal = j.transpose() * j;
    const Eigen::MatrixXd of_one_px =
        normal.ldlt().solve(Eigen::MatrixXd::Identity(normal.rows(), normal.cols())).topLeftCorner(count, count);
    if (const auto loose = too_loose(model, state, of_one_px, std::max(best_click_px, calibration.click_px)))
        return std::unexpected(undetermined(*loose));
    const Eigen::MatrixXd covariance = calibration.click_px * calibration.click_px * of_one_px;
    calibration.unknowns.assign(model.unknowns().begin(), model.unknowns().end());
    calibration.covariance.assign(covariance.data(), covariance.data() + covariance.size());
    calibration.region_95 = region(calibration, int(count));
    const double widen = two_sided(calibration);
    fill_halves(model, state, covariance, widen, calibration);
    judge_people(model, state, covariance, widen, calibration);
    return {};
}

}  // namespace camrig::photo
