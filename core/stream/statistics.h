#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/time.h"

namespace camrig::stream {

/// The counts of a reader at one moment.
struct ReaderReport {
    std::string kind, peer;
    std::uint64_t offered = 0, delivered = 0, dropped = 0, bytes = 0;
    double latency_ms = 0;
    std::uint64_t fault = 0, damaged = 0;
};

/// Counts of one reader. Always: offered = delivered + dropped + in flight (at most one or two units).
struct ReaderStats {
    std::string kind;  ///< "mjpeg", "v4l2", ...
    std::string peer;  ///< "127.0.0.1:40312", "/dev/video4"
    std::atomic<std::uint64_t> offered{0};
    std::atomic<std::uint64_t> delivered{0};
    std::atomic<std::uint64_t> dropped{0};
    std::atomic<std::uint64_t> fault{0};    ///< of those dropped, by a fault
    std::atomic<std::uint64_t> damaged{0};  ///< whose bytes a fault has changed
    std::atomic<std::uint64_t> bytes{0};
    std::atomic<TimeNs> last_latency_ns{0};  ///< instant -> handed to the kernel

    ReaderReport report() const;
};

/// Durations of one stage of the pipeline, as a histogram with 8 buckets per factor of two (at most 13 % wide),
/// lock-free.
class StageTimer {
public:
    void record(TimeNs duration_ns);

    struct Summary {
        std::uint64_t count = 0;
        double mean_ms = 0;
        double p50_ms = 0;
        double p99_ms = 0;
        double p999_ms = 0;
        double max_ms = 0;
    };
    Summary summary() const;

private:
    static constexpr int bucket_count = 8 * 40;
    std::array<std::atomic<std::uint64_t>, bucket_count> buckets_{};
    std::atomic<std::uint64_t> count_{0};
    std::atomic<std::uint64_t> total_ns_{0};
    std::atomic<std::uint64_t> max_ns_{0};
};

/// Everything `stats.get` and /metrics show, at one moment. Plain data.
struct OutputReport {
    std::string format;  ///< "jpeg q90", "yuyv 640x480"
    std::uint64_t received = 0, encoded = 0, dropped = 0, failed = 0;
    std::vector<ReaderReport> readers;
    /// due = received + fault + not_drawn, received = encoded + dropped + failed + kept_back (from all readers, by a
    /// fault of the way to them).
    std::uint64_t due = 0, fault = 0, not_drawn = 0, kept_back = 0;
};
/// Frames of a camera that fall due and do not come: evenly from the first one's world time to the last one's.
struct MissedFrames {
    TimeNs first_ns = 0, last_ns = 0;
    std::uint64_t count = 0;
};
/// Why a picture that was due is not drawn.
enum class DropReason : std::uint8_t {
    overload,  ///< the machine has too little time for all cameras
    own_cost,  ///< the camera's pictures cost more than those of others, and more than its share of the time
    request,   ///< pictures and truth on request took the time
    failure,   ///< it could not be drawn; the log says why
    fault,     ///< the camera fails so (fault.set)
    held,      ///< the world was held at its limit then (world.limit)
};
inline constexpr int drop_reason_count = 6;
inline constexpr std::array<std::string_view, drop_reason_count> drop_reason_names = {"overload", "own_cost", "request",
                                                                                      "failure",  "fault",    "held"};
struct CameraReport {
    std::string name;
    /// Frames that fell due while somebody watched; due = rendered + dropped. Frames due with nobody watching are
    /// `idle`.
    std::uint64_t due = 0, rendered = 0, dropped = 0, idle = 0;
    std::array<std::uint64_t, drop_reason_count> dropped_for{};  ///< by DropReason; their sum is `dropped`
    std::vector<OutputReport> outputs;
};
struct StageReport {
    std::string name;  ///< "world", "draw", "publish", "convert", "encode", "wakeup", "truth"
    StageTimer::Summary summary;
};
/// One number that the renderer keeps: "static_layer_bytes". `total`: it only ever rises.
struct CounterReport {
    std::string_view name;  ///< of a constant
    bool total = false;
    std::uint64_t value = 0;
    std::string_view help;
};
struct RigReport {
    TimeNs world_ns = 0;
    TimeNs monotonic_ns = 0;
    std::uint64_t instants = 0;          ///< instants at which something was due
    std::uint64_t dropped_instants = 0;  ///< those of which pictures were dropped for lack of time
    std::vector<CameraReport> cameras;
    std::vector<StageReport> stages;
    std::vector<CounterReport> renderer;
};

}  // namespace camrig::stream
