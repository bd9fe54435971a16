#include "core/world/behaviour/walker.h"

#include <algorithm>
#include <cmath>

#include "core/base/portable_math.h"
#include "core/base/random.h"

namespace camrig::world {
namespace {

// Of walking people; the sources are in docs/decisions/0050-crowds.md.
constexpr double turn_rad_s = 4.0;
constexpr double others_ahead_s = 2.0;   ///< how far ahead others are avoided
constexpr double others_spare_m = 0.10;  ///< in a jam, people give way to each other by this much and more
constexpr double walls_ahead_s = 0.5;    ///< walls do not come nearer by themselves
constexpr double part_within_s = 0.25;   ///< two that touch part so fast
constexpr double sight_m = 5.0;
constexpr std::size_t max_others = 12;
constexpr double storey_m = 1.5;  ///< bodies farther up or down are not in the way
constexpr double hurry = 1.3;     ///< to dodge somebody one may walk so much faster
constexpr double ease_s = 0.5;    ///< slows down over the last so much of the way

constexpr double corner_m = 0.35;  ///< so near to a corner, the next one is walked to
constexpr double at_goal_m = 0.05;
constexpr double near_goal_m = 0.8;  ///< somebody in the way may keep one so far off
constexpr TimeNs patience_ns = 3 * ns_per_s;
constexpr double progress_m = 0.2;

constexpr double start_walking_m_s = 0.2, stop_walking_m_s = 0.1;

glm::dvec2 flat(const glm::dvec3& v) {
    return {v.x, v.y};
}

/// Two that meet head on would stand for ever: everybody sways a little, anew every half second.
glm::dvec2 swayed(const StepContext& context, const glm::dvec2& wanted) {
    const auto half_seconds = static_cast<std::uint64_t>(context.world_ns / (ns_per_s / 2));
    const double angle = 0.3 * (random_unit(context.seed, context.id, half_seconds) - 0.5);
    const double c = portable::cos(angle), s = portable::sin(angle);
    return {wanted.x * c - wanted.y * s, wanted.x * s + wanted.y * c};
}

}  // namespace

void Gait::start(const StepContext& context, ActorState& state) {
    const std::uint64_t phase_ns = random_bits(context.seed, context.id, ~std::uint64_t{0}) % (20 * ns_per_s);
    idle_from_ns_ = context.now_ns - static_cast<TimeNs>(phase_ns);
    show(context, state, 0, 0);
}

void Gait::step(const StepContext& context, double moved_m, ActorState& state) {
    const double speed = moved_m / context.step_s();
    walks_ = speed > (walks_ ? stop_walking_m_s : start_walking_m_s);
    TimeNs walked_ns = 0;
    if (walks_ && options_.clip >= 0) {
        const double ground =
            options_.model->animations[static_cast<std::size_t>(options_.clip)].ground_speed_m_s * context.scale;
        walked_ns = ground > 0.0 ? std::llround(moved_m / ground * 1e9) : context.step_ns;
    }
    walk_ns_ += walked_ns;
    show(context, state, walked_ns, context.step_ns);
}

void Gait::show(const StepContext& context, ActorState& state, TimeNs walked_ns, TimeNs idled_ns) const {
    const TimeNs idle_ns = context.now_ns - idle_from_ns_;
    state.clips.clear();
    const bool walk = options_.clip >= 0 && (walks_ || options_.idle_clip < 0);
    if (walk)
        state.clips.push_back(clip_at(*options_.model, options_.clip, walk_ns_, walk_ns_ - walked_ns));
    else if (options_.idle_clip >= 0)
        state.clips.push_back(clip_at(*options_.model, options_.idle_clip, idle_ns, idle_ns - idled_ns));
}

void Walker::start(const StepContext& context, ActorState& state) {
    yaw_rad_ = yaw_of(state.orientation);
    velocity_ = glm::dvec2(0.0);
    gait_.start(context, state);
}

void Walker::step_to(const StepContext& context, const glm::dvec2& goal, std::optional<double> face_rad,
                     ActorState& state) {
    const glm::dvec2 at = flat(state.position);
    const glm::dvec2 wanted = way_velocity(context, at, goal);
    const bool is_there = glm::distance(at, goal) < at_goal_m;
    move(context, wanted, is_there ? face_rad : std::nullopt, state);
    watch_progress(context, glm::distance(flat(state.position), goal));
}

void Walker::step_still(const StepContext& context, std::optional<double> face_rad, ActorState& state) {
    goal_.reset();
    arrived_ = is_stuck_ = false;
    move(context, glm::dvec2(0.0), face_rad, state);
}

glm::dvec2 Walker::way_velocity(const StepContext& context, const glm::dvec2& at, const glm::dvec2& goal) {
    // A goal that moves is planned for anew when it has gone some way, and so is a way that leads nowhere.
    if (!goal_ || glm::distance(*goal_, goal) > 0.5 || is_stuck_) {
        way_ = options_.area ? options_.area->find_way(at, goal) : std::vector<glm::dvec2>{goal};
        std::ranges::reverse(way_);
        goal_ = goal;
        best_left_m_ = glm::distance(at, goal);
        best_at_ns_ = context.now_ns;
        arrived_ = false;
    }
    while (way_.size() > 1 && glm::distance(at, way_.back()) < corner_m) way_.pop_back();
    const bool last = way_.size() <= 1;
    const glm::dvec2 to = (last && (!options_.area || options_.area->contains(goal)) ? goal : way_.back()) - at;
    const double left = glm::length(to);
    if (left < 1e-6) return glm::dvec2(0.0);
    const double speed = last ? std::min(options_.speed_m_s, left / ease_s) : options_.speed_m_s;
    return to / left * speed;
}

void Walker::watch_progress(const StepContext& context, double left_m) {
    is_stuck_ = false;
    arrived_ = arrived_ || left_m < at_goal_m;
    if (left_m < best_left_m_ - progress_m || way_.size() > 1) {
        // On a way round something, distance says nothing; corners reached do.
        if (way_.size() > 1 && glm::length(velocity_) < stop_walking_m_s) {
            if (context.now_ns - best_at_ns_ > patience_ns) is_stuck_ = true;
            return;
        }
        best_left_m_ = left_m;
        best_at_ns_ = context.now_ns;
    } else if (!arrived_ && context.now_ns - best_at_ns_ > patience_ns) {
        if (left_m < near_goal_m)
            arrived_ = true;
        else
            is_stuck_ = true;
    }
}

void Walker::move(const StepContext& context, const glm::dvec2& wanted, std::optional<double> face_rad,
                  ActorState& state) {
    const glm::dvec2 at = flat(state.position);
    // Turning comes before walking: who looks the other way starts slowly.
    const double wish = glm::length(wanted);
    double ahead = 1.0;
    if (wish > stop_walking_m_s) ahead = std::clamp(portable::cos(angle_to(yaw_rad_, yaw_of(wanted))), 0.15, 1.0);
    planes_.clear();
    if (options_.area) {
        options_.area->walls_near(at, context.radius_m + options_.speed_m_s * hurry * walls_ahead_s, walls_);
        for (const glm::dvec2& wall : walls_) planes_.push_back(keep_off(wall, context.radius_m, walls_ahead_s));
    }
    const std::size_t hard = planes_.size();
    if (context.world) {
        const Crowd& crowd = context.world->crowd();
        crowd.near(at, sight_m + crowd.longest(), others_);
        const auto distance2 = [&](const Body* body) {
            const glm::dvec2 to = body->nearest(at) - at;
            return glm::dot(to, to);
        };
        std::erase_if(others_, [&](const Body* body) {
            return body->id == context.id || std::abs(body->z - state.position.z) > storey_m ||
                   distance2(body) > sight_m * sight_m;
        });
        const auto nearer = [&](const Body* a, const Body* b) {
            const double da = distance2(a), db = distance2(b);
            return da != db ? da < db : a->id < b->id;
        };
        const std::size_t count = std::min(others_.size(), max_others);
        std::partial_sort(others_.begin(), others_.begin() + static_cast<std::ptrdiff_t>(count), others_.end(), nearer);
        for (std::size_t i = 0; i < count; ++i) {
            const Body& body = *others_[i];
            planes_.push_back(avoid({.position = body.nearest(at) - at,
                                     .velocity = body.velocity,
                                     .radius = context.radius_m + body.radius + others_spare_m,
                                     .share = body.gives_way ? 0.5 : 1.0},
                                    velocity_, others_ahead_s, part_within_s));
        }
    }
    const glm::dvec2 chosen =
        choose_velocity(planes_, hard, swayed(context, wanted * ahead), options_.speed_m_s * hurry);
    velocity_ = chosen;
    const double speed = glm::length(velocity_);

    const double step_s = context.step_s();
    state.position += glm::dvec3(velocity_ * step_s, 0.0);
    if (options_.area) state.position.z = options_.area->z();
    std::optional<double> to_face = face_rad;
    if (wish > stop_walking_m_s && ahead < 0.5) {
        to_face = yaw_of(wanted);
    } else if (speed > start_walking_m_s) {
        to_face = yaw_of(velocity_);
    }
    if (to_face) {
        const double turn = angle_to(yaw_rad_, *to_face);
        yaw_rad_ += std::clamp(turn, -turn_rad_s * step_s, turn_rad_s * step_s);
        state.orientation = turned_to(yaw_rad_);
    }
    gait_.step(context, speed * step_s, state);
}

}  // namespace camrig::world
