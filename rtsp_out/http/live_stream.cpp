#include "rtsp_out/http/live_stream.h"

#include <algorithm>

#include <spdlog/spdlog.h>

#include "rtsp_out/http/multipart.h"

namespace camrig {

namespace asio = boost::asio;
namespace beast = boost::beast;

namespace {

constexpr std::string_view sign_of_life = "Content-Type: text/plain\r\nContent-Length: 0\r\n\r\n\r\n--frame\r\n";

/// The camera's picture at `width`, in its own proportions; never larger than it is.
ImageSize scaled_to(const ImageSize& own, int width) {
    if (width == 0 || width >= own.width) return {};
    const std::int64_t height = (std::int64_t{own.height} * width + own.width / 2) / own.width;
    return {width, static_cast<int>(std::clamp<std::int64_t>(height, min_image_size.height, max_image_size.height))};
}

}  // namespace

Result<std::unique_ptr<LiveStream>> LiveStream::open(ServerState& state, std::shared_ptr<Doorbell> bell,
                                                     const LiveParams& params, const std::string& peer) {
    std::unique_ptr<LiveStream> stream(new LiveStream(state, bell));
    for (const std::string& name : params.cameras) {
        const auto camera = state.options.bus->find(name);
        if (!camera) return std::unexpected(camera.error());
        MediaFormat format;
        format.codec = Codec::jpeg;
        format.quality = params.quality;
        format.size = scaled_to(camera->size, params.width);
        auto channel = StreamChannel::open(state, bell, name, format, params.rate, peer);
        if (!channel) return std::unexpected(channel.error());
        stream->channels_.push_back(std::move(*channel));
    }
    return stream;
}

Reply LiveStream::head() {
    Reply reply;
    reply.content_type = "multipart/mixed; boundary=frame";
    reply.fields = {{"Cache-Control", "no-store"}, {"X-Accel-Buffering", "no"}};
    reply.endless = true;
    reply.close = true;
    return reply;
}

asio::awaitable<void> LiveStream::run(beast::tcp_stream& socket, unsigned http_version, bool embeddable) {
    Reply opening_head = head();
    opening_head.embeddable = embeddable;
    for (const auto& channel : channels_) channel->fetch();
    Failure failed =
        co_await send_text(socket, head_of(opening_head, http_version, false) + std::string(boundary_line));
    bool ended = false;
    while (!failed && !ended) {
        int sent = 0;
        failed = co_await send_round(socket, sent, ended);
        if (!failed && ended) failed = co_await send_text(socket, closing);
        if (!failed && !ended && sent == 0) failed = co_await wait(socket);
    }
    if (failed == beast::error::timeout) {
        ++state_.counts.stalled;
        spdlog::info("a reader of {} cameras took nothing for {} ms and is closed", channels_.size(),
                     state_.options.limits.stalled_after.count());
    }
}

asio::awaitable<LiveStream::Failure> LiveStream::send_text(beast::tcp_stream& socket, std::string_view text) {
    const std::string kept(text);
    SendPieces pieces{asio::buffer(kept)};
    co_return co_await send_all(socket, pieces, state_.options.limits.stalled_after);
}

asio::awaitable<LiveStream::Failure> LiveStream::send_round(beast::tcp_stream& socket, int& sent, bool& ended) {
    for (const auto& channel : channels_) {
        auto picture = channel->next();
        if (!picture) {
            ended = ended || channel->ended();
            continue;
        }
        const std::string head = part_head(picture->unit, channel->camera());
        SendPieces pieces{asio::buffer(head), asio::buffer(picture->unit.bytes->data(), picture->unit.bytes->size()),
                          asio::buffer(after_picture)};
        const Failure failed = co_await send_all(socket, pieces, state_.options.limits.stalled_after);
        channel->sent(std::move(*picture), static_cast<bool>(failed));
        if (failed) co_return failed;
        ++sent;
    }
    co_return Failure{};
}

asio::awaitable<LiveStream::Failure> LiveStream::wait(beast::tcp_stream& socket) {
    const Wake wake = co_await bell_->wait_for(state_.options.limits.repeat_after);
    if (wake == Wake::disconnected) co_return asio::error::operation_aborted;
    if (wake == Wake::rung) co_return Failure{};
    // A first picture that failed is asked for again.
    for (const auto& channel : channels_)
        if (!channel->has_picture()) channel->fetch();
    co_return co_await send_text(socket, sign_of_life);
}

}  // namespace camrig
