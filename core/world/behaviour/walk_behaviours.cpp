#include "core/world/behaviour/walk_behaviours.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/portable_math.h"
#include "core/base/random.h"

namespace camrig::world {
namespace {

constexpr int max_goal_tries = 32;
constexpr double nearest_goal_m = 2.0;  ///< who wanders goes at least so far at a time
constexpr double look_turn_rad_s = 2.5;

/// Streams of one actor's random numbers are kept apart by the top byte of the counter.
constexpr std::uint64_t wander_draws = std::uint64_t{1} << 56;

glm::dvec2 on_floor(const glm::dvec3& v) {
    return {v.x, v.y};
}

double bearing(const glm::dvec2& from, const glm::dvec2& to) {
    return yaw_of(to - from);
}

}  // namespace

void Wander::choose_goal(const StepContext& context, const glm::dvec2& at) {
    const auto draw = [&] { return random_unit(context.seed, context.id, wander_draws + draws_++); };
    if (pause_s_ > 0.0 && has_goal_)
        pause_until_ns_ = context.now_ns + std::llround(-portable::log(1.0 - draw()) * pause_s_ * 1e9);
    for (int i = 0; i < max_goal_tries; ++i) {
        const double x = draw(), y = draw();
        const glm::dvec2 p = glm::mix(area_->low(), area_->high(), glm::dvec2(x, y));
        if (!area_->has_room(p)) continue;
        goal_ = p;
        has_goal_ = true;
        if (glm::distance(p, at) >= nearest_goal_m) return;
    }
}

void Wander::step(const StepContext& context, ActorState& state) {
    const glm::dvec2 at = on_floor(state.position);
    if (!has_goal_ || walker_.is_stuck() || (walker_.arrived() && context.now_ns >= pause_until_ns_)) {
        const bool was_there = has_goal_ && walker_.arrived() && !walker_.is_stuck();
        choose_goal(context, at);
        if (!was_there) pause_until_ns_ = 0;
        if (!has_goal_) return walker_.step_still(context, std::nullopt, state);
    }
    if (context.now_ns < pause_until_ns_) return walker_.step_still(context, std::nullopt, state);
    walker_.step_to(context, goal_, std::nullopt, state);
}

void Follow::step(const StepContext& context, ActorState& state) {
    const auto other = context.world ? context.world->actor_position(actor_) : std::nullopt;
    if (!other) return walker_.step_still(context, std::nullopt, state);
    const glm::dvec2 at = on_floor(state.position), to = on_floor(*other);
    const double distance = glm::distance(at, to);
    is_near_ = distance < distance_m_ * (is_near_ ? 1.25 : 1.0);
    if (is_near_) return walker_.step_still(context, bearing(at, to), state);
    walker_.step_to(context, to + (at - to) / distance * (distance_m_ * 0.95), std::nullopt, state);
}

void Grouped::step(const StepContext& context, ActorState& state) {
    const auto slot = context.world ? context.world->group_slot(group_.group, context.id) : WorldView::Slot{};
    const glm::dvec2 middle = on_floor(group_.position);
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(slot.index) / static_cast<double>(slot.count);
    const glm::dvec2 place = middle + group_.radius_m * glm::dvec2(portable::cos(angle), portable::sin(angle));
    walker_.step_to(context, place, bearing(on_floor(state.position), middle), state);
}

void LookAt::step(const StepContext& context, ActorState& state) {
    glm::dvec2 to = point_;
    if (!actor_.empty()) {
        const auto other = context.world ? context.world->actor_position(actor_) : std::nullopt;
        if (!other) return gait_.step(context, 0.0, state);
        to = on_floor(*other);
    }
    const double yaw = yaw_of(state.orientation);
    const double turn = angle_to(yaw, bearing(on_floor(state.position), to));
    const double most = look_turn_rad_s * context.step_s();
    faces_ = std::abs(turn) <= most;
    state.orientation = turned_to(yaw + std::clamp(turn, -most, most));
    gait_.step(context, 0.0, state);
}

}  // namespace camrig::world
