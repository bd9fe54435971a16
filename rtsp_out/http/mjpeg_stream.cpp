#include "rtsp_out/http/mjpeg_stream.h"

#include <spdlog/spdlog.h>

#include "rtsp_out/http/multipart.h"

namespace camrig {

namespace asio = boost::asio;
namespace beast = boost::beast;

Result<std::unique_ptr<MjpegStream>> MjpegStream::open(ServerState& state, std::shared_ptr<Doorbell> bell,
                                                       const std::string& camera, const StreamParams& params,
                                                       const std::string& peer) {
    MediaFormat format;
    format.codec = Codec::jpeg;
    format.quality = params.quality;
    auto channel = StreamChannel::open(state, bell, camera, format, params.rate, peer);
    if (!channel) return std::unexpected(channel.error());
    return std::unique_ptr<MjpegStream>(new MjpegStream(state, bell, std::move(*channel)));
}

Reply MjpegStream::head() {
    Reply reply;
    reply.content_type = "multipart/x-mixed-replace; boundary=frame";
    reply.fields = {{"Cache-Control", "no-store"}, {"X-Accel-Buffering", "no"}};
    reply.endless = true;
    reply.close = true;
    return reply;
}

asio::awaitable<void> MjpegStream::run(beast::tcp_stream& socket, unsigned http_version, bool embeddable) {
    Reply opening_head = head();
    opening_head.embeddable = embeddable;
    const std::string opening = head_of(opening_head, http_version, false) + std::string(boundary_line);
    channel_->fetch();
    repeat_at_ = Clock::now() + state_.options.limits.repeat_after;
    SendPieces pieces{asio::buffer(opening)};
    Failure failed = co_await send_all(socket, pieces, state_.options.limits.stalled_after);
    bool ended = false;
    while (!failed && !ended) failed = co_await send_next(socket, ended);
    if (failed == beast::error::timeout) {
        ++state_.counts.stalled;
        spdlog::info("camera {}: an MJPEG reader took nothing for {} ms and is closed", channel_->camera(),
                     state_.options.limits.stalled_after.count());
    }
}

/// One turn: sends what there is, or waits for something to send.
asio::awaitable<MjpegStream::Failure> MjpegStream::send_next(beast::tcp_stream& socket, bool& ended) {
    if (auto picture = channel_->next()) {
        const MediaUnit unit = picture->unit;
        const Failure failed = co_await send_part(socket, unit);
        channel_->sent(std::move(*picture), static_cast<bool>(failed));
        co_return failed;
    }
    if (channel_->ended()) {
        ended = true;
        SendPieces pieces{asio::buffer(closing)};
        co_return co_await send_all(socket, pieces, state_.options.limits.stalled_after);
    }
    const auto left = repeat_at_ - Clock::now();
    if (left <= Clock::duration::zero()) co_return co_await repeat(socket);
    const Wake wake = co_await bell_->wait_for(left);
    if (wake == Wake::disconnected) co_return asio::error::operation_aborted;
    co_return Failure{};
}

asio::awaitable<MjpegStream::Failure> MjpegStream::repeat(beast::tcp_stream& socket) {
    repeat_at_ = Clock::now() + state_.options.limits.repeat_after;
    if (!last_) {
        channel_->fetch();
        co_return Failure{};
    }
    ++state_.counts.repeated_parts;
    const MediaUnit again = *last_;
    co_return co_await send_part(socket, again);
}

asio::awaitable<MjpegStream::Failure> MjpegStream::send_part(beast::tcp_stream& socket, const MediaUnit& unit) {
    const std::string head = part_head(unit);
    SendPieces pieces{asio::buffer(head), asio::buffer(unit.bytes->data(), unit.bytes->size()),
                      asio::buffer(after_picture)};
    const Failure failed = co_await send_all(socket, pieces, state_.options.limits.stalled_after);
    if (failed) co_return failed;
    last_ = unit;
    last_->latch.reset();
    repeat_at_ = Clock::now() + state_.options.limits.repeat_after;
    co_return failed;
}

}  // namespace camrig
