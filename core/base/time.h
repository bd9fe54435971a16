#pragma once

#include <cstdint>

namespace camrig {

/// All time is integer nanoseconds. The name of a variable says which clock it counts:
/// `world_ns` (the world's own time, 0 when a scene is loaded) or `monotonic_ns` (CLOCK_MONOTONIC).
using TimeNs = std::int64_t;

inline constexpr TimeNs ns_per_us = 1'000;
inline constexpr TimeNs ns_per_ms = 1'000'000;
inline constexpr TimeNs ns_per_s = 1'000'000'000;

/// Furthest world time, 2^62 ns (146 years): sums of two times never overflow.
inline constexpr TimeNs max_time_ns = TimeNs{1} << 62;

}  // namespace camrig
