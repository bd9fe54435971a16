#pragma once

#include <deque>
#include <memory>
#include <mutex>
#include <optional>

#include "core/stream/sink.h"
#include "rtsp_out/rtsp/frame_times_sei.h"
#include "rtsp_out/rtsp/gst_handle.h"

namespace camrig::rtsp {

/// One picture that a reader is to be sent. Counts it when nobody refers to it any more, delivered or, if it never left
/// the encoder, dropped; and lets go of its latch.
struct PendingPicture {
    frame::FrameInfo info;
    std::shared_ptr<stream::ReaderStats> stats;
    stream::DeliveryLatch::Hold hold;
    std::size_t sent_bytes = 0;  ///< 0: it never came out of the encoder

    ~PendingPicture();
};

/// A picture in the pipeline of a stream.
struct PictureOnWay {
    TimeNs pts = 0;  ///< stream time
    FrameTimes times;
    codec::BytesRef bytes;                             ///< JPEG only
    std::shared_ptr<const fault::FrameFaults> faults;  ///< of the picture
    std::shared_ptr<PendingPicture> pending;           ///< null: it was sent before, or by nobody's wish
};

/// The pictures between the appsrc of a stream and its payloader, in the order of their stamps. Any thread.
class PicturesOnWay {
public:
    /// An encoder without reordering holds one or two; beyond so many the oldest is dropped.
    static constexpr std::size_t most = 16;

    void add(PictureOnWay picture);
    /// The picture of this stream time. What went in before it and did not come out was dropped.
    std::optional<PictureOnWay> take(TimeNs pts);
    void clear();

private:
    std::mutex mutex_;
    std::deque<PictureOnWay> pictures_;
};

/// What goes on in place of an encoded picture, which came to `pad`: its bytes, as faults leave them and with its times
/// inside unless it is JPEG, in memory that keeps its PendingPicture. Null, and the picture as it is, if none of those
/// on their way has its stamp.
GstBufferHandle sent_in_place_of(GstBuffer* encoded, GstPad* pad, NalCodec codec, PicturesOnWay& on_way);

}  // namespace camrig::rtsp
