#pragma once

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

    static Result<std::unique_ptr<StreamChannel>> open(ServerState& state, AsyncEventRef event,
                                                       const std::string& camera, const stream::MediaFormat& format,
                                                       const std::optional<Rate>& rate, const std::string& peer);
    ~StreamChannel();
    StreamChannel(const StreamChannel&) = delete;
    StreamChannel& operator=(const StreamChannel&) = delete;

    /// Fetches the latest due frame, unless a fetch is under way.
    void fetch();
    /// The next picture that the client has not seen; nullopt: none yet, the event is set when there is one.
    std::optional<Picture> next();
    /// The picture was sent, or sending it failed; counts it accordingly.
    void sent(Picture&& picture, bool failed);
    /// The camera was deleted or has another size: once next() is empty, nothing more comes.
    bool ended() const { return sink_->ended(); }
    bool is_held_back() const { return sink_->is_held_back(); }
    bool is_reset() const { return sink_->is_reset(); }
    bool has_picture() const { return last_sequence_.has_value(); }
    const std::string& camera() const { return camera_; }
    const stream::MediaFormat& format() const { return share_.format(); }

private:
    StreamChannel(ServerState& state, AsyncEventRef event, std::string camera, EncodingShare share);

    ServerState& state_;
    const AsyncEventRef event_;
    const std::string camera_;
    const EncodingShare share_;
    std::shared_ptr<MjpegSink> sink_;
    stream::Subscription subscription_;
    std::shared_ptr<LatestSlot<Result<stream::MediaUnit>>> fetched_;  ///< null: no fetch under way
    std::optional<std::int64_t> last_sequence_;                       ///< what the client has
};

}  // namespace camrig::http
