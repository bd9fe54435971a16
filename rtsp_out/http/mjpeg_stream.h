#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "rtsp_out/http/reply.h"
#include "rtsp_out/http/route.h"
#include "rtsp_out/http/send.h"
#include "rtsp_out/http/stream_channel.h"

namespace camrig {

/// One client's MJPEG stream of one camera (multipart/x-mixed-replace; multipart.h says in which form).
///
/// The first part is the camera's latest due frame, so that a reader opens even when the world stands still; and
/// without a new picture for HttpLimits::repeat_after the last one is repeated, so that its time limits do not end it.
/// Lives on the server's thread.
class MjpegStream {
public:
    static Result<std::unique_ptr<MjpegStream>> open(ServerState& state, std::shared_ptr<Doorbell> bell,
                                                     const std::string& camera, const StreamParams& params,
                                                     const std::string& peer);
    ~MjpegStream() { --state_.counts.streams_open; }
    MjpegStream(const MjpegStream&) = delete;
    MjpegStream& operator=(const MjpegStream&) = delete;

    /// The head of the answer, also for HEAD.
    static Reply head();
    /// Sends until the client or the camera goes.
    boost::asio::awaitable<void> run(boost::beast::tcp_stream& socket, unsigned http_version, bool embeddable);

private:
    MjpegStream(ServerState& state, std::shared_ptr<Doorbell> bell, std::unique_ptr<StreamChannel> channel)
        : state_(state), bell_(std::move(bell)), channel_(std::move(channel)) {
        ++state_.counts.streams_open;
    }

    using Clock = std::chrono::steady_clock;
    using Failure = boost::beast::error_code;

    boost::asio::awaitable<Failure> repeat(boost::beast::tcp_stream& socket);
    boost::asio::awaitable<Failure> send_part(boost::beast::tcp_stream& socket, const MediaUnit& unit);
    boost::asio::awaitable<Failure> send_next(boost::beast::tcp_stream& socket, bool& ended);

    ServerState& state_;
    const std::shared_ptr<Doorbell> bell_;
    const std::unique_ptr<StreamChannel> channel_;
    std::optional<MediaUnit> last_;  ///< what the client shows
    Clock::time_point repeat_at_;
};

}  // namespace camrig
