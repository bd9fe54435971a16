#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rtsp_out/http/reply.h"
#include "rtsp_out/http/route.h"
#include "rtsp_out/http/send.h"
#include "rtsp_out/http/stream_channel.h"

namespace camrig::http {

/// Pictures of cameras for one client on one connection, as the parts of one answer (multipart.h says in which form).
///
/// The first part of a camera is its latest due frame, so that a reader opens even when the world stands still. Of
/// several cameras each takes its turn with its newest picture, so a slow client sees all of them at a lower rate. The
/// stream ends when a camera is deleted or changes its size; the client asks again. A fault of the camera ends one of
/// MJPEG too; of several cameras the others go on, and it comes back when it lets readers in. Lives on the server's
/// thread.
class PictureStream {
public:
    enum class Form : std::uint8_t {
        /// Of one camera, for all who read MJPEG (multipart/x-mixed-replace). Without a new picture for
        /// HttpLimits::repeat_after the last one is repeated, so that time limits of the reader do not end it.
        mjpeg,
        /// Of several cameras, for the web page's grid (multipart/mixed), because browsers open only six connections to
        /// a host. Each part says by X-Camera whose it is; an empty one without it shows that the stream lives.
        live,
    };

    /// The camera, if it lets readers of MJPEG in.
    static Result<stream::CameraStream> find_open(stream::FrameBus& bus, const std::string& camera,
                                                  const std::string& peer);
    static Result<std::unique_ptr<PictureStream>> open_mjpeg(ServerState& state, AsyncEventRef event,
                                                             const std::string& camera, const StreamParams& params,
                                                             const std::string& peer);
    static Result<std::unique_ptr<PictureStream>> open_live(ServerState& state, AsyncEventRef event,
                                                            const LiveParams& params, const std::string& peer);
    ~PictureStream() { --state_.counts.streams_open; }
    PictureStream(const PictureStream&) = delete;
    PictureStream& operator=(const PictureStream&) = delete;

    /// The head of the answer, also for HEAD.
    static Reply head(Form form);
    /// Sends until the client disconnects or the stream ends (see above).
    boost::asio::awaitable<void> run(boost::beast::tcp_stream& socket, unsigned http_version, bool embeddable);

private:
    using Clock = std::chrono::steady_clock;
    using Failure = boost::beast::error_code;

    PictureStream(ServerState& state, AsyncEventRef event, Form form, const std::optional<Rate>& rate, std::string peer)
        : state_(state), event_(std::move(event)), form_(form), rate_(rate), peer_(std::move(peer)) {
        ++state_.counts.streams_open;
    }
    /// One more channel, not subscribed yet.
    Result<StreamChannel*> add(const stream::CameraStream& camera, const stream::MediaFormat& format);
    /// Whether a channel that has ended will have no pictures any more.
    bool is_over(StreamChannel& channel) const { return form_ == Form::mjpeg || !channel.reopen(); }
    /// Goes on in the quality that the camera's output {kind: mjpeg} says now.
    boost::asio::awaitable<Failure> follow_output(boost::beast::tcp_stream& socket);
    boost::asio::awaitable<Failure> send_text(boost::beast::tcp_stream& socket, std::string_view text);
    boost::asio::awaitable<Failure> send_part(boost::beast::tcp_stream& socket, const stream::MediaUnit& unit,
                                              const std::string& camera);
    /// One picture of each camera that has one; `ended` when a camera has none and never will.
    boost::asio::awaitable<Failure> send_round(boost::beast::tcp_stream& socket, int& sent, bool& ended);
    /// Until there may be a picture, or until it is time to ask a camera again or for a sign of life.
    boost::asio::awaitable<Failure> wait(boost::beast::tcp_stream& socket);

    ServerState& state_;
    const AsyncEventRef event_;
    const Form form_;
    const std::optional<Rate> rate_;
    const std::string peer_;
    bool follows_output_ = false;                         ///< mjpeg: the client asked for no quality
    std::uint64_t changes_seen_ = state_.camera_changes;  ///< ServerState::camera_changes
    std::vector<std::unique_ptr<StreamChannel>> channels_;
    std::optional<stream::MediaUnit> last_;  ///< mjpeg: what the client shows
    Clock::time_point repeat_at_;
};

}  // namespace camrig::http
