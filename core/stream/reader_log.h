#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/named.h"
#include "core/base/time.h"

namespace camrig::stream {

/// What faults let a camera's readers meet.
enum class ReaderEventKind : std::uint8_t {
    closed,      ///< from now on who comes to this output is refused, or finds no device
    open,        ///< from now on not any more: its server or device is there again
    refused,     ///< somebody came and was refused
    thrown_out,  ///< a reader was
    good,        ///< a reader was given a frame without faults: its first, or the first after one that had some
};
std::span<const Named<ReaderEventKind>> names_of(std::type_identity<ReaderEventKind>);

struct ReaderEvent {
    std::uint64_t number = 0;  ///< counts from 1
    ReaderEventKind kind = ReaderEventKind::closed;
    std::string camera = {};
    std::string output = {};               ///< its kind: "mjpeg", "rtsp", "device", "v4l2"
    std::string peer = {};                 ///< who; empty: nobody in particular
    TimeNs world_ns = 0;                   ///< of the frame, else of the newest instant
    TimeNs monotonic_ns = 0, real_ns = 0;  ///< when it happened: CLOCK_MONOTONIC, CLOCK_REALTIME
};

/// The newest of these events of a rig, by which the time is measured that its readers take to come back. Any thread.
class ReaderLog {
public:
    static constexpr std::size_t max_events = 4096;
    struct Since {
        std::vector<ReaderEvent> events;
        std::uint64_t last = 0;    ///< number of the newest of all
        std::uint64_t missed = 0;  ///< behind the number asked for, so many (of all cameras) are not kept any more
    };

    void begin_instant(TimeNs world_ns) { newest_ns_.store(world_ns, std::memory_order_relaxed); }
    /// Its number, and times that are 0, are the log's to give.
    void add(ReaderEvent event);
    /// Those with a higher number, of one camera or (empty) of all.
    Since since(std::uint64_t number, std::string_view camera) const;

private:
    std::atomic<TimeNs> newest_ns_{0};
    mutable std::mutex mutex_;
    std::deque<ReaderEvent> events_;
    std::uint64_t last_ = 0;
};

}  // namespace camrig::stream
