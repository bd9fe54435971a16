#pragma once

#include <memory>
#include <string>
#include <vector>

#include "rtsp_out/http/reply.h"
#include "rtsp_out/http/route.h"
#include "rtsp_out/http/send.h"
#include "rtsp_out/http/stream_channel.h"

namespace camrig {

/// Several cameras' pictures for one client on one connection: what the web page's grid reads, because browsers open
/// only six connections to a host. Each part says by X-Camera whose picture it is.
///
/// Cameras take turns, each with its newest picture, so a slow client sees all of them at a lower rate. The stream ends
/// when one of its cameras is deleted or changes its size; the client asks again. When nothing happens for
/// HttpLimits::repeat_after, an empty part without X-Camera shows that the stream lives. Lives on the server's thread.
class LiveStream {
public:
    static Result<std::unique_ptr<LiveStream>> open(ServerState& state, std::shared_ptr<Doorbell> bell,
                                                    const LiveParams& params, const std::string& peer);
    ~LiveStream() { --state_.counts.streams_open; }
    LiveStream(const LiveStream&) = delete;
    LiveStream& operator=(const LiveStream&) = delete;

    /// The head of the answer, also for HEAD.
    static Reply head();
    /// Sends until the client or one of the cameras goes.
    boost::asio::awaitable<void> run(boost::beast::tcp_stream& socket, unsigned http_version, bool embeddable);

private:
    using Failure = boost::beast::error_code;

    LiveStream(ServerState& state, std::shared_ptr<Doorbell> bell) : state_(state), bell_(std::move(bell)) {
        ++state_.counts.streams_open;
    }
    boost::asio::awaitable<Failure> send_text(boost::beast::tcp_stream& socket, std::string_view text);
    /// One picture of each camera that has one; `ended` when a camera has none and never will.
    boost::asio::awaitable<Failure> send_round(boost::beast::tcp_stream& socket, int& sent, bool& ended);
    boost::asio::awaitable<Failure> wait(boost::beast::tcp_stream& socket);

    ServerState& state_;
    const std::shared_ptr<Doorbell> bell_;
    std::vector<std::unique_ptr<StreamChannel>> channels_;
};

}  // namespace camrig
