#include "core/camera/clock_spec.h"

#include "core/base/field_of.h"

namespace camrig::camera {

std::span<const Named<ClockState>> names_of(std::type_identity<ClockState>) {
    static constexpr Named<ClockState> names[] = {{ClockState::free, "free"},
                                                  {ClockState::ntp, "ntp"},
                                                  {ClockState::ptp, "ptp"},
                                                  {ClockState::ptp_lost, "ptp_lost"},
                                                  {ClockState::tai, "tai"}};
    return names;
}

FieldTable<ClockSpec> fields_of(std::type_identity<ClockSpec>) {
    using S = ClockSpec;
    constexpr auto most_ppb = static_cast<double>(S::max_ppb), most_offset = static_cast<double>(S::max_offset_ns);
    static const std::vector<FieldOf<S>> table{
        field_at<&S::state>({.name = "state",
                             .doc = "what keeps it right: nothing, a server by NTP, a master by PTP, no longer a "
                                    "master; tai: a master by PTP whose TAI it takes for UTC"}),
        field_at<&S::offset_ns>({.name = "offset_ns",
                                 .doc = "it says so much more than the true time",
                                 .unit = "ns",
                                 .range = {-most_offset, most_offset}}),
        field_at<&S::drift_ppb>({.name = "drift_ppb",
                                 .doc = "so many billionths faster, from world time 0 on; of state free",
                                 .unit = "ppb",
                                 .range = {-most_ppb, most_ppb}}),
        field_at<&S::walk_ns>({.name = "walk_ns",
                               .doc = "standard deviation of its random walk after a second; grows with the root of "
                                      "the time; of state free",
                               .unit = "ns",
                               .range = {0, 1e6}}),
        field_at<&S::jitter_ns>({.name = "jitter_ns",
                                 .doc = "standard deviation of each stamp on its own; at most 3.5 of it",
                                 .unit = "ns",
                                 .range = {0, 1e9}}),
        field_at<&S::step_ns>({.name = "step_ns",
                               .doc = "somebody sets it: so much is added from step_at_ns on",
                               .unit = "ns",
                               .range = {-most_offset, most_offset}}),
        field_at<&S::step_at_ns>(
            {.name = "step_at_ns", .doc = "world time of that", .unit = "ns", .range = {0, 4.6e18}}),
        field_at<&S::phase_ns>({.name = "phase_ns",
                                .doc = "the camera exposes so much later than cameras of its rate do",
                                .unit = "ns",
                                .range = {0, static_cast<double>(S::max_phase_ns)}}),
        field_at<&S::rate_ppb>({.name = "rate_ppb",
                                .doc = "it exposes so many billionths more often than `fps` says",
                                .unit = "ppb",
                                .range = {-most_ppb, most_ppb}}),
        field_at<&S::trigger_jitter_ns>({.name = "trigger_jitter_ns",
                                         .doc = "each exposure is late by 0 to this, at most half a period",
                                         .unit = "ns",
                                         .range = {0, 1e9}}),
        field_at<&S::seed>({.name = "seed", .doc = "of all that is random in it", .range = {.low = 0}}),
    };
    return table;
}

}  // namespace camrig::camera
