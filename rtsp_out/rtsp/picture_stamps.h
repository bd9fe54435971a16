#pragma once

#include <optional>

#include "core/base/rate.h"
#include "core/base/time.h"

namespace camrig::rtsp {

/// The timestamps of one stream's pictures, in CLOCK_MONOTONIC, and when its last picture is to be sent again.
///
/// A picture's timestamp is its instant; timestamps strictly increase. When nothing new comes for a second (two periods
/// of a slow stream) the last picture is sent again, for a new client ten times a second, so that clients open at once
/// and do not time out while the world stands still. A repeat's timestamp lies in the past, by more than the last
/// picture was late, so that the next picture can have its own instant. If it still cannot, it is left out: with
/// another timestamp, a client that pairs the pictures of streams by time would pair it wrongly.
///
/// Plain arithmetic, reads no clock. One thread at a time.
class PictureStamps {
public:
    /// No stamp is before `base_ns`; `rate`: of the stream.
    PictureStamps(TimeNs base_ns, const Rate& rate) : base_ns_(base_ns), rate_(rate) {}

    /// For the stream's first picture: its instant, or a repeat's timestamp if the instant is before base_ns.
    TimeNs of_first(TimeNs instant_ns, TimeNs now_ns);
    /// For a new picture that comes now; nullopt: leave it out. With `must_be_sent` (lockstep) it gets the next
    /// possible timestamp in that case.
    std::optional<TimeNs> of_new(TimeNs instant_ns, TimeNs now_ns, bool must_be_sent);
    /// For the last picture, if it is to be sent again now.
    std::optional<TimeNs> of_repeat(TimeNs now_ns);
    /// The same when a client joins: for the last picture, if the client would have to wait for its first one.
    std::optional<TimeNs> of_join(TimeNs now_ns);

private:
    TimeNs take(TimeNs stamp_ns, TimeNs now_ns);
    TimeNs repeated(TimeNs now_ns);

    const TimeNs base_ns_;
    const Rate rate_;
    bool is_repeat_ = false;   ///< the last stamp was made up
    TimeNs late_ns_ = 0;       ///< how long after its instant the last new picture came
    TimeNs last_ns_ = 0;       ///< the last stamp
    TimeNs last_sent_ns_ = 0;  ///< when it was given; 0: none was
    TimeNs last_new_ns_ = 0;   ///< when a picture came that was not sent before
    TimeNs joined_ns_ = 0;     ///< when the last client came
};

}  // namespace camrig::rtsp
