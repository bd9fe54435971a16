#include "core/stream/statistics.h"

#include <algorithm>
#include <bit>

namespace camrig::stream {
namespace {

constexpr int buckets_per_octave = 8;

/// Eight buckets per factor of two: the octave from the highest bit, the eighth from the three bits below it.
int bucket_of(std::uint64_t ns) {
    if (ns < buckets_per_octave) return static_cast<int>(ns);
    const int octave = std::bit_width(ns) - 1;
    const int eighth = static_cast<int>((ns >> (octave - 3)) & 7);
    return (octave - 2) * buckets_per_octave + eighth;
}

/// Where a bucket begins, ns.
double begin_of(int bucket) {
    if (bucket < buckets_per_octave) return bucket;
    const int octave = bucket / buckets_per_octave + 2;
    const int eighth = bucket % buckets_per_octave;
    return (8.0 + eighth) * static_cast<double>(std::uint64_t{1} << (octave - 3));
}

}  // namespace

ReaderReport ReaderStats::report() const {
    return {kind,  peer,   offered, delivered, dropped, bytes, static_cast<double>(last_latency_ns) / ns_per_ms,
            fault, damaged};
}

void StageTimer::record(TimeNs duration_ns) {
    const auto ns = static_cast<std::uint64_t>(std::max<TimeNs>(duration_ns, 0));
    buckets_[static_cast<std::size_t>(std::min(bucket_of(ns), bucket_count - 1))].fetch_add(1,
                                                                                            std::memory_order_relaxed);
    count_.fetch_add(1, std::memory_order_relaxed);
    total_ns_.fetch_add(ns, std::memory_order_relaxed);
    std::uint64_t seen = max_ns_.load(std::memory_order_relaxed);
    while (seen < ns && !max_ns_.compare_exchange_weak(seen, ns, std::memory_order_relaxed)) {
    }
}

StageTimer::Summary StageTimer::summary() const {
    Summary summary;
    std::array<std::uint64_t, bucket_count> counts{};
    std::uint64_t all = 0;
    for (int i = 0; i < bucket_count; ++i) {
        counts[static_cast<std::size_t>(i)] = buckets_[static_cast<std::size_t>(i)].load(std::memory_order_relaxed);
        all += counts[static_cast<std::size_t>(i)];
    }
    if (all == 0) return summary;
    const double max_ms = static_cast<double>(max_ns_.load(std::memory_order_relaxed)) / 1e6;
    const auto quantile = [&](double q) {
        // Within a bucket durations are taken to be spread evenly.
        double left = q * static_cast<double>(all - 1) + 0.5;
        for (int i = 0; i < bucket_count; ++i) {
            const auto count = static_cast<double>(counts[static_cast<std::size_t>(i)]);
            if (left < count) {
                const double from_ms = begin_of(i) / 1e6, to_ms = std::min(begin_of(i + 1) / 1e6, max_ms);
                return from_ms + (to_ms - from_ms) * left / count;
            }
            left -= count;
        }
        return max_ms;
    };
    summary.count = all;
    summary.mean_ms = static_cast<double>(total_ns_.load(std::memory_order_relaxed)) / 1e6 / static_cast<double>(all);
    summary.p50_ms = quantile(0.5);
    summary.p99_ms = quantile(0.99);
    summary.p999_ms = quantile(0.999);
    summary.max_ms = max_ms;
    return summary;
}

}  // namespace camrig::stream
