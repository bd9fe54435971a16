#include "core/camera/ptz_axis.h"

#include <algorithm>
#include <cmath>

#include "core/base/random.h"

namespace camrig::camera {
namespace {

/// As Timeline keeps it, so that pictures, truth and status of the recent past can be asked for.
constexpr TimeNs kept_ns = 250 * ns_per_ms;
/// A finer quantum is none: numbers as large as angles are have no room for it.
constexpr double least_quantum_deg = 1e-6;
/// An axis is as far off as where it is to stop after so long, or when it is there.
constexpr double error_ramp_s = 1.0;

double seconds_between(TimeNs from_ns, TimeNs to_ns) {
    return static_cast<double>(to_ns - from_ns) / static_cast<double>(ns_per_s);
}

/// In (-180, 180].
double wrapped(double angle) {
    const double turns = std::ceil((angle - 180.0) / 360.0);
    return angle - 360.0 * turns;
}

double clamped(double value, const PtzLimits& limits) {
    return std::clamp(value, limits.low, limits.high);
}

double rounded(double angle, double quantum) {
    return quantum >= least_quantum_deg ? quantum * std::round(angle / quantum) : angle;
}

/// How wrong an axis stops after a motion; `random`: 0 to 1.
double error_of_stop(const PtzAxisOptions& options, const AxisMotion& motion, double random) {
    const double first_s = std::min(motion.duration_s(), error_ramp_s);
    const double way = motion.at(first_s).position - motion.at(0.0).position;
    return options.repeatability * (2.0 * random - 1.0) - std::copysign(0.5 * options.backlash, way);
}

TimeNs begin_of(const auto& segment) {
    return segment.motion.begin_ns;
}

}  // namespace

TimeNs later_by(TimeNs from_ns, double seconds) {
    constexpr double longest_s = 1e9;
    if (!(seconds < longest_s)) return never_ns;
    return from_ns + static_cast<TimeNs>(std::ceil(seconds * static_cast<double>(ns_per_s)));
}

AxisState PtzMotion::motor(TimeNs world_ns) const {
    return motion.at(std::max(0.0, seconds_between(begin_ns, world_ns)));
}

double PtzMotion::error(TimeNs world_ns) const {
    const double ramp_s = std::min(motion.duration_s(), error_ramp_s);
    if (!(ramp_s > 0.0)) return error_to;
    return error_from + (error_to - error_from) * std::clamp(seconds_between(begin_ns, world_ns) / ramp_s, 0.0, 1.0);
}

/// A tour of one axis from when it first stands at the first stop.
class PtzAxis::Rounds {
public:
    Rounds(const PtzAxisOptions& options, std::uint64_t seed, const PtzMotion& first, TimeNs round_ns,
           std::vector<PtzTourLeg> legs)
        : options_(options), seed_(seed), first_(first), round_ns_(round_ns), legs_(std::move(legs)) {}

    /// The leg that began last: what it does at that time and until the next one begins.
    PtzMotion at(TimeNs world_ns) const {
        const TimeNs since_ns = std::max<TimeNs>(0, world_ns - first_.begin_ns);
        const auto next = std::ranges::upper_bound(legs_, since_ns % round_ns_, {}, &PtzTourLeg::begin_ns);
        const auto done = static_cast<std::uint64_t>(since_ns / round_ns_) * legs_.size();
        const auto begun = done + static_cast<std::uint64_t>(next - legs_.begin());
        if (begun == 0) return first_;
        const TimeNs round_begin_ns = first_.begin_ns + static_cast<TimeNs>((begun - 1) / legs_.size()) * round_ns_;
        const PtzTourLeg& leg = leg_before(begun);
        const TimeNs begin_ns = round_begin_ns + leg.begin_ns;
        return {begin_ns, begin_ns, leg.motion, error_after(begun - 1), error_after(begun)};
    }

private:
    /// The last of so many.
    const PtzTourLeg& leg_before(std::uint64_t count) const { return legs_[(count - 1) % legs_.size()]; }

    /// How wrong it is after so many legs: where it had not to move, as after the leg before.
    double error_after(std::uint64_t count) const {
        const std::uint64_t last = count > legs_.size() ? count - legs_.size() : 0;
        for (; count > last; --count) {
            const AxisMotion& motion = leg_before(count).motion;
            if (motion.duration_s() > 0.0)
                return error_of_stop(options_, motion, random_unit(seed_, options_.stream, count));
        }
        return first_.error_to;
    }

