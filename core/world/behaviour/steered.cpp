#include "core/world/behaviour/steered.h"

#include <algorithm>
#include <cmath>

namespace camrig::world {
namespace {

constexpr double steered_turn_rad_s = 6.0;

}  // namespace

void Steered::steer(const SteerSpec& spec, const StepContext& context, ActorState& state) {
    velocity_ = spec.velocity.value_or(glm::dvec3(0.0));
    to_ = spec.position;
    left_ns_ = spec.over_ns;
    yaw_rad_ = spec.yaw_rad;
    if (to_ && spec.over_ns == 0) {
        state.position = *to_;
        to_.reset();
        if (yaw_rad_) state.orientation = turned_to(*yaw_rad_);
    }
    if (spec.clip) {
        const int clip = spec.clip->empty() ? -1 : model_->find_animation(*spec.clip);
        gait_ = Gait({.model = model_, .clip = clip, .idle_clip = -1});
        gait_.start(context, state);
    }
}

void Steered::step(const StepContext& context, ActorState& state) {
    glm::dvec3 moved = velocity_ * context.step_s();
    double share = 1.0;  // of the way and the turn that are left
    if (to_) {
        share = left_ns_ > context.step_ns ? static_cast<double>(context.step_ns) / static_cast<double>(left_ns_) : 1.0;
        left_ns_ -= context.step_ns;
        moved = (*to_ - state.position) * share;
        if (share == 1.0) to_.reset();
    }
    state.position += moved;
    const double ground_m = glm::length(glm::dvec2(moved));
    const double yaw = yaw_of(state.orientation);
    if (yaw_rad_ && share < 1.0) {
        state.orientation = turned_to(yaw + angle_to(yaw, *yaw_rad_) * share);
    } else if (yaw_rad_) {
        state.orientation = turned_to(*yaw_rad_);
    } else if (ground_m > 0.1 * context.step_s()) {
        const double most = steered_turn_rad_s * context.step_s();
        const double turn = angle_to(yaw, yaw_of(glm::dvec2(moved)));
        state.orientation = turned_to(yaw + std::clamp(turn, -most, most));
    }
    gait_.step(context, ground_m, state);
}

}  // namespace camrig::world
