#include "core/camera/clock_noise.h"

#include <algorithm>

#include "core/base/random.h"

namespace camrig::camera {
namespace {

__extension__ typedef __int128 Int128;
__extension__ typedef unsigned __int128 UInt128;

std::uint64_t bits_of(std::uint64_t seed, ClockNoise kind, std::uint64_t counter) {
    return random_bits(seed, static_cast<std::uint64_t>(kind), counter);
}

/// The walk is worked out in 2^-16 ns: a sum of so many random numbers must not be one of roundings.
constexpr int walk_fraction_bits = 16;
constexpr int walk_top_bit = 62, walk_line_bit = 30;

/// Of a walk over 2^bit ns, in 2^-16 ns: deviation * sqrt(2^bit / 1e9).
std::int64_t deviation_over(int bit, std::int64_t deviation_ns) {
    constexpr std::int64_t root_of_2 = 92'682, root_of_1e9 = 316'227'766;  // in 2^-16, in 1e-4
    const Int128 root = (bit % 2 == 0 ? Int128{1} << walk_fraction_bits : Int128{root_of_2}) << (bit / 2);
    return static_cast<std::int64_t>(root * deviation_ns * 10'000 / root_of_1e9);
}

}  // namespace

std::int64_t bell_number(std::uint64_t seed, ClockNoise kind, std::uint64_t counter, std::int64_t deviation) {
    if (deviation == 0) return 0;
    const std::uint64_t bits = bits_of(seed, kind, counter);
    std::int64_t sum = -2 * 65'535;
    for (int i = 0; i < 4; ++i) sum += static_cast<std::int64_t>((bits >> (16 * i)) & 0xffff);
    constexpr std::int64_t deviation_of_sum = 37'837;  // 65536 * sqrt(4 / 12)
    return static_cast<std::int64_t>(Int128{sum} * deviation / deviation_of_sum);
}

std::int64_t even_number(std::uint64_t seed, ClockNoise kind, std::uint64_t counter, std::int64_t low,
                         std::int64_t high) {
    const auto numbers = static_cast<std::uint64_t>(high - low) + 1;
    return low + static_cast<std::int64_t>((UInt128{bits_of(seed, kind, counter)} * numbers) >> 64);
}

TimeNs wander_ns(std::uint64_t seed, TimeNs world_ns, TimeNs period_ns, TimeNs most_ns) {
    const auto node = static_cast<std::uint64_t>(world_ns / period_ns);
    const TimeNs from = even_number(seed, ClockNoise::wander, node, -most_ns, most_ns);
    const TimeNs to = even_number(seed, ClockNoise::wander, node + 1, -most_ns, most_ns);
    return from + static_cast<TimeNs>(Int128{to - from} * (world_ns % period_ns) / period_ns);
}

TimeNs walk_ns(std::uint64_t seed, TimeNs world_ns, std::int64_t deviation_ns) {
    if (deviation_ns == 0) return 0;
    const auto time = static_cast<std::uint64_t>(std::max<TimeNs>(0, world_ns));
    std::int64_t left = 0;
    std::int64_t right = bell_number(seed, ClockNoise::walk, 0, deviation_over(walk_top_bit, deviation_ns));
    for (int bit = walk_top_bit; bit > walk_line_bit; --bit) {
        const std::uint64_t interval = (std::uint64_t{1} << (walk_top_bit - bit)) + (time >> bit);
        const std::int64_t middle =
            (left + right) / 2 + bell_number(seed, ClockNoise::walk, interval, deviation_over(bit, deviation_ns) / 2);
        const bool is_in_second_half = (time >> (bit - 1)) & 1;
        (is_in_second_half ? left : right) = middle;
    }
    const std::uint64_t rest = time & ((std::uint64_t{1} << walk_line_bit) - 1);
    const auto there =
        static_cast<std::int64_t>((Int128{right - left} * static_cast<std::int64_t>(rest)) >> walk_line_bit);
    return (left + there) >> walk_fraction_bits;
}

}  // namespace camrig::camera