    PtzAxisOptions options_;
    std::uint64_t seed_;
    PtzMotion first_;  ///< a stand
    TimeNs round_ns_;
    std::vector<PtzTourLeg> legs_;
};

PtzAxis::PtzAxis(PtzAxisOptions options)
    : options_(options),
      segments_{{.motion = {.motion = AxisMotion(options.limits ? clamped(0.0, *options.limits) : 0.0)}}} {}

PtzMotion PtzAxis::motion(TimeNs world_ns) const {
    const auto next = std::ranges::upper_bound(segments_, world_ns, {}, begin_of<Segment>);
    const Segment& now = next == segments_.begin() ? *next : *std::prev(next);
    return now.rounds ? now.rounds->at(world_ns) : now.motion;
}

double PtzAxis::position(TimeNs world_ns) const {
    const PtzMotion now = motion(world_ns);
    const double position = now.motor(world_ns).position + now.error(world_ns);
    return options_.limits ? clamped(position, *options_.limits) : wrapped(position);
}

double PtzAxis::believed(TimeNs world_ns, double quantum) const {
    const double position = rounded(motor(world_ns).position, quantum);
    return options_.limits ? clamped(position, *options_.limits) : wrapped(position);
}

bool PtzAxis::is_moving(TimeNs world_ns) const {
    const bool is_pending = std::ranges::any_of(segments_, [&](const Segment& one) {
        return one.motion.told_ns <= world_ns && world_ns < one.motion.begin_ns;
    });
    return is_pending || world_ns < motion(world_ns).end_ns();
}

TimeNs PtzAxis::end_ns() const {
    return is_on_tour() ? never_ns : segments_.back().motion.end_ns();
}

double PtzAxis::within(double target) const {
    return options_.limits ? clamped(target, *options_.limits) : target;
}

double PtzAxis::nearest(double target, double from) const {
    return options_.limits ? clamped(target, *options_.limits) : from + wrapped(target - from);
}

double PtzAxis::towards(double target, double from) const {
    return within(from + wrapped(target - from));
}

std::size_t PtzAxis::pending(TimeNs now_ns) const {
    return static_cast<std::size_t>(
        std::ranges::count_if(segments_, [&](const Segment& one) { return one.motion.begin_ns > now_ns; }));
}

void PtzAxis::add(TimeNs told_ns, const Segment& added) {
    const auto given_up = std::ranges::lower_bound(segments_, added.motion.begin_ns, {}, begin_of<Segment>);
    segments_.erase(given_up, segments_.end());
    segments_.push_back(added);
    // Of the past, the second must have begun before what is kept, or the first is still needed.
    while (segments_.size() > 1 && begin_of(segments_[1]) <= told_ns &&
           (segments_.size() > max_segments || begin_of(segments_[1]) <= told_ns - kept_ns))
        segments_.erase(segments_.begin());
}

void PtzAxis::add_motion(TimeNs told_ns, TimeNs begin_ns, const AxisMotion& motion, std::optional<double> error) {
    const double before = this->motion(begin_ns).error(begin_ns);
    add(told_ns, {.motion = {told_ns, begin_ns, motion, before, error.value_or(before)}});
}

void PtzAxis::go(TimeNs told_ns, TimeNs begin_ns, const AxisMotion& motion) {
    if (!(motion.duration_s() > 0.0)) return add_motion(told_ns, begin_ns, motion, std::nullopt);
    const double random = random_unit(options_.seed, options_.stream, stops_++);
    add_motion(told_ns, begin_ns, motion, error_of_stop(options_, motion, random));
}

void PtzAxis::go_at_speed(TimeNs told_ns, TimeNs begin_ns, double speed, const AxisLimits& limits) {
    const AxisState from = motor(begin_ns);
    const double along = std::clamp(speed, -limits.speed, limits.speed);
    if (std::abs(along) < least_speed) return brake(told_ns, begin_ns, limits.acceleration);
    if (!options_.limits) return go(told_ns, begin_ns, AxisMotion::at_speed(from, along, limits));
    const double end = along < 0.0 ? options_.limits->low : options_.limits->high;
    go(told_ns, begin_ns, AxisMotion::to(from, end, {std::abs(along), limits.acceleration}));
}

void PtzAxis::brake(TimeNs told_ns, TimeNs begin_ns, double acceleration) {
    add_motion(told_ns, begin_ns, AxisMotion::stop(motor(begin_ns), acceleration), std::nullopt);
}

void PtzAxis::tour(TimeNs told_ns, TimeNs begin_ns, TimeNs round_ns, std::vector<PtzTourLeg> legs) {
    const PtzMotion before = motion(begin_ns);
    const double error = before.error(begin_ns);
    // An axis that waits there for the others does not move: until then it was told nothing.
    const PtzMotion stand{begin_ns, begin_ns, AxisMotion(before.motor(begin_ns).position), error, error};
    // Numbers of its own: how many stops it will have made when it ends nobody knows.
    const std::uint64_t seed = random_bits(options_.seed, options_.stream, stops_++);
    add(told_ns, {stand, std::make_shared<const Rounds>(options_, seed, stand, round_ns, std::move(legs))});
}

PtzAxis PtzAxis::standing(TimeNs last_ns) const {
    const TimeNs when_ns = end_ns() == never_ns ? last_ns : end_ns();
    const double error = motion(when_ns).error(when_ns);
    PtzAxis axis = *this;
    axis.segments_ = {
        {.motion = {.motion = AxisMotion(motor(when_ns).position), .error_from = error, .error_to = error}}};
    return axis;
}

}  // namespace camrig::camera
