#include "rtsp_out/http/stream_channel.h"

#include <spdlog/spdlog.h>

namespace camrig::http {

StreamChannel::StreamChannel(ServerState& state, AsyncEventRef event, std::string camera, EncodingShare share)
    : state_(state), event_(std::move(event)), camera_(std::move(camera)), share_(std::move(share)) {}

StreamChannel::~StreamChannel() {
    if (sink_) sink_->abandon();
    subscription_.reset();
}

Result<std::unique_ptr<StreamChannel>> StreamChannel::open(ServerState& state, AsyncEventRef event,
                                                           const std::string& camera, const stream::MediaFormat& format,
                                                           const std::optional<Rate>& rate, const std::string& peer) {
    auto share = EncodingShare::take(state, camera, format);
    if (!share) return std::unexpected(share.error());
    std::unique_ptr<StreamChannel> channel(new StreamChannel(state, event, camera, std::move(*share)));
    channel->sink_ = std::make_shared<MjpegSink>(event, camera, peer);
    stream::SubscribeOptions options{"mjpeg", peer, rate};
    // The sink is closed before on_end is called, and that says all the stream needs.
    auto subscription = state.options.bus->subscribe(camera, format, std::move(options), channel->sink_, {});
    if (!subscription) return std::unexpected(subscription.error());
    channel->subscription_ = std::move(*subscription);
    return channel;
}

void StreamChannel::fetch() {
    if (fetched_) return;
    const auto ticket = FetchTicket::begin(state_);
    if (!ticket) return;
    stream::FetchRequest request;
    request.camera = camera_;
    request.format = share_.format();
    fetched_ = make_answer_slot<Result<stream::MediaUnit>>(event_);
    state_.options.fetcher->fetch(
        std::move(request), [slot = fetched_, ticket](Result<stream::MediaUnit> unit) { slot->put(std::move(unit)); });
}

std::optional<StreamChannel::Picture> StreamChannel::next() {
    while (auto item = sink_->take()) {
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
        spdlog::debug("camera {}: no first picture for an MJPEG reader: {}", camera_, fetched->error().message);
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
