#include "core/camera/ptz_head.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/base/portable_math.h"
#include "core/base/random.h"

namespace camrig::camera {
namespace {

/// As Timeline keeps it, so that pictures, truth and status of the recent past can be asked for.
constexpr TimeNs kept_ns = 250 * ns_per_ms;
constexpr TimeNs never_ns = std::numeric_limits<TimeNs>::max();
/// More commands than this are not kept of the past, nor taken before they begin.
constexpr std::size_t max_segments = 64;
/// A finer quantum is none: numbers as large as angles are have no room for it.
constexpr double least_quantum_deg = 1e-6;
/// Slower than this is a stand.
constexpr double least_speed = 1e-6;
/// An axis is as far off as where it is to stop after so long, or when it is there.
constexpr double error_ramp_s = 1.0;
/// A zoom motor is at its speed after so long.
constexpr double zoom_start_s = 0.1;

double seconds_between(TimeNs from_ns, TimeNs to_ns) {
    return static_cast<double>(to_ns - from_ns) / static_cast<double>(ns_per_s);
}

TimeNs later_by(TimeNs from_ns, double seconds) {
    constexpr double longest_s = 1e9;
    if (!(seconds < longest_s)) return never_ns;
    return from_ns + static_cast<TimeNs>(std::ceil(seconds * static_cast<double>(ns_per_s)));
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

}  // namespace

std::span<const Named<PtzMode>> names_of(std::type_identity<PtzMode>) {
    static constexpr Named<PtzMode> names[] = {
        {PtzMode::absolute, "absolute"}, {PtzMode::relative, "relative"}, {PtzMode::continuous, "continuous"}};
    return names;
}

AxisState PtzHead::Segment::motor(TimeNs world_ns) const {
    return motion.at(std::max(0.0, seconds_between(begin_ns, world_ns)));
}

double PtzHead::Segment::error(TimeNs world_ns) const {
    const double ramp_s = std::min(motion.duration_s(), error_ramp_s);
    if (!(ramp_s > 0.0)) return error_to;
    return error_from + (error_to - error_from) * std::clamp(seconds_between(begin_ns, world_ns) / ramp_s, 0.0, 1.0);
}

TimeNs PtzHead::Segment::end_ns() const {
    return later_by(begin_ns, motion.duration_s());
}

PtzHead::Axis::Axis(AxisOptions options)
    : options_(options), segments_{{.motion = AxisMotion(options.limits ? clamped(0.0, *options.limits) : 0.0)}} {}

const PtzHead::Segment& PtzHead::Axis::segment(TimeNs world_ns) const {
    const auto next = std::ranges::upper_bound(segments_, world_ns, {}, &Segment::begin_ns);
    return next == segments_.begin() ? *next : *std::prev(next);
}

double PtzHead::Axis::position(TimeNs world_ns) const {
    const Segment& now = segment(world_ns);
    const double position = now.motor(world_ns).position + now.error(world_ns);
    return options_.limits ? clamped(position, *options_.limits) : wrapped(position);
}

double PtzHead::Axis::believed(TimeNs world_ns, double quantum) const {
    const double position = rounded(motor(world_ns).position, quantum);
    return options_.limits ? clamped(position, *options_.limits) : wrapped(position);
}

bool PtzHead::Axis::is_moving(TimeNs world_ns) const {
    const Segment* const now = &segment(world_ns);
    return std::ranges::any_of(segments_, [&](const Segment& one) {
        const bool is_pending = one.told_ns <= world_ns && world_ns < one.begin_ns;
        return is_pending || (&one == now && world_ns < one.end_ns());
    });
}

double PtzHead::Axis::within(double target) const {
    return options_.limits ? clamped(target, *options_.limits) : target;
}

double PtzHead::Axis::nearest(double target, double from) const {
    return options_.limits ? clamped(target, *options_.limits) : from + wrapped(target - from);
}

std::size_t PtzHead::Axis::pending(TimeNs now_ns) const {
    return static_cast<std::size_t>(
        std::ranges::count_if(segments_, [&](const Segment& segment) { return segment.begin_ns > now_ns; }));
}

void PtzHead::Axis::add(TimeNs told_ns, TimeNs begin_ns, const AxisMotion& motion, std::optional<double> error) {
    const double before = segment(begin_ns).error(begin_ns);
    const Segment added{told_ns, begin_ns, motion, before, error.value_or(before)};
    const auto given_up = std::ranges::lower_bound(segments_, begin_ns, {}, &Segment::begin_ns);
    segments_.erase(given_up, segments_.end());
    segments_.push_back(added);
    // Of the past, the second must have begun before what is kept, or the first is still needed.
    while (segments_.size() > 1 && segments_[1].begin_ns <= told_ns &&
           (segments_.size() > max_segments || segments_[1].begin_ns <= told_ns - kept_ns))
        segments_.erase(segments_.begin());
}

void PtzHead::Axis::go(TimeNs told_ns, TimeNs begin_ns, const AxisMotion& motion) {
    if (!(motion.duration_s() > 0.0)) return add(told_ns, begin_ns, motion, std::nullopt);
    const double first_s = std::min(motion.duration_s(), error_ramp_s);
    const double way = motion.at(first_s).position - motor(begin_ns).position;
    const double noise = 2.0 * random_unit(options_.seed, options_.stream, stops_++) - 1.0;
    add(told_ns, begin_ns, motion, options_.repeatability * noise - std::copysign(0.5 * options_.backlash, way));
}

void PtzHead::Axis::go_at_speed(TimeNs told_ns, TimeNs begin_ns, double speed, const AxisLimits& limits) {
    const AxisState from = motor(begin_ns);
    const double along = std::clamp(speed, -limits.speed, limits.speed);
    if (std::abs(along) < least_speed) return brake(told_ns, begin_ns, limits.acceleration);
    if (!options_.limits) return go(told_ns, begin_ns, AxisMotion::at_speed(from, along, limits));
    const double end = along < 0.0 ? options_.limits->low : options_.limits->high;
    go(told_ns, begin_ns, AxisMotion::to(from, end, {std::abs(along), limits.acceleration}));
}

void PtzHead::Axis::brake(TimeNs told_ns, TimeNs begin_ns, double acceleration) {
    add(told_ns, begin_ns, AxisMotion::stop(motor(begin_ns), acceleration), std::nullopt);
}

PtzHead::Axis PtzHead::Axis::standing(TimeNs last_ns) const {
    const TimeNs when_ns = end_ns() == never_ns ? last_ns : end_ns();
    Axis axis = *this;
    axis.segments_ = {{.motion = AxisMotion(motor(when_ns).position),
                       .error_from = segment(when_ns).error(when_ns),
                       .error_to = segment(when_ns).error(when_ns)}};
    return axis;
}

PtzHead::PtzHead(const PtzSpec& spec)
    : spec_(spec),
      pan_({spec.pan_limits_deg, spec.repeatability_deg, spec.backlash_deg, spec.seed, 0}),
      tilt_({spec.tilt_limits_deg, spec.repeatability_deg, spec.backlash_deg, spec.seed, 1}),
      zoom_({.limits = PtzLimits{0.0, portable::log(spec.zoom_max)}}),
      home_(at(0)) {}

AxisLimits PtzHead::angle_limits(const PtzMove& move, TimeNs begin_ns) const {
    const bool is_slowed = spec_.is_proportional && move.mode != PtzMode::absolute;
    const double slower = is_slowed ? portable::exp(zoom_.motor(begin_ns).position) : 1.0;
    return {spec_.speed_deg_s * move.speed / slower, spec_.acceleration_deg_s2};
}

AxisLimits PtzHead::zoom_limits(double share) const {
    const double speed = portable::log(spec_.zoom_max) / spec_.zoom_s;
    return {speed * share, speed / zoom_start_s};
}

Result<void> PtzHead::check_room(TimeNs now_ns) const {
    if (std::max({pan_.pending(now_ns), tilt_.pending(now_ns), zoom_.pending(now_ns)}) + 2 < max_segments) return {};
    return error(ErrorKind::resource_exhausted, "the head begins a command only after its latency, and " +
                                                    std::to_string(max_segments) + " wait already; send slower");
}

Result<void> PtzHead::move(const PtzMove& move, TimeNs now_ns) {
    if (auto good = check_room(now_ns); !good) return good;
    if (move.mode == PtzMode::absolute) {
        const auto check = [](const char* name, std::optional<double> value, double low, double high) -> Result<void> {
            if (!value || (*value >= low && *value <= high)) return {};
            return error(ErrorKind::invalid_argument, std::string(name) + ": the head goes from " +
                                                          std::to_string(low) + " to " + std::to_string(high));
        };
        const PtzLimits pan = spec_.pan_limits_deg.value_or(PtzLimits{-360.0, 360.0}), tilt = spec_.tilt_limits_deg;
        for (const auto& good :
             {check("pan_deg", move.pan_deg, pan.low, pan.high), check("tilt_deg", move.tilt_deg, tilt.low, tilt.high),
              check("zoom", move.zoom, 1.0, spec_.zoom_max)})
            if (!good) return good;
    }
    if (move.pan_deg || move.tilt_deg) turn(move, now_ns);
    if (move.zoom) run_zoom(move, now_ns);
    return {};
}

Result<void> PtzHead::go_to(const PtzPosition& position, TimeNs now_ns) {
    if (auto good = check_room(now_ns); !good) return good;
    const PtzMove there{.pan_deg = position.pan_deg, .tilt_deg = position.tilt_deg, .zoom = position.zoom};
    turn(there, now_ns);
    run_zoom(there, now_ns);
    return {};
}

Result<void> PtzHead::aim(const PtzPosition& at, double speed, TimeNs now_ns) {
    if (auto good = check_room(now_ns); !good) return good;
    turn({.pan_deg = at.pan_deg, .tilt_deg = at.tilt_deg, .speed = speed}, now_ns);
    return {};
}

Result<void> PtzHead::set_preset(const std::string& name, TimeNs now_ns) {
    if (presets_.size() >= max_presets && !presets_.contains(name))
        return error(ErrorKind::resource_exhausted,
                     "the head has " + std::to_string(max_presets) + " presets already; remove one");
    presets_[name] = status(now_ns).position;
    return {};
}

Result<void> PtzHead::go_to_preset(const std::string& name, TimeNs now_ns) {
    const auto found = presets_.find(name);
    if (found == presets_.end()) return error(ErrorKind::not_found, "there is no preset '" + name + "'");
    return go_to(found->second, now_ns);
}

Result<void> PtzHead::remove_preset(const std::string& name) {
    if (presets_.erase(name) == 0) return error(ErrorKind::not_found, "there is no preset '" + name + "'");
    return {};
}

TimeNs PtzHead::begin_at_speed(double speed, TimeNs now_ns) const {
    return later_by(now_ns, std::abs(speed) < least_speed ? spec_.stop_latency_s : spec_.latency_s);
}

void PtzHead::turn(const PtzMove& move, TimeNs now_ns) {
    const TimeNs begin_ns = later_by(now_ns, spec_.latency_s);
    const AxisLimits limits = angle_limits(move, begin_ns);
    struct Turn {
        Axis& axis;
        double asked;
        AxisState from = {};
        double target = 0.0;
    };
    std::vector<Turn> turns;
    if (move.pan_deg) turns.push_back({pan_, *move.pan_deg});
    if (move.tilt_deg) turns.push_back({tilt_, *move.tilt_deg});
    if (move.mode == PtzMode::continuous) {
        for (const Turn& one : turns) {
            one.axis.go_at_speed(now_ns, begin_at_speed(one.asked, now_ns), one.asked, limits);
            if (move.timeout && one.axis.end_ns() > begin_ns + *move.timeout)
                one.axis.brake(now_ns, begin_ns + *move.timeout, limits.acceleration);
        }
        return;
    }
    double longest_s = 0.0;
    for (Turn& one : turns) {
        one.from = one.axis.motor(begin_ns);
        one.target = move.mode == PtzMode::relative ? one.axis.within(one.from.position + one.asked)
                                                    : one.axis.nearest(one.asked, one.from.position);
        longest_s = std::max(longest_s, AxisMotion::to(one.from, one.target, limits).duration_s());
    }
    for (const Turn& one : turns)
        one.axis.go(now_ns, begin_ns, AxisMotion::to_in(one.from, one.target, limits, longest_s));
}

void PtzHead::run_zoom(const PtzMove& move, TimeNs now_ns) {
    const TimeNs begin_ns = later_by(now_ns, spec_.latency_s);
    if (move.mode == PtzMode::continuous) {
        const AxisLimits limits = zoom_limits(1.0);
        const double speed = *move.zoom * limits.speed;
        zoom_.go_at_speed(now_ns, begin_at_speed(speed, now_ns), speed, limits);
        if (move.timeout && zoom_.end_ns() > begin_ns + *move.timeout)
            zoom_.brake(now_ns, begin_ns + *move.timeout, limits.acceleration);
        return;
    }
    const AxisState from = zoom_.motor(begin_ns);
    const double by = portable::log(*move.zoom);
    const double target = zoom_.within(move.mode == PtzMode::relative ? from.position + by : by);
    zoom_.go(now_ns, begin_ns, AxisMotion::to(from, target, zoom_limits(move.speed)));
}

Result<void> PtzHead::stop(bool pan_and_tilt, bool zoom, TimeNs now_ns) {
    if (auto good = check_room(now_ns); !good) return good;
    const TimeNs begin_ns = later_by(now_ns, spec_.stop_latency_s);
    if (pan_and_tilt)
        for (Axis* const axis : {&pan_, &tilt_}) axis->brake(now_ns, begin_ns, spec_.acceleration_deg_s2);
    if (zoom) zoom_.brake(now_ns, begin_ns, zoom_limits(1.0).acceleration);
    return {};
}

double PtzHead::zoom_of(TimeNs world_ns) const {
    return std::clamp(portable::exp(zoom_.motor(world_ns).position), 1.0, spec_.zoom_max);
}

PtzPosition PtzHead::at(TimeNs world_ns) const {
    return {pan_.position(world_ns), tilt_.position(world_ns), zoom_of(world_ns)};
}

PtzStatus PtzHead::status(TimeNs world_ns) const {
    return {
        {pan_.believed(world_ns, spec_.quantum_deg), tilt_.believed(world_ns, spec_.quantum_deg), zoom_of(world_ns)},
        at(world_ns),
        pan_.is_moving(world_ns) || tilt_.is_moving(world_ns),
        zoom_.is_moving(world_ns)};
}

TimeNs PtzHead::arrives_ns() const {
    return std::max({pan_.end_ns(), tilt_.end_ns(), zoom_.end_ns()});
}

bool PtzHead::never_stands() const {
    return arrives_ns() == never_ns;
}

PtzHead PtzHead::standing(TimeNs last_ns) const {
    PtzHead head = *this;
    for (Axis PtzHead::* const axis : {&PtzHead::pan_, &PtzHead::tilt_, &PtzHead::zoom_})
        head.*axis = (this->*axis).standing(last_ns);
    return head;
}

}  // namespace camrig::camera
