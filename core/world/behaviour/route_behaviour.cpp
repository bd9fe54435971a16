#include "core/world/behaviour/route_behaviour.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/world/turn.h"

namespace camrig::world {
namespace {

/// An actor that turns round at the end of a route does so over this much of it on either side.
constexpr double turn_round_m = 0.3;

std::int64_t to_nm(double metres) {
    return std::llround(metres * 1e9);
}

/// How far an actor in mode ping_pong has turned round, given the distance walked of there-and-back (2 * length).
double turned_rad(double m, double length_m) {
    const double w = std::min(turn_round_m, length_m / 4.0);
    // x: signed distance past an end of the route
    const auto part = [w](double x) { return std::numbers::pi * (x + w) / (2.0 * w); };
    if (m < w) return std::numbers::pi + part(m);
    if (m > 2.0 * length_m - w) return std::numbers::pi + part(m - 2.0 * length_m);
    if (std::abs(m - length_m) < w) return part(m - length_m);
    return m < length_m ? 0.0 : std::numbers::pi;
}

}  // namespace

RouteWalk::RouteWalk(Options options)
    : options_(std::move(options)),
      length_nm_(std::max<std::int64_t>(1, to_nm(options_.path->length_m()))),
      speed_nm_s_(to_nm(options_.speed_m_s)),
      start_nm_(to_nm(options_.start_m)) {
    if (options_.animation < 0) return;
    const auto& animation = options_.model->animations[static_cast<std::size_t>(options_.animation)];
    ground_speed_m_s_ = animation.ground_speed_m_s;
}

WideInt RouteWalk::distance_nm(TimeNs now_ns) const {
    const WideInt walked = start_nm_ + static_cast<WideInt>(now_ns - origin_ns_) * speed_nm_s_ / ns_per_s;
    if (options_.mode != RouteBehaviour::Mode::once) return walked;
    return std::min<WideInt>(walked, std::max(length_nm_, start_nm_));
}

WideInt RouteWalk::clip_ns(TimeNs now_ns, double scale) const {
    const std::int64_t ground_nm_s = to_nm(ground_speed_m_s_ * scale);
    return ground_nm_s > 0 ? distance_nm(now_ns) * ns_per_s / ground_nm_s : WideInt{now_ns};
}

void RouteWalk::start(const StepContext& context, ActorState& state) {
    origin_ns_ = context.now_ns;
    step(context, state);
}

RoutePath::Point RouteWalk::at(WideInt walked) const {
    std::int64_t at_nm = 0;
    double turned = 0.0;
    switch (options_.mode) {
        case RouteBehaviour::Mode::loop:
            at_nm = static_cast<std::int64_t>(walked % length_nm_);
            break;
        case RouteBehaviour::Mode::once:
            at_nm = static_cast<std::int64_t>(std::min<WideInt>(walked, length_nm_));
            break;
        case RouteBehaviour::Mode::ping_pong: {
            const auto there_and_back = static_cast<std::int64_t>(walked % (2 * length_nm_));
            at_nm = there_and_back < length_nm_ ? there_and_back : 2 * length_nm_ - there_and_back;
            turned = turned_rad(static_cast<double>(there_and_back) * 1e-9, static_cast<double>(length_nm_) * 1e-9);
            break;
        }
    }
    RoutePath::Point point = options_.path->at(static_cast<double>(at_nm) * 1e-9);
    point.heading_rad += turned;
    return point;
}

void RouteWalk::step(const StepContext& context, ActorState& state) {
    const WideInt walked = distance_nm(context.now_ns);
    arrived_ = options_.mode == RouteBehaviour::Mode::once && walked >= length_nm_;
    const RoutePath::Point point = at(walked);
    state.position = point.position;
    state.orientation = turned_to(point.heading_rad);
    state.clips.clear();
    if (options_.animation >= 0) {
        state.clips.push_back(clip_at(*options_.model, options_.animation, clip_ns(context.now_ns, context.scale),
                                      clip_ns(context.now_ns - context.step_ns, context.scale)));
    }
}

}  // namespace camrig::world
