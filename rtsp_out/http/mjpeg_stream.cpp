#include "rtsp_out/http/mjpeg_stream.h"

#include <spdlog/spdlog.h>

namespace camrig {

namespace asio = boost::asio;
namespace beast = boost::beast;

namespace {

constexpr std::string_view boundary_line = "--frame\r\n";
constexpr std::string_view after_picture = "\r\n--frame\r\n";
/// The boundary line of a next part is out already: an empty part, then the end.
constexpr std::string_view closing = "\r\n--frame--\r\n";

std::string part_head(const MediaUnit& unit) {
    // Header lines stay below 128 bytes and Content-Type has no parameters: limits of ffmpeg's mpjpeg reader.
    std::string head = "Content-Type: image/jpeg\r\nContent-Length: " + std::to_string(unit.bytes->size()) + "\r\n";
    for (const auto& [name, value] : frame_fields(unit.info))
        head.append(name).append(": ").append(value).append("\r\n");
    return head + "\r\n";
}

}  // namespace

MjpegStream::MjpegStream(ServerState& state, std::shared_ptr<Doorbell> bell, std::string camera, int quality)
    : state_(state), bell_(std::move(bell)), camera_(std::move(camera)), quality_(quality) {
    ++state_.streams_by_quality[camera_][quality_];
    ++state_.counts.streams_open;
}

MjpegStream::~MjpegStream() {
    if (sink_) sink_->abandon();
    subscription_.reset();
    --state_.counts.streams_open;
    auto& qualities = state_.streams_by_quality[camera_];
    if (--qualities[quality_] == 0) qualities.erase(quality_);
    if (qualities.empty()) state_.streams_by_quality.erase(camera_);
}

Result<std::unique_ptr<MjpegStream>> MjpegStream::open(ServerState& state, std::shared_ptr<Doorbell> bell,
                                                       const std::string& camera, const StreamParams& params,
                                                       const std::string& peer) {
    const auto open_now = state.streams_by_quality.find(camera);
    if (open_now != state.streams_by_quality.end() && !open_now->second.contains(params.quality) &&
        open_now->second.size() >= state.options.limits.qualities_per_camera) {
        std::string in_use;
        for (const auto& [quality, streams] : open_now->second)
            in_use += (in_use.empty() ? "" : ", ") + std::to_string(quality);
        return error(ErrorKind::resource_exhausted,
                     "camera " + camera + " is streamed in as many qualities as allowed; use one of " + in_use);
    }
    std::unique_ptr<MjpegStream> stream(new MjpegStream(state, bell, camera, params.quality));
    stream->sink_ = std::make_shared<MjpegSink>(bell, camera, peer);
    MediaFormat format;
    format.codec = Codec::jpeg;
    format.quality = params.quality;
    SubscribeOptions options{"mjpeg", peer, params.rate};
    // The sink is closed before on_end is called, and that says all the stream needs.
    auto subscription = state.options.bus->subscribe(camera, format, std::move(options), stream->sink_, {});
    if (!subscription) return std::unexpected(subscription.error());
    stream->subscription_ = std::move(*subscription);
    return stream;
}

Reply MjpegStream::head() {
    Reply reply;
    reply.content_type = "multipart/x-mixed-replace; boundary=frame";
    reply.fields = {{"Cache-Control", "no-store"}, {"X-Accel-Buffering", "no"}};
    reply.endless = true;
    reply.close = true;
    return reply;
}

asio::awaitable<void> MjpegStream::run(beast::tcp_stream& socket, unsigned http_version) {
    const std::string opening = head_of(head(), http_version, false) + std::string(boundary_line);
    start_fetch();
    repeat_at_ = Clock::now() + state_.options.limits.repeat_after;
    SendPieces pieces{asio::buffer(opening)};
    Failure failed = co_await send_all(socket, pieces, state_.options.limits.stalled_after);
    bool ended = false;
    while (!failed && !ended) failed = co_await send_next(socket, ended);
    if (failed == beast::error::timeout) {
        ++state_.counts.stalled;
        spdlog::info("camera {}: an MJPEG reader took nothing for {} ms and is closed", camera_,
                     state_.options.limits.stalled_after.count());
    }
}

/// One turn: sends what there is, or waits for something to send.
asio::awaitable<MjpegStream::Failure> MjpegStream::send_next(beast::tcp_stream& socket, bool& ended) {
    if (auto item = sink_->take()) co_return co_await send_unit(socket, std::move(*item));
    if (fetched_) {
        if (auto fetched = fetched_->take()) {
            fetched_.reset();
            co_return co_await send_fetched(socket, std::move(*fetched));
        }
    }
    if (sink_->ended()) {
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

asio::awaitable<MjpegStream::Failure> MjpegStream::send_unit(beast::tcp_stream& socket, MjpegSink::InFlight item) {
    if (last_ && item.unit.info.sequence <= last_->info.sequence) {
        // The fetched picture was this frame (the client has it: delivered) or a later one (it missed this: dropped).
        if (item.unit.info.sequence == last_->info.sequence) {
            sink_->sent(std::move(item), 0);
        } else {
            sink_->dropped(std::move(item));
        }
        co_return Failure{};
    }
    const MediaUnit unit = item.unit;
    const Failure failed = co_await send_part(socket, unit);
    if (failed) {
        sink_->dropped(std::move(item));
    } else {
        sink_->sent(std::move(item), unit.bytes->size());
    }
    co_return failed;
}

asio::awaitable<MjpegStream::Failure> MjpegStream::send_fetched(beast::tcp_stream& socket, Result<MediaUnit> fetched) {
    if (!fetched) {
        // The subscription tells when the camera is gone; anything else is tried again when it is time to repeat.
        spdlog::debug("camera {}: no first picture for an MJPEG reader: {}", camera_, fetched.error().message);
        co_return Failure{};
    }
    if (last_ && fetched->info.sequence <= last_->info.sequence) co_return Failure{};
    ++state_.counts.first_parts;
    co_return co_await send_part(socket, *fetched);
}

asio::awaitable<MjpegStream::Failure> MjpegStream::repeat(beast::tcp_stream& socket) {
    repeat_at_ = Clock::now() + state_.options.limits.repeat_after;
    if (!last_) {
        if (!fetched_) start_fetch();
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

void MjpegStream::start_fetch() {
    const auto ticket = FetchTicket::begin(state_);
    if (!ticket) return;
    FetchRequest request;
    request.camera = camera_;
    request.format.codec = Codec::jpeg;
    request.format.quality = quality_;
    fetched_ = std::make_shared<Later<Result<MediaUnit>>>(bell_);
    state_.options.fetcher->fetch(std::move(request),
                                  [later = fetched_, ticket](Result<MediaUnit> unit) { later->set(std::move(unit)); });
}

}  // namespace camrig
