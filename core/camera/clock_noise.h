#pragma once

#include <cstdint>

#include "core/base/time.h"

// What is random in a camera's clock, as functions of a seed and a counter or time alone. Integers only: the same on
// every processor.
namespace camrig::camera {

/// Which of a clock's random numbers.
enum class ClockNoise : std::uint64_t { jitter = 1, walk, wander, holdover, trigger };

/// A random number of that standard deviation (0 to 1e9), by counter; at most 3.47 of it. The sum of four even ones.
std::int64_t bell_number(std::uint64_t seed, ClockNoise kind, std::uint64_t counter, std::int64_t deviation);
/// Even in low to high, by counter.
std::int64_t even_number(std::uint64_t seed, ClockNoise kind, std::uint64_t counter, std::int64_t low,
                         std::int64_t high);

/// Never more than `most_ns` from 0, at an even place in between every `period_ns`, and on the line from one to the
/// next between.
TimeNs wander_ns(std::uint64_t seed, TimeNs world_ns, TimeNs period_ns, TimeNs most_ns);

/// A random walk (Wiener process) of that standard deviation after a second, 0 at time 0, on a line within each 2^30
/// ns. Levy's construction: the middle of an interval is between its ends, off by a random number of that middle alone;
/// from 2^62 ns down it takes 32 halvings to any time.
TimeNs walk_ns(std::uint64_t seed, TimeNs world_ns, std::int64_t deviation_ns);

}  // namespace camrig::camera
