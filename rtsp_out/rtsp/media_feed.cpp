#include "rtsp_out/rtsp/media_feed.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <gst/app/gstappsrc.h>
#include <gst/video/video.h>
#include <spdlog/spdlog.h>

#include "core/base/clock.h"
#include "core/fault/sending.h"
#include "rtsp_out/rtsp/damaged_video.h"
#include "rtsp_out/rtsp/rtp_packet.h"

namespace camrig::rtsp {
namespace {

/// Pictures between appsrc and payloader; an encoder without reordering holds one or two.
constexpr std::size_t max_on_way = 16;

/// Keeps a value alive as long as a piece of GStreamer memory.
template <typename T>
GstBuffer* wrapped(const void* data, std::size_t size, T keeper) {
    auto* const kept = new T(std::move(keeper));
    return gst_buffer_new_wrapped_full(GST_MEMORY_FLAG_READONLY, const_cast<void*>(data), size, 0, size, kept,
                                       [](void* pointer) { delete static_cast<T*>(pointer); });
}

GstCapsHandle caps_of(const stream::MediaFormat& format, ImageSize size, const Rate& rate) {
    GstCaps* caps = nullptr;
    if (format.codec == codec::Codec::jpeg) {
        caps = gst_caps_new_empty_simple("image/jpeg");
    } else {
        // sRGB pictures (BT.709 primaries, sRGB transfer) through the BT.601 matrix in limited range, chroma in the
        // middle of its pixels: core/frame/convert.h. BT.601 at every size, for many programs never read the
        // description.
        caps = gst_caps_new_simple("video/x-raw", "format", G_TYPE_STRING,
                                   format.pixels == frame::PixelFormat::nv12 ? "NV12" : "I420", "colorimetry",
                                   G_TYPE_STRING, "2:4:7:1", "chroma-site", G_TYPE_STRING, "jpeg", "interlace-mode",
                                   G_TYPE_STRING, "progressive", nullptr);
    }
    gst_caps_set_simple(caps, "width", G_TYPE_INT, size.width, "height", G_TYPE_INT, size.height, "framerate",
                        GST_TYPE_FRACTION, static_cast<int>(rate.num()), static_cast<int>(rate.den()), nullptr);
    return GstCapsHandle(caps);
}

}  // namespace

struct MediaFeed::PendingPicture {
    frame::FrameInfo info;
    std::shared_ptr<stream::ReaderStats> stats;
    stream::DeliveryLatch::Hold hold;
    std::size_t sent_bytes = 0;  ///< 0: it never came out of the encoder

    ~PendingPicture() {
        if (sent_bytes == 0) {
            stats->dropped.fetch_add(1, std::memory_order_relaxed);
        } else {
            stats->delivered.fetch_add(1, std::memory_order_relaxed);
            stats->bytes.fetch_add(sent_bytes, std::memory_order_relaxed);
            stats->last_latency_ns.store(monotonic_now_ns() - info.monotonic_ns, std::memory_order_relaxed);
        }
        hold.release();
    }
};

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
    if (playing_) pending->hold = hold_if(unit.latch, "RTSP readers of " + options_.path);
    push(unit, *stamp_ns, std::move(pending));
    return {};
}

void MediaFeed::close() noexcept {}

void MediaFeed::hold_back(const frame::FrameInfo&) {
    std::lock_guard lock(mutex_);
    is_held_back_ = true;
}

RtpTimeline::SenderTime MediaFeed::sender_time(TimeNs now_ns) {
    std::lock_guard lock(mutex_);
    return options_.timeline.sender_time(now_ns, clock_);
}

