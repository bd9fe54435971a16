#pragma once

#include <cstdint>

#include "core/base/time.h"

namespace camrig::rtsp {

/// By how much the simulated clocks of a stream's camera are wrong now (shown minus true time).
struct StreamClock {
    TimeNs rtp_error_ns = 0;  ///< of the clock that counts RTP timestamps
    TimeNs ntp_error_ns = 0;  ///< of the wall clock in sender reports
};

/// The RTP and NTP timestamps of one stream (RFC 3550, 5.1 and 6.4.1).
///
/// RTP timestamps of all streams of the machine count on one grid: tick k is at CLOCK_MONOTONIC k / 90000 s, for
/// base_ns is a whole second. An instant has the timestamp of the last tick before it. A sender report pairs a tick
/// with its exact absolute time, so capture times that clients compute from RTP timestamps and reports of several
/// streams agree to the nanosecond. Plain arithmetic, reads no clock.
class RtpTimeline {
public:
    static constexpr std::int64_t ticks_per_s = 90'000;

    /// A stream that begins at now_ns; rtp_offset is the random start of its RTP timestamps (RFC 3550, 5.1).
    RtpTimeline(TimeNs now_ns, std::uint32_t rtp_offset, TimeNs wall_offset_ns);

    std::uint32_t rtp_offset() const { return rtp_offset_; }
    /// The CLOCK_MONOTONIC time of stream time (PTS) 0: before everything that the stream will show.
    TimeNs base_ns() const { return base_ns_; }
    TimeNs pts_of(TimeNs monotonic_ns) const { return monotonic_ns - base_ns_; }
    TimeNs realtime_of(TimeNs monotonic_ns) const { return monotonic_ns + wall_offset_ns_; }

    struct SenderTime {
        std::uint64_t ntp = 0;  ///< seconds since 1900, 32.32 fixed point
        std::uint32_t rtp = 0;
    };
    /// The last tick of the camera's clock at now_ns, as RTP time and as that clock's absolute time.
    SenderTime sender_time(TimeNs now_ns, const StreamClock& clock = {}) const;

private:
    std::int64_t ticks_at(TimeNs monotonic_ns) const;

    TimeNs base_ns_;
    std::uint32_t rtp_offset_;
    TimeNs wall_offset_ns_;
};

/// Nanoseconds since 1970 as NTP time, to the nearest 2^-32 s. Of any time: NTP's 32 bits of seconds begin again in
/// 2036 (RFC 5905, 6).
std::uint64_t ntp_from_realtime(TimeNs realtime_ns);

}  // namespace camrig::rtsp
