#include "rtsp_out/rtsp/rtp_timeline.h"

namespace camrig::rtsp {
namespace {

constexpr std::int64_t ntp_seconds_at_1970 = 2'208'988'800;
/// Stream time 0 lies so far before the first picture, which may be some frames old.
constexpr TimeNs lead_ns = 2 * ns_per_s;

}  // namespace

RtpTimeline::RtpTimeline(TimeNs now_ns, std::uint32_t rtp_offset, TimeNs wall_offset_ns)
    : base_ns_((now_ns - lead_ns) / ns_per_s * ns_per_s), rtp_offset_(rtp_offset), wall_offset_ns_(wall_offset_ns) {}

std::int64_t RtpTimeline::ticks_at(TimeNs monotonic_ns) const {
    // 90000 / 1e9 = 9 / 100000: no overflow for thousands of years. Times before the base have no stamps.
    return pts_of(monotonic_ns) * 9 / 100'000;
}

RtpTimeline::SenderTime RtpTimeline::sender_time(TimeNs now_ns, const StreamClock& clock) const {
    const std::int64_t ticks = ticks_at(now_ns + clock.rtp_error_ns);
    const TimeNs tick_ns = base_ns_ + (ticks * 100'000 + 4) / 9;
    return {ntp_from_realtime(realtime_of(tick_ns) + clock.ntp_error_ns - clock.rtp_error_ns),
            rtp_offset_ + static_cast<std::uint32_t>(ticks)};
}

std::uint64_t ntp_from_realtime(TimeNs realtime_ns) {
    const TimeNs before_1970 = realtime_ns % ns_per_s < 0 ? 1 : 0;
    const auto seconds = static_cast<std::uint64_t>(realtime_ns / ns_per_s - before_1970 + ntp_seconds_at_1970);
    const auto rest = static_cast<std::uint64_t>(realtime_ns % ns_per_s + before_1970 * ns_per_s);
    return (seconds << 32) + ((rest << 32) + ns_per_s / 2) / ns_per_s;
}

}  // namespace camrig::rtsp
