#include "rtsp_out/rtsp/picture_stamps.h"

#include <algorithm>

#include "core/stream/silence.h"
#include "rtsp_out/rtsp/rtp_timeline.h"

namespace camrig::rtsp {
namespace {

/// Two pictures never share a tick of the RTP clock.
constexpr TimeNs min_step_ns = ns_per_s / RtpTimeline::ticks_per_s + 1;
/// When the last picture is sent again: nothing new came for so long, or for two periods of a slow stream.
constexpr TimeNs repeat_after_ns = ns_per_s;
/// Programs on ffmpeg's libraries open a stream only when they have seen some 20 pictures.
constexpr TimeNs opening_ns = 5 * ns_per_s;
constexpr TimeNs opening_repeat_ns = 90 * ns_per_ms;

}  // namespace

TimeNs PictureStamps::of_first(TimeNs instant_ns, TimeNs now_ns) {
    last_new_ns_ = now_ns;
    return instant_ns < base_ns_ ? repeated(now_ns) : take(instant_ns, now_ns);
}

std::optional<TimeNs> PictureStamps::of_new(TimeNs instant_ns, TimeNs now_ns, bool must_be_sent) {
    last_new_ns_ = now_ns;
    late_ns_ = now_ns - instant_ns;
    if (is_repeat_ && instant_ns < last_ns_ + min_step_ns && !must_be_sent) return std::nullopt;
    is_repeat_ = false;
    return take(instant_ns, now_ns);
}

std::optional<TimeNs> PictureStamps::of_repeat(TimeNs now_ns) {
    const bool is_opening = now_ns - joined_ns_ < opening_ns;
    const TimeNs silence_ns = is_opening ? repeat_after_ns : stream::silence_ns(rate_, repeat_after_ns);
    if (last_sent_ns_ == 0 || now_ns - last_new_ns_ < silence_ns) return std::nullopt;
    if (now_ns - last_sent_ns_ < (is_opening ? opening_repeat_ns : silence_ns)) return std::nullopt;
    return repeated(now_ns);
}

std::optional<TimeNs> PictureStamps::of_join(TimeNs now_ns) {
    joined_ns_ = now_ns;
    if (last_sent_ns_ == 0 || now_ns - last_sent_ns_ < stream::least_repeat_age_ns) return std::nullopt;
    return repeated(now_ns);
}

TimeNs PictureStamps::repeated(TimeNs now_ns) {
    is_repeat_ = true;
    return take(now_ns - stream::repeat_age_ns(late_ns_), now_ns);
}

TimeNs PictureStamps::take(TimeNs stamp_ns, TimeNs now_ns) {
    last_sent_ns_ = now_ns;
    return last_ns_ = std::max({stamp_ns, base_ns_, last_ns_ + min_step_ns});
}

}  // namespace camrig::rtsp
