#include "core/camera/ptz_head.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>

#include "core/base/portable_math.h"

namespace camrig::camera {
namespace {

/// A zoom motor is at its speed after so long.
constexpr double zoom_start_s = 0.1;

/// An axis that is to go from a state to a stand.
struct Way {
    AxisState from;
    double target = 0.0;
};

/// All arrive together, when the one does that takes longest.
std::vector<AxisMotion> together(std::span<const Way> ways, const AxisLimits& limits) {
    double longest_s = 0.0;
    for (const Way& way : ways)
        longest_s = std::max(longest_s, AxisMotion::to(way.from, way.target, limits).duration_s());
    std::vector<AxisMotion> motions;
    for (const Way& way : ways) motions.push_back(AxisMotion::to_in(way.from, way.target, limits, longest_s));
    return motions;
}

}  // namespace

std::span<const Named<PtzMode>> names_of(std::type_identity<PtzMode>) {
    static constexpr Named<PtzMode> names[] = {{PtzMode::absolute, "absolute"},
                                               {PtzMode::relative, "relative"},
                                               {PtzMode::continuous, "continuous"},
                                               {PtzMode::fov, "fov"}};
    return names;
}

PtzHead::PtzHead(const PtzSpec& spec)
    : spec_(spec),
      pan_({spec.pan_limits_deg, spec.repeatability_deg, spec.backlash_deg, spec.seed, 0}),
      tilt_({spec.tilt_limits_deg, spec.repeatability_deg, spec.backlash_deg, spec.seed, 1}),
      zoom_({.limits = PtzLimits{0.0, portable::log(spec.zoom_max)}}),
      home_(at(0)) {}

double PtzHead::slower_by(const PtzMove& move, TimeNs begin_ns) const {
    const bool is_slowed =
        spec_.is_proportional && (move.mode == PtzMode::relative || move.mode == PtzMode::continuous);
    return is_slowed ? portable::exp(zoom_.motor(begin_ns).position) : 1.0;
}

AxisLimits PtzHead::angle_limits(const PtzMove& move, TimeNs begin_ns) const {
    return {spec_.speed_deg_s * move.speed / slower_by(move, begin_ns), spec_.acceleration_deg_s2};
}

AxisLimits PtzHead::zoom_limits(double share) const {
    const double speed = portable::log(spec_.zoom_max) / spec_.zoom_s;
    return {speed * share, speed / zoom_start_s};
}

Result<void> PtzHead::check_room(TimeNs now_ns) const {
    if (std::max({pan_.pending(now_ns), tilt_.pending(now_ns), zoom_.pending(now_ns)}) + 2 < PtzAxis::max_segments)
        return {};
    return error(ErrorKind::resource_exhausted, "the head begins a command only after its latency, and " +
                                                    std::to_string(PtzAxis::max_segments) +
                                                    " wait already; send slower");
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
    leave_tour(spec_.latency_s, now_ns);
    return {};
}

Result<void> PtzHead::go_to(const PtzPosition& position, double speed, TimeNs now_ns) {
    if (auto good = check_room(now_ns); !good) return good;
    const PtzMove there{
        .pan_deg = position.pan_deg, .tilt_deg = position.tilt_deg, .zoom = position.zoom, .speed = speed};
    turn(there, now_ns);
    run_zoom(there, now_ns);
    return {};
}

Result<void> PtzHead::set_preset(const std::string& name, TimeNs now_ns) {
    if (presets_.size() >= max_presets && !presets_.contains(name))
        return error(ErrorKind::resource_exhausted,
                     "the head has " + std::to_string(max_presets) + " presets already; remove one");
    presets_[name] = status(now_ns).position;
    return {};
}

Result<PtzPosition> PtzHead::preset(const std::string& name) const {
    const auto found = presets_.find(name);
    if (found == presets_.end()) return error(ErrorKind::not_found, "there is no preset '" + name + "'");
    return found->second;
}

Result<void> PtzHead::go_to_preset(const std::string& name, double speed, TimeNs now_ns) {
    const auto there = preset(name);
    if (!there) return std::unexpected(there.error());
    return go_to(*there, speed, now_ns);
}

Result<void> PtzHead::remove_preset(const std::string& name) {
    if (presets_.erase(name) == 0) return error(ErrorKind::not_found, "there is no preset '" + name + "'");
    return {};
}

Result<void> PtzHead::set_tour(const std::string& name, PtzTour tour) {
    if (tours_.size() >= max_tours && !tours_.contains(name))
        return error(ErrorKind::resource_exhausted,
                     "the head has " + std::to_string(max_tours) + " tours already; remove one");
    if (tour.empty() || tour.size() > max_tour_stops)
        return error(ErrorKind::invalid_argument, "stops: must be 1 to " + std::to_string(max_tour_stops));
    for (const PtzTourStop& stop : tour)
        if (const auto there = preset(stop.preset); !there) return std::unexpected(there.error());
    tours_[name] = std::move(tour);
    return {};
}

Result<void> PtzHead::remove_tour(const std::string& name) {
    if (tours_.erase(name) == 0) return error(ErrorKind::not_found, "there is no tour '" + name + "'");
    return {};
}

Result<void> PtzHead::start_tour(const std::string& name, TimeNs now_ns) {
    const auto found = tours_.find(name);
    if (found == tours_.end()) return error(ErrorKind::not_found, "there is no tour '" + name + "'");
    const PtzTour& tour = found->second;
    std::vector<PtzPosition> places;
    for (const PtzTourStop& stop : tour) {
        const auto there = preset(stop.preset);
        if (!there) return std::unexpected(there.error());
        places.push_back(*there);
    }
    std::vector<PtzTourLeg> pan, tilt, zoom;
    TimeNs round_ns = 0;
    for (std::size_t i = 0; i < tour.size(); ++i) {
        const std::size_t next = (i + 1) % tour.size();
        const PtzPosition &from = places[i], &to = places[next];
        const Way turns[] = {{{from.pan_deg}, pan_.nearest(to.pan_deg, from.pan_deg)},
                             {{from.tilt_deg}, tilt_.within(to.tilt_deg)}};
        const auto turned = together(turns, angle_limits({.speed = tour[next].speed}, 0));
        const auto zoomed = AxisMotion::to({zoom_.within(portable::log(from.zoom))},
                                           zoom_.within(portable::log(to.zoom)), zoom_limits(tour[next].speed));
        round_ns += tour[i].dwell;
        pan.push_back({round_ns, turned[0]});
        tilt.push_back({round_ns, turned[1]});
        zoom.push_back({round_ns, zoomed});
        round_ns = later_by(round_ns, std::max({turned[0].duration_s(), turned[1].duration_s(), zoomed.duration_s()}));
    }
    if (auto good = go_to(places.front(), tour.front().speed, now_ns); !good) return good;
    const TimeNs begin_ns = arrives_ns();
    pan_.tour(now_ns, begin_ns, round_ns, std::move(pan));
    tilt_.tour(now_ns, begin_ns, round_ns, std::move(tilt));
    zoom_.tour(now_ns, begin_ns, round_ns, std::move(zoom));
    tour_ = name;
    return {};
}

void PtzHead::leave_tour(double latency_s, TimeNs now_ns) {
    const TimeNs begin_ns = later_by(now_ns, latency_s);
    for (PtzAxis* const axis : {&pan_, &tilt_})
        if (axis->is_on_tour()) axis->brake(now_ns, begin_ns, spec_.acceleration_deg_s2);
    if (zoom_.is_on_tour()) zoom_.brake(now_ns, begin_ns, zoom_limits(1.0).acceleration);
}

TimeNs PtzHead::begin_at_speed(double speed, TimeNs now_ns) const {
    return later_by(now_ns, std::abs(speed) < PtzAxis::least_speed ? spec_.stop_latency_s : spec_.latency_s);
}

void PtzHead::turn(const PtzMove& move, TimeNs now_ns) {
    const TimeNs begin_ns = later_by(now_ns, spec_.latency_s);
    const AxisLimits limits = angle_limits(move, begin_ns);
    struct Turn {
        PtzAxis& axis;
        double asked;
    };
    std::vector<Turn> turns;
    if (move.pan_deg) turns.push_back({pan_, *move.pan_deg});
    if (move.tilt_deg) turns.push_back({tilt_, *move.tilt_deg});
    if (move.mode == PtzMode::continuous) {
        const double slower = slower_by(move, begin_ns);
        for (const Turn& one : turns) {
            const double speed = one.asked / slower;
            one.axis.go_at_speed(now_ns, begin_at_speed(speed, now_ns), speed, limits);
            if (move.timeout && one.axis.end_ns() > begin_ns + *move.timeout)
                one.axis.brake(now_ns, begin_ns + *move.timeout, limits.acceleration);
        }
        return;
    }
    std::vector<Way> ways;
    for (const Turn& one : turns) {
        const AxisState from = one.axis.motor(begin_ns);
        const double target = move.mode == PtzMode::relative ? one.axis.within(from.position + one.asked)
                              : move.mode == PtzMode::fov    ? one.axis.towards(one.asked, from.position)
                                                             : one.axis.nearest(one.asked, from.position);
        ways.push_back({from, target});
    }
    const auto motions = together(ways, limits);
    for (std::size_t i = 0; i < turns.size(); ++i) turns[i].axis.go(now_ns, begin_ns, motions[i]);
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
    const double target = zoom_.within(move.mode == PtzMode::absolute ? by : from.position + by);
    zoom_.go(now_ns, begin_ns, AxisMotion::to(from, target, zoom_limits(move.speed)));
}

Result<void> PtzHead::stop(bool pan_and_tilt, bool zoom, TimeNs now_ns) {
    if (auto good = check_room(now_ns); !good) return good;
    const TimeNs begin_ns = later_by(now_ns, spec_.stop_latency_s);
    if (pan_and_tilt)
        for (PtzAxis* const axis : {&pan_, &tilt_}) axis->brake(now_ns, begin_ns, spec_.acceleration_deg_s2);
    if (zoom) zoom_.brake(now_ns, begin_ns, zoom_limits(1.0).acceleration);
    leave_tour(spec_.stop_latency_s, now_ns);
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
    for (PtzAxis PtzHead::* const axis : {&PtzHead::pan_, &PtzHead::tilt_, &PtzHead::zoom_})
        head.*axis = (this->*axis).standing(last_ns);
    return head;
}

}  // namespace camrig::camera
