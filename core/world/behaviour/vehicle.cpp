#include "core/world/behaviour/vehicle.h"

#include <algorithm>
#include <cmath>

#include "core/base/portable_math.h"
#include "core/world/turn.h"

namespace camrig::world {
namespace {

constexpr double sample_m = 0.5;
constexpr double max_ahead_m = 150.0;
constexpr double side_margin_m = 0.3;
constexpr double storey_height_m = 2.5;
/// Harder than this nothing brakes: tyres on a dry road.
constexpr double emergency_m_s2 = 9.0;
/// Joining a route takes this way at least, and this many times the distance to it.
constexpr double least_join_m = 8.0;
constexpr double join_slope = 4.0;
constexpr double max_join_samples = 20000.0;

}  // namespace

double Vehicle::wrapped(double at_m) const {
    const double length = options_.path->length_m();
    return options_.closed ? at_m - length * std::floor(at_m / length) : std::clamp(at_m, 0.0, length);
}

void Vehicle::start(const StepContext& context, ActorState& state) {
    at_m_ = wrapped(options_.spec.start_m);
    speed_m_s_ = options_.spec.speed_m_s;
    if (options_.joins) join(context, state);
    place(context, 0.0, state);
}

void Vehicle::join(const StepContext& context, const ActorState& state) {
    const double length = options_.path->length_m();
    const auto distance_at = [&](double at_m) {
        return glm::distance(options_.path->at(at_m).position, state.position);
    };
    const double piece = std::max(sample_m, length / max_join_samples);
    double best = 0.0;
    for (double at = 0.0; at <= length; at += piece)
        if (distance_at(at) < distance_at(best)) best = at;
    for (double half = piece / 2.0; half > 1e-6; half /= 2.0)
        for (const double at : {std::max(0.0, best - half), std::min(length, best + half)})
            if (distance_at(at) < distance_at(best)) best = at;
    at_m_ = best;
    const RoutePath::Point point = options_.path->at(at_m_);
    off_route_ = state.position - point.position;
    off_heading_rad_ = angle_to(point.heading_rad, yaw_of(state.orientation));
    joining_m_ = join_over_m_ = std::max(least_join_m, join_slope * glm::length(off_route_));
    speed_m_s_ = 0.0;
    if (!context.world) return;
    for (const Body& body : context.world->crowd().bodies())
        if (body.id == context.id) speed_m_s_ = std::min(options_.spec.speed_m_s, glm::length(body.velocity));
}

std::optional<Vehicle::Leader> Vehicle::find_leader(const StepContext& context, double ahead_m) {
    const VehicleBehaviour& spec = options_.spec;
    const Crowd& crowd = context.world->crowd();
    const RoutePath::Point here = options_.path->at(at_m_);
    crowd.near({here.position.x, here.position.y}, ahead_m + spec.length_m + crowd.longest(), others_);
    std::erase_if(others_, [&](const Body* body) {
        return body->id == context.id || std::abs(body->z - here.position.z) > storey_height_m;
    });
    const double front_m = spec.length_m / 2.0;
    for (double gap = 0.0; gap <= ahead_m && !others_.empty(); gap += sample_m) {
        const double sample = at_m_ + front_m + gap;
        if (!options_.closed && sample > options_.path->length_m()) break;
        const RoutePath::Point point = options_.path->at(wrapped(sample));
        const glm::dvec2 at(point.position.x, point.position.y);
        const glm::dvec2 along(portable::cos(point.heading_rad), portable::sin(point.heading_rad));
        std::optional<Leader> nearest;
        for (const Body* body : others_) {
            const glm::dvec2 to = body->nearest(at) - at;
            if (glm::length(to) >= body->radius + spec.width_m / 2.0 + side_margin_m) continue;
            // What is behind the front bumper has been passed.
            if (gap == 0.0 && glm::dot(body->position - at, along) < 0.0) continue;
            const double free = std::max(0.0, gap + glm::dot(to, along) - body->radius);
            if (!nearest || free < nearest->gap_m) nearest = Leader{free, glm::dot(body->velocity, along)};
        }
        if (nearest) return nearest;
    }
    return std::nullopt;
}

void Vehicle::step(const StepContext& context, ActorState& state) {
    const VehicleBehaviour& spec = options_.spec;
    const double ahead = std::min(max_ahead_m, spec.gap_m + speed_m_s_ * spec.headway_s + 10.0 +
                                                   speed_m_s_ * speed_m_s_ / (2.0 * spec.braking_m_s2));
    std::optional<Leader> leader = context.world ? find_leader(context, ahead) : std::nullopt;
    const double end_gap = options_.path->length_m() - at_m_;
    if (!options_.closed && end_gap < ahead && (!leader || end_gap + spec.gap_m < leader->gap_m))
        leader = Leader{end_gap + spec.gap_m, 0.0};  // it stops with its middle at the end

    const double speed_square = speed_m_s_ / spec.speed_m_s * (speed_m_s_ / spec.speed_m_s);
    double drive = 1.0 - speed_square * speed_square;
    if (leader) {
        const double closing = speed_m_s_ - std::max(0.0, leader->speed_m_s);
        const double keep =
            spec.gap_m +
            std::max(0.0, speed_m_s_ * spec.headway_s +
                              speed_m_s_ * closing / (2.0 * std::sqrt(spec.acceleration_m_s2 * spec.braking_m_s2)));
        const double ratio = keep / std::max(leader->gap_m, 0.01);
        drive -= ratio * ratio;
    }
    const double acceleration = std::max(-emergency_m_s2, spec.acceleration_m_s2 * drive);
    const double next = std::max(0.0, speed_m_s_ + acceleration * context.step_s());
    double moved = (speed_m_s_ + next) / 2.0 * context.step_s();
    speed_m_s_ = next;
    if (!options_.closed) moved = std::min(moved, end_gap);
    at_m_ = wrapped(at_m_ + moved);
    joining_m_ = std::max(0.0, joining_m_ - moved);
    arrived_ = !options_.closed && options_.path->length_m() - at_m_ < 0.3 && speed_m_s_ < 0.05;
    place(context, moved, state);
}

void Vehicle::place(const StepContext& context, double moved_m, ActorState& state) {
    const RoutePath::Point point = options_.path->at(at_m_);
    // Smoothly from where it was: 1 at the beginning, 0 on the route, level at both.
    const double left = joining_m_ / join_over_m_;
    const double share = left * left * (3.0 - 2.0 * left);
    state.position = point.position + share * off_route_;
    state.orientation = turned_to(point.heading_rad + share * off_heading_rad_);
    state.clips.clear();
    if (options_.animation < 0) return;
    const double ground =
        options_.model->animations[static_cast<std::size_t>(options_.animation)].ground_speed_m_s * context.scale;
    const TimeNs advance = ground > 0.0 ? std::llround(moved_m / ground * 1e9) : context.step_ns;
    clip_ns_ += advance;
    state.clips.push_back(clip_at(*options_.model, options_.animation, clip_ns_, clip_ns_ - advance));
}

}  // namespace camrig::world