/// The stream time of a picture that is stamped so, by its camera's clock. With the mutex held.
TimeNs MediaFeed::next_pts(const frame::FrameInfo& info, TimeNs stamp_ns) {
    const ClockReading reading = info.clock.value_or(ClockReading{});
    if (!first_clock_error_ns_) first_clock_error_ns_ = reading.steady_error_ns;
    // Where a clock is given or taken away, or begins anew in another world, RTP time goes on as if it had been so
    // before: it is steady, and its constant error is nobody's to see.
    const bool begins_anew = last_pts_ >= 0 && (had_clock_ != info.clock.has_value() || info.world_ns < last_world_ns_);
    had_clock_ = info.clock.has_value();
    last_world_ns_ = info.world_ns;
    if (begins_anew) first_clock_error_ns_ = reading.steady_error_ns - clock_.rtp_error_ns;
    clock_ = {.rtp_error_ns = reading.steady_error_ns - *first_clock_error_ns_, .ntp_error_ns = reading.stamp_error_ns};
    return last_pts_ = std::max(options_.timeline.pts_of(stamp_ns) + clock_.rtp_error_ns, last_pts_ + min_pts_step_ns);
}

/// With the mutex held.
void MediaFeed::push(const stream::MediaUnit& unit, TimeNs stamp_ns, std::shared_ptr<PendingPicture> pending) {
    const frame::FrameInfo& info = unit.info;
    const TimeNs pts = next_pts(info, stamp_ns);
    const TimeNs realtime_ns = options_.timeline.realtime_of(info.monotonic_ns) + info.stamp_ns() - info.world_ns;
    on_way_.push_back({pts,
                       {info.sequence, info.world_ns, info.monotonic_ns, realtime_ns},
                       unit.bytes,
                       info.faults,
                       std::move(pending)});
    if (on_way_.size() > max_on_way) on_way_.pop_front();
    GstBuffer* buffer = buffer_of(unit);
    GST_BUFFER_PTS(buffer) = static_cast<GstClockTime>(pts);
    GST_BUFFER_DURATION(buffer) = static_cast<GstClockTime>(options_.rate.period_ns());
    keep(unit);
    // Never blocks: the oldest waiting picture gives way. Fails only when the pipeline is going.
    gst_app_src_push_buffer(GST_APP_SRC(source_.get()), buffer);
}

/// With the mutex held.
void MediaFeed::keep(const stream::MediaUnit& unit) {
    last_ = unit;
    last_->latch.reset();
}

GstBuffer* MediaFeed::buffer_of(const stream::MediaUnit& unit) const {
    if (unit.bytes) return wrapped(unit.bytes->data(), unit.bytes->size(), unit.bytes);
    const frame::FrameRef& frame = unit.frame;
    GstBuffer* buffer = wrapped(frame->bytes().data(), frame->bytes().size(), frame);
    // Our rows are not padded, and an odd last column or row is left out: pixel (x, y) stays pixel (x, y).
    const auto width = static_cast<gsize>(unit.info.size.width), height = static_cast<gsize>(unit.info.size.height);
    const gsize half_width = (width + 1) / 2, half_height = (height + 1) / 2;
    const bool nv12 = options_.format.pixels == frame::PixelFormat::nv12;
    gsize offsets[GST_VIDEO_MAX_PLANES] = {0, width * height, width * height + half_width * half_height};
    gint strides[GST_VIDEO_MAX_PLANES] = {
        static_cast<gint>(width), static_cast<gint>(nv12 ? 2 * half_width : half_width), static_cast<gint>(half_width)};
    gst_buffer_add_video_meta_full(
        buffer, GST_VIDEO_FRAME_FLAG_NONE, nv12 ? GST_VIDEO_FORMAT_NV12 : GST_VIDEO_FORMAT_I420,
        static_cast<guint>(shown_.width), static_cast<guint>(shown_.height), nv12 ? 2 : 3, offsets, strides);
    return buffer;
}

