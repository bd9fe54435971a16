#pragma once

#include <cstdint>

#include "core/base/field_table.h"
#include "core/base/named.h"
#include "core/base/time.h"

namespace camrig::camera {

/// What keeps a camera's clock right. `free`: nothing, it is its crystal; `ntp`: a server over a network (RFC 5905);
/// `ptp`: a grandmaster, with stamps made in hardware (IEEE 1588); `ptp_lost`: the same until now, and then the crystal
/// with the correction that it had last; `tai`: as ptp, but the camera tells the master's TAI for UTC.
enum class ClockState : std::uint8_t { free, ntp, ptp, ptp_lost, tai };
std::span<const Named<ClockState>> names_of(std::type_identity<ClockState>);

/// A camera's clock: what it says (stamps), and when it lets the camera expose (instants). They are wrong
/// independently.
struct ClockSpec {
    static constexpr TimeNs max_offset_ns = 2'000'000'000 * ns_per_s;
    static constexpr std::int64_t max_ppb = 1'000'000;
    static constexpr TimeNs max_phase_ns = 10 * ns_per_s;  ///< the longest period of a camera

    // The stamp.
    ClockState state = ClockState::free;
    TimeNs offset_ns = 0;
    std::int64_t drift_ppb = 0;  ///< state free only
    std::int64_t walk_ns = 0;    ///< standard deviation of its random walk after a second; state free only
    std::int64_t jitter_ns = 0;  ///< standard deviation, of each stamp on its own
    TimeNs step_ns = 0;
    TimeNs step_at_ns = 0;  ///< world time from which on step_ns is added

    // The instant.
    TimeNs phase_ns = 0;
    std::int64_t rate_ppb = 0;
    TimeNs trigger_jitter_ns = 0;  ///< each exposure is late by 0 to this, at most half a period

    std::uint64_t seed = 0;  ///< of all that is random in it
    friend bool operator==(const ClockSpec&, const ClockSpec&) = default;
};

FieldTable<ClockSpec> fields_of(std::type_identity<ClockSpec>);

}  // namespace camrig::camera
