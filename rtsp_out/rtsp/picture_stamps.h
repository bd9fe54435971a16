#pragma once

#include <optional>

#include "core/base/time.h"

namespace camrig::rtsp {

/// The stamps of one stream's pictures, CLOCK_MONOTONIC, and when its last picture is to be sent again.
///
/// A picture is stamped with its instant; stamps strictly rise. When nothing new comes for a second the last picture is
/// sent again, for a new client ten times a second, so that clients open at once and stay while the world stands still.
/// That is stamped in the past, by more than the last picture was late, so that the next one still comes after it with
/// its own instant; one that does not is left out, for a client that pairs streams by time would take it for another.
///
/// Plain arithmetic, reads no clock. One thread at a time.
class PictureStamps {
public:
    /// No stamp is before `base_ns`.
    explicit PictureStamps(TimeNs base_ns) : base_ns_(base_ns) {}

    /// Of the picture that the stream begins with: its instant, or if that is before the base, a repeat's.
    TimeNs of_first(TimeNs instant_ns, TimeNs now_ns);
    /// Of a new picture that comes now; nothing: leave it out. With `must_be_sent` (lockstep) it has the next tick.
    std::optional<TimeNs> of_new(TimeNs instant_ns, TimeNs now_ns, bool must_be_sent);
    /// Of the last picture, if it is to be sent again now.
    std::optional<TimeNs> of_repeat(TimeNs now_ns);
    /// The same for a client that has just come, if it would have to wait for its first picture.
    std::optional<TimeNs> of_join(TimeNs now_ns);

private:
    TimeNs take(TimeNs stamp_ns, TimeNs now_ns);
    TimeNs repeated(TimeNs now_ns);

    const TimeNs base_ns_;
    bool is_repeat_ = false;   ///< the last stamp was made up
    TimeNs lag_ns_ = 0;        ///< of a repeat behind now
    TimeNs last_ns_ = 0;       ///< the last stamp
    TimeNs last_sent_ns_ = 0;  ///< when it was given; 0: none was
    TimeNs last_new_ns_ = 0;   ///< when a picture came that was not sent before
    TimeNs joined_ns_ = 0;     ///< when the last client came
};

}  // namespace camrig::rtsp
