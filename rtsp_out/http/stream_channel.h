#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "core/stream/frame_bus.h"
#include "rtsp_out/http/encoding_share.h"
#include "rtsp_out/http/mjpeg_sink.h"
#include "rtsp_out/http/server_state.h"

namespace camrig::http {

/// One camera's pictures for one client: those of its subscription to the bus, and before them the camera's latest due
/// frame, fetched, so that a client has a picture even when the world stands still. No picture is given twice, none out
/// of order. Lives on the server's thread. Destroying it ends the subscription.
class StreamChannel {
public:
    /// A picture to send; must be handed back to sent().
    struct Picture {
        stream::MediaUnit unit;
        std::optional<MjpegSink::InFlight> item;  ///< absent: it was fetched
    };

    /// Not subscribed yet.
    static Result<std::unique_ptr<StreamChannel>> create(ServerState& state, AsyncEventRef event,
                                                         const stream::CameraStream& camera,
                                                         const stream::MediaFormat& format,
                                                         const std::optional<Rate>& rate, const std::string& peer);
    ~StreamChannel();
    StreamChannel(const StreamChannel&) = delete;
    StreamChannel& operator=(const StreamChannel&) = delete;

    Result<void> subscribe();
    /// For one that has ended: subscribes again, HttpLimits::reopen_after later and as often, if the camera is the same
    /// as before and a fault of it was the end; not while it refuses. False: it was deleted or has another size.
    bool reopen();
    /// When it subscribes again at the earliest, if it has ended and reopen() was asked.
    std::optional<std::chrono::steady_clock::time_point> reopen_at() const { return reopen_at_; }
    /// Fetches the latest due frame, unless a fetch is under way, or the camera lets nobody in.
    void fetch();
    /// The next picture that the client has not seen; nullopt: none yet, the event is set when there is one.
    std::optional<Picture> next();
    /// The picture was sent, or sending it failed; counts it accordingly.
    void sent(Picture&& picture, bool failed);
    /// There is no subscription, or it is over: the camera was deleted, has another size or throws readers out. Once
    /// next() is empty, nothing more comes.
    bool ended() const { return !sink_ || sink_->ended(); }
    bool is_held_back() const { return sink_->is_held_back(); }
    bool is_reset() const { return sink_->is_reset(); }
    bool has_picture() const { return last_sequence_.has_value(); }
    const std::string& camera() const { return camera_.name; }
    const stream::MediaFormat& format() const { return share_.format(); }

private:
    StreamChannel(ServerState& state, AsyncEventRef event, stream::CameraStream camera, EncodingShare share,
                  const std::optional<Rate>& rate, std::string peer);

    ServerState& state_;
    const AsyncEventRef event_;
    const stream::CameraStream camera_;  ///< as it was at first
    const EncodingShare share_;
    const std::optional<Rate> rate_;
    const std::string peer_;
    std::shared_ptr<MjpegSink> sink_;  ///< null: not subscribed yet
    stream::Subscription subscription_;
    std::shared_ptr<LatestSlot<Result<stream::MediaUnit>>> fetched_;  ///< null: no fetch under way
    std::optional<std::int64_t> last_sequence_;                       ///< what the client has
    std::optional<std::chrono::steady_clock::time_point> reopen_at_;  ///< absent: not asked since subscribe()
};

}  // namespace camrig::http
