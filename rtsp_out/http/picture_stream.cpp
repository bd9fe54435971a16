#include "rtsp_out/http/picture_stream.h"

#include <algorithm>

#include <spdlog/spdlog.h>

#include "core/fault/sending.h"
#include "rtsp_out/http/mjpeg_output.h"
#include "rtsp_out/http/multipart.h"

namespace camrig::http {

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

/// The peer gets RST: nothing that waits is sent, and no end.
void break_off(beast::tcp_stream& socket) {
    beast::error_code ignored;
    socket.socket().set_option(asio::socket_base::linger(true, 0), ignored);
    socket.close();
}

stream::MediaFormat jpeg_of(int quality, ImageSize size = {}) {
    stream::MediaFormat format;
    format.codec = codec::Codec::jpeg;
    format.quality = quality;
    format.size = size;
    return format;
}

}  // namespace

Result<stream::CameraStream> PictureStream::find_open(stream::FrameBus& bus, const std::string& camera,
                                                      const std::string& peer) {
    auto found = bus.find(camera);
    if (!found || !found->standing.refuses("mjpeg")) return found;
    bus.note_refused(camera, "mjpeg", peer);
    return error(ErrorKind::unavailable, "camera " + camera + " refuses connections (a fault)");
}

Result<std::unique_ptr<PictureStream>> PictureStream::open_mjpeg(ServerState& state, AsyncEventRef event,
                                                                 const std::string& camera, const StreamParams& params,
                                                                 const std::string& peer) {
    std::unique_ptr<PictureStream> stream(new PictureStream(state, std::move(event), Form::mjpeg, params.rate, peer));
    stream->follows_output_ = !params.quality;
    const auto found = find_open(*state.options.bus, camera, peer);
    if (!found) return std::unexpected(found.error());
    const int quality = params.quality.value_or(mjpeg_options_of(found->outputs).quality);
    const auto channel = stream->add(*found, jpeg_of(quality));
    if (!channel) return std::unexpected(channel.error());
    if (auto in = (*channel)->subscribe(); !in) return std::unexpected(in.error());
    return stream;
}

Result<std::unique_ptr<PictureStream>> PictureStream::open_live(ServerState& state, AsyncEventRef event,
                                                                const LiveParams& params, const std::string& peer) {
    std::unique_ptr<PictureStream> stream(new PictureStream(state, std::move(event), Form::live, params.rate, peer));
    for (const std::string& name : params.cameras) {
        const auto camera = state.options.bus->find(name);
        if (!camera) return std::unexpected(camera.error());
        const auto channel = stream->add(*camera, jpeg_of(params.quality, scaled_to(camera->size, params.width)));
        if (!channel) return std::unexpected(channel.error());
        if (camera->standing.refuses("mjpeg"))
            state.options.bus->note_refused(name, "mjpeg", peer);
        else if (auto in = (*channel)->subscribe(); !in)
            return std::unexpected(in.error());
    }
    return stream;
}

Result<StreamChannel*> PictureStream::add(const stream::CameraStream& camera, const stream::MediaFormat& format) {
    auto channel = StreamChannel::create(state_, event_, camera, format, rate_, peer_);
    if (!channel) return std::unexpected(channel.error());
    return channels_.emplace_back(std::move(*channel)).get();
}

asio::awaitable<PictureStream::Failure> PictureStream::follow_output(beast::tcp_stream& socket) {
    const std::uint64_t changes = state_.camera_changes;
    if (!follows_output_ || std::exchange(changes_seen_, changes) == changes) co_return Failure{};
    auto& channel = channels_.front();
    const auto found = state_.options.bus->find(channel->camera());
    if (!found) co_return Failure{};  // the channel's end says so
    const stream::MediaFormat format = jpeg_of(mjpeg_options_of(found->outputs).quality);
    if (format == channel->format()) co_return Failure{};
    auto next = StreamChannel::create(state_, event_, *found, format, rate_, peer_);
    const Result<void> in = next ? (*next)->subscribe() : std::unexpected(next.error());
    if (!in) {
        spdlog::info("a reader of {} keeps its quality: {}", channel->camera(), in.error().message);
        co_return Failure{};
    }
    int sent = 0;
    bool ended = false;
    const Failure failed = co_await send_round(socket, sent, ended);  // what the old one has still
    channel = std::move(*next);
    channel->fetch();  // a world that stands still brings no other picture
    co_return failed;
}

Reply PictureStream::head(Form form) {
    Reply reply;
    reply.content_type =
        std::string(form == Form::mjpeg ? "multipart/x-mixed-replace" : "multipart/mixed") + "; boundary=frame";
    reply.fields = {{"Cache-Control", "no-store"}, {"X-Accel-Buffering", "no"}};
    reply.endless = true;
    reply.close = true;
    return reply;
}

