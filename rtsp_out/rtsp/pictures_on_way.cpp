#include "rtsp_out/rtsp/pictures_on_way.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/base/clock.h"
#include "core/fault/sending.h"
#include "rtsp_out/rtsp/damaged_video.h"
#include "rtsp_out/rtsp/picture_buffers.h"

namespace camrig::rtsp {

PendingPicture::~PendingPicture() {
    if (sent_bytes == 0) {
        stats->dropped.fetch_add(1, std::memory_order_relaxed);
    } else {
        stats->delivered.fetch_add(1, std::memory_order_relaxed);
        stats->bytes.fetch_add(sent_bytes, std::memory_order_relaxed);
        stats->last_latency_ns.store(monotonic_now_ns() - info.monotonic_ns, std::memory_order_relaxed);
    }
    hold.release();
}

void PicturesOnWay::add(PictureOnWay picture) {
    std::optional<PictureOnWay> dropped;  // freed without the mutex: pending pictures let go of latches
    std::lock_guard lock(mutex_);
    pictures_.push_back(std::move(picture));
    if (pictures_.size() <= most) return;
    // While an encoder takes long over a picture, the one before it is sent again and again.
    auto oldest = std::ranges::find(pictures_, nullptr, &PictureOnWay::pending);
    if (oldest == pictures_.end()) oldest = pictures_.begin();
    dropped = std::move(*oldest);
    pictures_.erase(oldest);
}

std::optional<PictureOnWay> PicturesOnWay::take(TimeNs pts) {
    std::deque<PictureOnWay> dropped;  // as in add()
    std::lock_guard lock(mutex_);
    while (!pictures_.empty() && pictures_.front().pts < pts) {
        dropped.push_back(std::move(pictures_.front()));
        pictures_.pop_front();
    }
    if (pictures_.empty() || pictures_.front().pts != pts) return std::nullopt;
    PictureOnWay picture = std::move(pictures_.front());
    pictures_.pop_front();
    return picture;
}

void PicturesOnWay::clear() {
    std::deque<PictureOnWay> dropped;  // as in add()
    std::lock_guard lock(mutex_);
    dropped.swap(pictures_);
}

GstBufferHandle sent_in_place_of(GstBuffer* encoded, GstPad* pad, NalCodec codec, PicturesOnWay& on_way) {
    // An encoder may shift its stamps and its segment alike; running time stays.
    GstEvent* event = gst_pad_get_sticky_event(pad, GST_EVENT_SEGMENT, 0);
    if (!event) return nullptr;
    const GstSegment* segment = nullptr;
    gst_event_parse_segment(event, &segment);
    const guint64 running = gst_segment_to_running_time(segment, GST_FORMAT_TIME, GST_BUFFER_PTS(encoded));
    gst_event_unref(event);

    auto picture = on_way.take(static_cast<TimeNs>(running));
    if (!picture) return nullptr;
    if (!picture->bytes) {
        GstMapInfo map;
        if (!gst_buffer_map(encoded, &map, GST_MAP_READ)) return nullptr;
        const std::span bytes(reinterpret_cast<const std::byte*>(map.data), map.size);
        auto sent = with_frame_times(bytes, picture->times, codec);
        gst_buffer_unmap(encoded, &map);
        if (picture->faults) {
            auto damaged = damaged_video(*picture->faults, sent, codec);
            if (picture->pending && damaged.bytes != sent) ++picture->pending->stats->damaged;
            for (const fault::Harm& harm : damaged.harms)
                fault::note(*picture->faults, to_string(fault::Output::rtsp), harm);
            sent = std::move(damaged.bytes);
        }
        picture->bytes = std::make_shared<const std::vector<std::byte>>(std::move(sent));
    }
    if (picture->pending) picture->pending->sent_bytes = picture->bytes->size();
    const codec::BytesRef bytes = picture->bytes;
    GstBufferHandle buffer = wrapped(bytes->data(), bytes->size(), std::make_pair(bytes, std::move(picture->pending)));
    constexpr int what = GST_BUFFER_COPY_FLAGS | GST_BUFFER_COPY_TIMESTAMPS;
    gst_buffer_copy_into(buffer.get(), encoded, static_cast<GstBufferCopyFlags>(what), 0, static_cast<gsize>(-1));
    return buffer;
}

}  // namespace camrig::rtsp
