#include "core/fault/body.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/portable_math.h"

namespace camrig::fault {
namespace {

/// Angles about the camera's own axes.
struct Turn {
    double pan_deg = 0.0, tilt_deg = 0.0, roll_deg = 0.0;
};

glm::dquat about(glm::dvec3 axis, double degrees) {
    const double half = degrees * std::numbers::pi / 360.0;
    return {portable::cos(half), portable::sin(half) * axis};
}

struct TurnOf {
    const Fault& fault;
    TimeNs world_ns;
    double seconds() const { return static_cast<double>(world_ns - fault.begin_ns) * 1e-9; }

    Turn operator()(const Knock& knock) const {
        const double s = fault.severity;
        return {s * knock.pan_deg, s * knock.tilt_deg, s * knock.roll_deg};
    }
    Turn operator()(const Sag& sag) const {
        return {0.0, std::clamp(fault.severity * sag.tilt_deg_per_h * seconds() / 3600.0, -90.0, 90.0), 0.0};
    }
    Turn operator()(const Vibration& vibration) const {
        const double turns = vibration.frequency_hz * seconds();
        const double angle = 2.0 * std::numbers::pi * (turns - std::floor(turns));
        const double amplitude = fault.severity * vibration.amplitude_deg;
        return {amplitude * portable::sin(angle), amplitude * portable::cos(angle), 0.0};
    }
    Turn operator()(const auto&) const { return {}; }
};

}  // namespace

bool moves_body(const FrameFaults& faults) {
    return std::ranges::any_of(faults.active, [](const FaultRef& one) { return layer_of(one->kind) == Layer::body; });
}

camera::Pose moved(const FrameFaults& faults, const camera::Pose& believed) {
    camera::Pose pose = believed;
    for (const FaultRef& one : faults.active) {
        const Turn turn = std::visit(TurnOf{*one, faults.frame.world_ns}, one->kind);
        // x is ahead, y to the left, z up: up is about -y, clockwise from behind about x.
        pose.orientation = glm::normalize(pose.orientation * about({0, 0, 1}, turn.pan_deg) *
                                          about({0, -1, 0}, turn.tilt_deg) * about({1, 0, 0}, turn.roll_deg));
    }
    return pose;
}

}  // namespace camrig::fault
