#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "core/stream/frame_bus.h"
#include "rtsp_out/http/mjpeg_sink.h"
#include "rtsp_out/http/reply.h"
#include "rtsp_out/http/route.h"
#include "rtsp_out/http/send.h"
#include "rtsp_out/http/server_state.h"

namespace camrig {

/// One client's MJPEG stream (multipart/x-mixed-replace), in the form that stock readers take: ffmpeg and OpenCV want
/// the body to begin with a boundary line and a Content-Type of exactly "image/jpeg"; Chrome shows a picture only when
/// the next boundary line has come (crbug 527446), so that line follows each picture at once.
///
/// The first part is the camera's latest due frame, fetched, so that a reader opens even when the world stands still;
/// and without a new picture for HttpLimits::repeat_after the last one is repeated, so that its time limits do not end
/// it. Lives on the server's thread; everything of the client's is gone when it is destroyed.
class MjpegStream {
public:
    static Result<std::unique_ptr<MjpegStream>> open(ServerState& state, std::shared_ptr<Doorbell> bell,
                                                     const std::string& camera, const StreamParams& params,
                                                     const std::string& peer);
    ~MjpegStream();
    MjpegStream(const MjpegStream&) = delete;
    MjpegStream& operator=(const MjpegStream&) = delete;

    /// The head of the answer, also for HEAD.
    static Reply head();
    /// Sends until the client or the camera goes.
    boost::asio::awaitable<void> run(boost::beast::tcp_stream& socket, unsigned http_version);

private:
    MjpegStream(ServerState& state, std::shared_ptr<Doorbell> bell, std::string camera, int quality);

    using Clock = std::chrono::steady_clock;
    using Failure = boost::beast::error_code;

    void start_fetch();
    boost::asio::awaitable<Failure> send_unit(boost::beast::tcp_stream& socket, MjpegSink::InFlight item);
    boost::asio::awaitable<Failure> send_fetched(boost::beast::tcp_stream& socket, Result<MediaUnit> fetched);
    boost::asio::awaitable<Failure> repeat(boost::beast::tcp_stream& socket);
    boost::asio::awaitable<Failure> send_part(boost::beast::tcp_stream& socket, const MediaUnit& unit);
    boost::asio::awaitable<Failure> send_next(boost::beast::tcp_stream& socket, bool& ended);

    ServerState& state_;
    const std::shared_ptr<Doorbell> bell_;
    const std::string camera_;
    const int quality_;
    std::shared_ptr<MjpegSink> sink_;
    Subscription subscription_;
    std::shared_ptr<Later<Result<MediaUnit>>> fetched_;  ///< null: no fetch under way
    std::optional<MediaUnit> last_;                      ///< what the client shows
    Clock::time_point repeat_at_;
};

}  // namespace camrig
