#include "rtsp_out/http/stream_channel.h"

#include <utility>

#include <spdlog/spdlog.h>

namespace camrig::http {

StreamChannel::StreamChannel(ServerState& state, AsyncEventRef event, stream::CameraStream camera, EncodingShare share,
                             const std::optional<Rate>& rate, std::string peer)
    : state_(state),
      event_(std::move(event)),
      camera_(std::move(camera)),
      share_(std::move(share)),
      rate_(rate),
      peer_(std::move(peer)) {}

StreamChannel::~StreamChannel() {
    if (sink_) sink_->abandon();
    subscription_.reset();
}

Result<std::unique_ptr<StreamChannel>> StreamChannel::create(ServerState& state, AsyncEventRef event,
                                                             const stream::CameraStream& camera,
                                                             const stream::MediaFormat& format,
                                                             const std::optional<Rate>& rate, const std::string& peer) {
    auto share = EncodingShare::take(state, camera.name, format);
    if (!share) return std::unexpected(share.error());
    return std::unique_ptr<StreamChannel>(
        new StreamChannel(state, std::move(event), camera, std::move(*share), rate, peer));
}

Result<void> StreamChannel::subscribe() {
    auto sink = std::make_shared<MjpegSink>(event_, camera_.name, peer_);
    // The sink is closed before on_end is called, and that says all the stream needs.
    auto subscription = state_.options.bus->subscribe(camera_.name, share_.format(), {"mjpeg", peer_, rate_}, sink, {});
    if (!subscription) return std::unexpected(subscription.error());
    subscription_ = std::move(*subscription);
    sink_ = std::move(sink);
    reopen_at_.reset();
    return {};
}

bool StreamChannel::reopen() {
    const auto now = std::chrono::steady_clock::now();
    if (reopen_at_ && now < *reopen_at_) return true;
    const auto found = state_.options.bus->find(camera_.name);
    if (!found || found->id != camera_.id || found->size != camera_.size) return false;
    if (std::exchange(reopen_at_, now + state_.options.limits.reopen_after) && !found->standing.refuses("mjpeg")) {
        if (auto in = subscribe(); !in) spdlog::debug("camera {}: {}", camera_.name, in.error().message);
    }
    return true;
}

void StreamChannel::fetch() {
    if (fetched_ || ended()) return;
    const auto ticket = FetchTicket::begin(state_);
    if (!ticket) return;
    stream::FetchRequest request;
    request.camera = camera_.name;
    request.format = share_.format();
    fetched_ = make_answer_slot<Result<stream::MediaUnit>>(event_);
    state_.options.fetcher->fetch(
        std::move(request), [slot = fetched_, ticket](Result<stream::MediaUnit> unit) { slot->put(std::move(unit)); });
}

std::optional<StreamChannel::Picture> StreamChannel::next() {
    while (auto item = sink_ ? sink_->take() : std::nullopt) {
        if (!last_sequence_ || item->unit.info.sequence > *last_sequence_) {
            stream::MediaUnit unit = item->unit;
            return Picture{std::move(unit), std::move(item)};
        }
        // The fetched picture was this frame (the client has it: delivered) or a later one (it missed this: dropped).
        if (item->unit.info.sequence == *last_sequence_) {
            sink_->sent(std::move(*item), 0);
        } else {
            sink_->dropped(std::move(*item));
        }
    }
    if (!fetched_) return std::nullopt;
    auto fetched = fetched_->take();
    if (!fetched) return std::nullopt;
    fetched_.reset();
    if (!*fetched) {
        // The subscription tells when the camera is gone; anything else is tried again by the next fetch().
        spdlog::debug("camera {}: no first picture for an MJPEG reader: {}", camera_.name, fetched->error().message);
        return std::nullopt;
    }
    if (last_sequence_ && (*fetched)->info.sequence <= *last_sequence_) return std::nullopt;
    ++state_.counts.first_parts;
    return Picture{std::move(**fetched), std::nullopt};
}

void StreamChannel::sent(Picture&& picture, bool failed) {
    Picture done = std::move(picture);
    if (!failed) last_sequence_ = done.unit.info.sequence;
    if (!done.item) return;
    if (failed) {
        sink_->dropped(std::move(*done.item));
    } else {
        sink_->sent(std::move(*done.item), done.unit.bytes->size());
    }
}

}  // namespace camrig::http