GstPadProbeReturn MediaFeed::replace_packets(GstPad* pad, GstPadProbeInfo* info) {
    std::shared_ptr<const fault::FrameFaults> faults;
    {
        std::lock_guard lock(mutex_);
        faults = faults_;
    }
    if (is_sending_held_ || packet_faults_.is_idle(faults.get())) return GST_PAD_PROBE_OK;
    std::vector<GstBufferHandle> sent;
    const bool is_single = (GST_PAD_PROBE_INFO_TYPE(info) & GST_PAD_PROBE_TYPE_BUFFER) != 0;
    if (is_single) {
        packet_faults_.pass(GstBufferHandle(gst_buffer_ref(GST_PAD_PROBE_INFO_BUFFER(info))), faults.get(), sent);
    } else {
        GstBufferList* const list = GST_PAD_PROBE_INFO_BUFFER_LIST(info);
        for (guint i = 0; i < gst_buffer_list_length(list); ++i)
            packet_faults_.pass(GstBufferHandle(gst_buffer_ref(gst_buffer_list_get(list, i))), faults.get(), sent);
    }
    if (sent.empty()) return GST_PAD_PROBE_DROP;
    if (!is_single) {
        GstBufferList* const list = gst_buffer_list_new_sized(static_cast<guint>(sent.size()));
        for (GstBufferHandle& packet : sent) gst_buffer_list_add(list, packet.release());
        gst_buffer_list_unref(GST_PAD_PROBE_INFO_BUFFER_LIST(info));
        GST_PAD_PROBE_INFO_DATA(info) = list;
        return GST_PAD_PROBE_OK;
    }
    // A probe passes one packet on: the last. Those before it go by themselves.
    is_sending_held_ = true;
    for (std::size_t i = 0; i + 1 < sent.size(); ++i) gst_pad_push(pad, sent[i].release());
    is_sending_held_ = false;
    gst_buffer_unref(GST_PAD_PROBE_INFO_BUFFER(info));
    GST_PAD_PROBE_INFO_DATA(info) = sent.back().release();
    return GST_PAD_PROBE_OK;
}

GstPadProbeReturn MediaFeed::on_packets(GstPad* pad, GstPadProbeInfo* info, void* feed) {
    const auto self = static_cast<std::weak_ptr<MediaFeed>*>(feed)->lock();
    return self ? self->replace_packets(pad, info) : GST_PAD_PROBE_OK;
}

GstPadProbeReturn MediaFeed::on_encoded(GstPad* pad, GstPadProbeInfo* info, void* feed) {
    const auto self = static_cast<std::weak_ptr<MediaFeed>*>(feed)->lock();
    if (!self) return GST_PAD_PROBE_OK;
    GstBuffer* encoded = GST_PAD_PROBE_INFO_BUFFER(info);
    GstBuffer* replaced = self->packet_source(pad, encoded);
    if (!replaced) return GST_PAD_PROBE_OK;
    gst_buffer_unref(encoded);
    GST_PAD_PROBE_INFO_DATA(info) = replaced;
    return GST_PAD_PROBE_OK;
}

/// The encoded picture in memory that carries its books, with its times inside unless it is JPEG.
GstBuffer* MediaFeed::packet_source(GstPad* pad, GstBuffer* encoded) {
    // An encoder may shift its stamps and its segment alike; running time stays.
    GstEvent* event = gst_pad_get_sticky_event(pad, GST_EVENT_SEGMENT, 0);
    if (!event) return nullptr;
    const GstSegment* segment = nullptr;
    gst_event_parse_segment(event, &segment);
    const guint64 running = gst_segment_to_running_time(segment, GST_FORMAT_TIME, GST_BUFFER_PTS(encoded));
    gst_event_unref(event);

    auto entry = take_entry(static_cast<TimeNs>(running));
    if (!entry) return nullptr;
    if (!entry->bytes) {
        GstMapInfo map;
        if (!gst_buffer_map(encoded, &map, GST_MAP_READ)) return nullptr;
        const std::span bytes(reinterpret_cast<const std::byte*>(map.data), map.size);
        auto sent = with_frame_times(bytes, entry->times, options_.codec);
        gst_buffer_unmap(encoded, &map);
        if (entry->faults) {
            auto damaged = damaged_video(*entry->faults, sent, options_.codec);
            if (entry->pending && damaged.bytes != sent) ++entry->pending->stats->damaged;
            for (const fault::Harm& harm : damaged.harms)
                fault::note(*entry->faults, to_string(fault::Output::rtsp), harm);
            sent = std::move(damaged.bytes);
        }
        entry->bytes = std::make_shared<const std::vector<std::byte>>(std::move(sent));
    }
    if (entry->pending) entry->pending->sent_bytes = entry->bytes->size();
    const codec::BytesRef bytes = entry->bytes;
    GstBuffer* buffer = wrapped(bytes->data(), bytes->size(), std::make_pair(bytes, std::move(entry->pending)));
    constexpr int what = GST_BUFFER_COPY_FLAGS | GST_BUFFER_COPY_TIMESTAMPS;
    gst_buffer_copy_into(buffer, encoded, static_cast<GstBufferCopyFlags>(what), 0, static_cast<gsize>(-1));
    return buffer;
}