asio::awaitable<void> PictureStream::run(beast::tcp_stream& socket, unsigned http_version, bool embeddable) {
    Reply opening = head(form_);
    opening.embeddable = embeddable;
    for (const auto& channel : channels_) channel->fetch();
    repeat_at_ = Clock::now() + state_.options.limits.repeat_after;
    Failure failed = co_await send_text(socket, head_of(opening, http_version, false) + std::string(boundary_line));
    bool ended = false;
    while (!failed && !ended) {
        int sent = 0;
        failed = co_await send_round(socket, sent, ended);
        if (!failed && ended && form_ == Form::mjpeg && channels_.front()->is_reset()) co_return break_off(socket);
        if (!failed && ended) failed = co_await send_text(socket, closing);
        if (!failed && !ended) failed = co_await follow_output(socket);
        if (!failed && !ended && sent == 0) failed = co_await wait(socket);
    }
    if (failed == beast::error::timeout) {
        ++state_.counts.stalled;
        spdlog::info("a reader of {} took nothing for {} ms and is closed",
                     form_ == Form::mjpeg ? "camera " + channels_.front()->camera()
                                          : std::to_string(channels_.size()) + " cameras",
                     state_.options.limits.stalled_after.count());
    }
}

asio::awaitable<PictureStream::Failure> PictureStream::send_text(beast::tcp_stream& socket, std::string_view text) {
    const std::string kept(text);
    SendPieces pieces{asio::buffer(kept)};
    co_return co_await send_all(socket, pieces, state_.options.limits.stalled_after);
}

asio::awaitable<PictureStream::Failure> PictureStream::send_part(beast::tcp_stream& socket,
                                                                 const stream::MediaUnit& unit,
                                                                 const std::string& camera) {
    const std::size_t bytes = unit.bytes->size();
    // The page's own stream of many cameras stays readable.
    const fault::FrameFaults* const faults = form_ == Form::mjpeg ? unit.info.faults.get() : nullptr;
    const auto wrong = faults ? fault::part_error(*faults) : std::nullopt;
    const std::size_t announced = wrong == fault::PartError::length ? bytes + bytes / 2 : bytes;
    const std::string head =
        part_head(unit, announced, state_.wall, form_ == Form::live ? std::string_view(camera) : "");
    SendPieces pieces{asio::buffer(head), asio::buffer(unit.bytes->data(), bytes),
                      asio::buffer(wrong == fault::PartError::boundary ? without_boundary : after_picture)};
    const auto cut = faults ? fault::cut_part(*faults, bytes) : std::nullopt;
    if (cut) {
        pieces = {asio::buffer(head), asio::buffer(unit.bytes->data(), bytes - cut->bytes)};
        fault::note(*faults, to_string(fault::Output::mjpeg), *cut);
    }
    const Failure failed = co_await send_all(socket, pieces, state_.options.limits.stalled_after);
    repeat_at_ = Clock::now() + state_.options.limits.repeat_after;
    if (cut) co_return asio::error::connection_aborted;
    co_return failed;
}

asio::awaitable<PictureStream::Failure> PictureStream::send_round(beast::tcp_stream& socket, int& sent, bool& ended) {
    for (const auto& channel : channels_) {
        const bool has_ended = channel->ended();  // asked first: what comes in between is still sent
        auto picture = channel->next();
        if (!picture) {
            ended = ended || (has_ended && is_over(*channel));
            continue;
        }
        const Failure failed = co_await send_part(socket, picture->unit, channel->camera());
        if (form_ == Form::mjpeg) {
            last_ = picture->unit;
            last_->latch.reset();
        }
        channel->sent(std::move(*picture), static_cast<bool>(failed));
        if (failed) co_return failed;
        ++sent;
    }
    co_return Failure{};
}

asio::awaitable<PictureStream::Failure> PictureStream::wait(beast::tcp_stream& socket) {
    const Clock::time_point now = Clock::now();
    if (now < repeat_at_) {
        Clock::time_point until = repeat_at_;
        for (const auto& channel : channels_) until = std::min(until, channel->reopen_at().value_or(until));
        const Wake wake = co_await event_->wait_for(until - now);
        if (wake == Wake::disconnected) co_return asio::error::operation_aborted;
        co_return Failure{};
    }
    repeat_at_ = Clock::now() + state_.options.limits.repeat_after;
    // A first picture that failed is asked for again.
    for (const auto& channel : channels_)
        if (!channel->has_picture()) channel->fetch();
    if (form_ == Form::live) co_return co_await send_text(socket, sign_of_life);
    if (!last_ || channels_.front()->is_held_back()) co_return Failure{};
    ++state_.counts.repeated_parts;
    co_return co_await send_part(socket, *last_, {});
}

}  // namespace camrig::http
