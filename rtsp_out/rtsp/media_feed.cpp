#include "rtsp_out/rtsp/media_feed.h"

#include <utility>

#include <gst/app/gstappsrc.h>
#include <spdlog/spdlog.h>

#include "core/base/clock.h"
#include "core/fault/sending.h"
#include "rtsp_out/rtsp/picture_buffers.h"
#include "rtsp_out/rtsp/pipeline_requests.h"

namespace camrig::rtsp {
namespace {

void leave_out_false_head(GstPadProbeInfo* info) {
    GstBuffer* const encoded = GST_PAD_PROBE_INFO_BUFFER(info);
    GstMapInfo map;
    // Only key pictures have parameter sets.
    if (GST_BUFFER_FLAG_IS_SET(encoded, GST_BUFFER_FLAG_DELTA_UNIT)) return;
    if (!gst_buffer_map(encoded, &map, GST_MAP_READ)) return;
    const std::size_t begin = begin_of_last_parameter_sets(
        {reinterpret_cast<const std::byte*>(map.data), static_cast<std::size_t>(map.size)});
    gst_buffer_unmap(encoded, &map);
    if (begin == 0) return;
    GstBuffer* const rest = gst_buffer_copy_region(encoded, GST_BUFFER_COPY_ALL, begin, static_cast<gsize>(-1));
    // A region that does not begin where the buffer does is given no times.
    gst_buffer_copy_into(rest, encoded, GST_BUFFER_COPY_TIMESTAMPS, 0, static_cast<gsize>(-1));
    GST_PAD_PROBE_INFO_DATA(info) = rest;
    gst_buffer_unref(encoded);
}

}  // namespace

std::shared_ptr<MediaFeed> MediaFeed::create(Options options, GstElement* bin) {
    std::shared_ptr<MediaFeed> feed(new MediaFeed(std::move(options), bin));
    // Callbacks hold the feed weakly: the media owns it, and it may be going already.
    using Weak = std::weak_ptr<MediaFeed>;
    const auto forget = [](void* weak, GClosure*) { delete static_cast<Weak*>(weak); };
    g_signal_connect_data(feed->source_.get(), "need-data", G_CALLBACK(on_need_data), new Weak(feed), forget,
                          GConnectFlags{});
    const GObjectHandle<GstPad> pad(gst_element_get_static_pad(feed->payloader_.get(), "sink"));
    gst_pad_add_probe(pad.get(), GST_PAD_PROBE_TYPE_BUFFER, on_encoded, new Weak(feed),
                      [](void* weak) { delete static_cast<Weak*>(weak); });
    const GObjectHandle<GstPad> packets(gst_element_get_static_pad(feed->payloader_.get(), "src"));
    constexpr int single_or_list = GST_PAD_PROBE_TYPE_BUFFER | GST_PAD_PROBE_TYPE_BUFFER_LIST;
    gst_pad_add_probe(packets.get(), static_cast<GstPadProbeType>(single_or_list), on_packets, new Weak(feed),
                      [](void* weak) { delete static_cast<Weak*>(weak); });
    return feed;
}

MediaFeed::MediaFeed(Options options, GstElement* bin)
    : options_(std::move(options)),
      shown_(options_.size),
      source_(child_of(bin, "src")),
      encoder_(child_of(bin, "enc")),
      payloader_(child_of(bin, "pay0")) {
    CHECK(source_ != nullptr && payloader_ != nullptr);
    if (encoder_) shown_ = {shown_.width & ~1, shown_.height & ~1};
    const GstCapsHandle caps = caps_of(options_.format, shown_, options_.rate);
    g_object_set(source_.get(), "caps", caps.get(), "format", GST_FORMAT_TIME, "is-live", TRUE, "do-timestamp", FALSE,
                 "max-buffers", guint64{2}, "max-bytes", guint64{0}, "leaky-type", GST_APP_LEAKY_TYPE_DOWNSTREAM,
                 nullptr);
    g_object_set(payloader_.get(), "timestamp-offset", guint{options_.timeline.rtp_offset()}, "perfect-rtptime", FALSE,
                 nullptr);
}

MediaFeed::~MediaFeed() {
    stop();
}

void MediaFeed::on_need_data(GstElement*, unsigned, void* feed) {
    // The first call says that the pipeline runs and takes pictures.
    if (const auto self = static_cast<std::weak_ptr<MediaFeed>*>(feed)->lock()) self->start();
}

void MediaFeed::start() {
    {
        std::lock_guard lock(mutex_);
        if (std::exchange(started_, true) || stopped_) return;
    }
    const std::weak_ptr<MediaFeed> weak = weak_from_this();
    std::optional<Rate> rate;
    if (options_.rate != options_.camera.rate) rate = options_.rate;
    auto subscription = options_.bus->subscribe(options_.camera.name, options_.format, {"rtsp", options_.path, rate},
                                                shared_from_this(), [weak](const Error& why) {
                                                    spdlog::info("rtsp: a stream ends: {}", why.message);
                                                    if (const auto self = weak.lock()) self->end();
                                                });
    if (!subscription) return end();
    {
        std::lock_guard lock(subscription_mutex_);
        subscription_ = std::move(*subscription);
    }
    // Nothing may be due for long (the world stands still, or a low rate): the stream begins with the latest picture.
    options_.fetcher->fetch({options_.camera.name, frame::FrameKind::color, 0, options_.format},
                            [weak](Result<stream::MediaUnit> unit) {
                                if (const auto self = weak.lock()) self->first_picture(std::move(unit));
                            });
    bool stopped_meanwhile = false;
    {
        std::lock_guard lock(mutex_);
        stopped_meanwhile = stopped_;
    }
    if (stopped_meanwhile) stop();
}

void MediaFeed::first_picture(Result<stream::MediaUnit> unit) {
    if (!unit) {
        spdlog::warn("rtsp {}: no first picture: {}", options_.path, unit.error().message);
        return;  // the next due frame will do
    }
    std::lock_guard lock(mutex_);
    if (stopped_ || last_ || is_held_back_ || unit->info.size != options_.size) return;
    push(*unit, stamps_.of_first(unit->info.monotonic_ns, monotonic_now_ns()), nullptr);
}

Result<void> MediaFeed::open(const stream::StreamInfo& info) {
    if (info.size != options_.size) return error(ErrorKind::not_found, "the camera has another size now");
    std::lock_guard lock(mutex_);
    stats_ = info.stats;
    return {};
}

Result<void> MediaFeed::write(const stream::MediaUnit& unit) {
    std::lock_guard lock(mutex_);
    CHECK(stats_ != nullptr);
    is_held_back_ = false;
    faults_ = unit.info.faults;
    follow_ssrc();
    if (stopped_ || (last_ && unit.info.sequence <= last_->info.sequence)) {
        // The picture that the stream began with was this one, or a later one.
        const bool sent = !stopped_ && unit.info.sequence == last_->info.sequence;
        (sent ? stats_->delivered : stats_->dropped).fetch_add(1, std::memory_order_relaxed);
        return {};
    }
    lockstep_ = unit.latch != nullptr;
    const auto stamp_ns = stamps_.of_new(unit.info.monotonic_ns, monotonic_now_ns(), lockstep_);
    if (!stamp_ns) {
        stats_->dropped.fetch_add(1, std::memory_order_relaxed);
        keep(unit);  // what is sent again should be the newest
        return {};
    }
    auto pending = std::make_shared<PendingPicture>();
    pending->info = unit.info;
    pending->stats = stats_;
    if (!players_.empty()) pending->hold = hold_if(unit.latch, "RTSP readers of " + options_.path);
    push(unit, *stamp_ns, std::move(pending));
    return {};
}

void MediaFeed::close() noexcept {}

void MediaFeed::hold_back() {
    std::lock_guard lock(mutex_);
    is_held_back_ = true;
}

RtpTimeline::SenderTime MediaFeed::sender_time(TimeNs now_ns) {
    std::lock_guard lock(mutex_);
    return times_.sender_time(now_ns);
}

/// With the mutex held.
void MediaFeed::push(const stream::MediaUnit& unit, TimeNs stamp_ns, std::shared_ptr<PendingPicture> pending) {
    const frame::FrameInfo& info = unit.info;
    const TimeNs pts = times_.next_pts(info, stamp_ns);
    const TimeNs realtime_ns = options_.timeline.realtime_of(info.monotonic_ns) + info.stamp_ns() - info.world_ns;
    on_way_.add({pts,
                 {info.sequence, info.world_ns, info.monotonic_ns, realtime_ns},
                 unit.bytes,
                 info.faults,
                 std::move(pending)});
    GstBufferHandle buffer = buffer_of(unit, options_.format, shown_);
    GST_BUFFER_PTS(buffer.get()) = static_cast<GstClockTime>(pts);
    GST_BUFFER_DURATION(buffer.get()) = static_cast<GstClockTime>(options_.rate.period_ns());
    keep(unit);
    // Never blocks: the oldest waiting picture gives way. Fails only when the pipeline is going.
    gst_app_src_push_buffer(GST_APP_SRC(source_.get()), buffer.release());
}

/// With the mutex held.
void MediaFeed::keep(const stream::MediaUnit& unit) {
    last_ = unit;
    last_->latch.reset();
}

GstPadProbeReturn MediaFeed::on_packets(GstPad* pad, GstPadProbeInfo* info, void* feed) {
    const auto self = static_cast<std::weak_ptr<MediaFeed>*>(feed)->lock();
    if (!self) return GST_PAD_PROBE_OK;
    std::shared_ptr<const fault::FrameFaults> faults;
    {
        std::lock_guard lock(self->mutex_);
        faults = self->faults_;
    }
    return self->packet_faults_.replace(pad, info, faults.get());
}

GstPadProbeReturn MediaFeed::on_encoded(GstPad* pad, GstPadProbeInfo* info, void* feed) {
    const auto self = static_cast<std::weak_ptr<MediaFeed>*>(feed)->lock();
    if (!self) return GST_PAD_PROBE_OK;
    if (self->options_.codec == NalCodec::h265) leave_out_false_head(info);
    GstBuffer* encoded = GST_PAD_PROBE_INFO_BUFFER(info);
    GstBufferHandle sent = sent_in_place_of(encoded, pad, self->options_.codec, self->on_way_);
    if (!sent) return GST_PAD_PROBE_OK;
    gst_buffer_unref(encoded);
    GST_PAD_PROBE_INFO_DATA(info) = sent.release();
    return GST_PAD_PROBE_OK;
}

void MediaFeed::follow_ssrc() {
    const std::uint64_t epoch = faults_ ? fault::ssrc_epoch(*faults_) : 0;
    if (std::exchange(ssrc_epoch_, epoch) == epoch || epoch == 0) return;
    change_ssrc(payloader_.get());
}

std::optional<NalCodec> MediaFeed::nal_codec() const {
    if (options_.format.codec == codec::Codec::jpeg) return std::nullopt;
    return options_.codec;
}

void MediaFeed::client_plays(const GstRTSPClient* client) {
    request_key_frame(encoder_.get());
    const TimeNs now_ns = monotonic_now_ns();
    std::lock_guard lock(mutex_);
    players_.insert(client);
    if (is_held_back_) return;
    if (const auto stamp_ns = stamps_.of_join(now_ns)) push(stream::MediaUnit(*last_), *stamp_ns, nullptr);
}

void MediaFeed::client_rests(const GstRTSPClient* client, GSocket* socket) {
    if (socket) tcp_readers_.remove(socket);
    {
        std::lock_guard lock(mutex_);
        players_.erase(client);
        if (!players_.empty()) return;
    }
    on_way_.clear();  // nobody is sent these
}

bool MediaFeed::tcp_readers_take() {
    if (is_lockstep()) return true;
    const TcpReaders::Takes takes = tcp_readers_.take();
    // Pictures are missing now: the next one that goes on should need none of them.
    if (takes == TcpReaders::Takes::yes_again) request_key_frame(encoder_.get());
    return takes != TcpReaders::Takes::no;
}

bool MediaFeed::is_lockstep() {
    std::lock_guard lock(mutex_);
    return lockstep_;
}

void MediaFeed::repeat_if_idle(TimeNs now_ns) {
    std::lock_guard lock(mutex_);
    if (stopped_ || is_held_back_) return;
    if (const auto stamp_ns = stamps_.of_repeat(now_ns)) push(stream::MediaUnit(*last_), *stamp_ns, nullptr);
}

bool MediaFeed::has_ended(TimeNs now_ns) const {
    if (is_reset_) return ended_ns_.load() != max_time_ns;
    constexpr TimeNs farewell_ns = 200 * ns_per_ms;
    return now_ns > ended_ns_.load() && now_ns - ended_ns_.load() >= farewell_ns;
}

void MediaFeed::end() {
    ended_ns_ = monotonic_now_ns();
    if (is_reset_) return;  // an end of the stream would be told its readers
    gst_app_src_end_of_stream(GST_APP_SRC(source_.get()));
}

void MediaFeed::stop() {
    {
        std::lock_guard lock(mutex_);
        stopped_ = true;
    }
    on_way_.clear();
    std::optional<stream::Subscription> subscription;
    std::lock_guard lock(subscription_mutex_);
    subscription.swap(subscription_);
}

}  // namespace camrig::rtsp