/// The picture of this stamp. What went in before it and did not come out was dropped.
std::optional<MediaFeed::Entry> MediaFeed::take_entry(TimeNs pts) {
    std::deque<Entry> gone;  // freed without the mutex: pending pictures let go of latches
    std::lock_guard lock(mutex_);
    while (!on_way_.empty() && on_way_.front().pts < pts) {
        gone.push_back(std::move(on_way_.front()));
        on_way_.pop_front();
    }
    if (on_way_.empty() || on_way_.front().pts != pts) return std::nullopt;
    Entry entry = std::move(on_way_.front());
    on_way_.pop_front();
    return entry;
}

void MediaFeed::request_key_frame() {
    if (!encoder_) return;
    const GObjectHandle<GstPad> pad(gst_element_get_static_pad(encoder_.get(), "src"));
    gst_pad_send_event(pad.get(), gst_video_event_new_upstream_force_key_unit(GST_CLOCK_TIME_NONE, FALSE, 0));
}

void MediaFeed::follow_ssrc() {
    const std::uint64_t epoch = faults_ ? fault::ssrc_epoch(*faults_) : 0;
    if (std::exchange(ssrc_epoch_, epoch) == epoch || epoch == 0) return;
    // A payloader takes another one at random when it is told that somebody else has its own (RFC 3550, 8.2).
    const GObjectHandle<GstPad> pad(gst_element_get_static_pad(payloader_.get(), "src"));
    GstStructure* stats = nullptr;
    guint ssrc = 0;
    g_object_get(payloader_.get(), "stats", &stats, nullptr);
    if (stats == nullptr) return;
    const bool is_known = gst_structure_get_uint(stats, "ssrc", &ssrc) != 0;
    gst_structure_free(stats);
    if (!is_known) return;
    gst_pad_send_event(pad.get(),
                       gst_event_new_custom(GST_EVENT_CUSTOM_UPSTREAM,
                                            gst_structure_new("GstRTPCollision", "ssrc", G_TYPE_UINT, ssrc, nullptr)));
}

std::optional<NalCodec> MediaFeed::nal_codec() const {
    if (options_.format.codec == codec::Codec::jpeg) return std::nullopt;
    return options_.codec;
}

void MediaFeed::client_plays() {
    request_key_frame();
    const TimeNs now_ns = monotonic_now_ns();
    std::lock_guard lock(mutex_);
    playing_ = true;
    if (is_held_back_) return;
    if (const auto stamp_ns = stamps_.of_join(now_ns)) push(stream::MediaUnit(*last_), *stamp_ns, nullptr);
}

void MediaFeed::add_tcp_reader(GSocket* socket) {
    std::lock_guard lock(tcp_mutex_);
    tcp_readers_.emplace_back(socket);
}

bool MediaFeed::tcp_readers_take() {
    if (is_lockstep()) return true;
    std::lock_guard lock(tcp_mutex_);
    bool takes = false;
    for (auto reader = tcp_readers_.begin(); reader != tcp_readers_.end() && !takes;) {
        const auto socket = reader->lock<GSocket>();
        takes = socket && g_socket_condition_check(socket.get(), G_IO_OUT) != 0;
        reader = socket ? std::next(reader) : tcp_readers_.erase(reader);
    }
    takes = takes || tcp_readers_.empty();
    // Pictures are missing now: the next one that goes on should need none of them.
    if (takes && std::exchange(tcp_missed_, !takes)) request_key_frame();
    tcp_missed_ = !takes;
    return takes;
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
    std::deque<Entry> gone;
    {
        std::lock_guard lock(mutex_);
        stopped_ = true;
        gone.swap(on_way_);
    }
    std::optional<stream::Subscription> subscription;
    std::lock_guard lock(subscription_mutex_);
    subscription.swap(subscription_);
}

}  // namespace camrig::rtsp
