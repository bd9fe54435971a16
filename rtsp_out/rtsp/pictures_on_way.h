#pragma once

#include <deque>
#include <memory>
#include <mutex>
#include <optional>

#include "core/stream/sink.h"
#include "rtsp_out/rtsp/frame_times_sei.h"
#include "rtsp_out/rtsp/gst_handle.h"

namespace camrig::rtsp {

/// Delivery accounting of one picture. The destructor, when no RTP packet refers to the picture any more, counts it as
/// delivered or, if it never left the encoder, as dropped, and releases its latch.
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
    std::shared_ptr<PendingPicture> pending;           ///< null: not counted, a repeat or a stream's first picture
};

/// The pictures between the appsrc of a stream and its payloader, in the order of their stamps. Any thread.
class PicturesOnWay {
public:
    /// An encoder without reordering holds one or two. Of more than so many the oldest is dropped that is not counted,
    /// or else the oldest.
    static constexpr std::size_t most = 16;

    void add(PictureOnWay picture);
    /// Removes and returns the picture with this PTS. Earlier ones, which the encoder has dropped, are removed too.
    std::optional<PictureOnWay> take(TimeNs pts);
    void clear();

private:
    std::mutex mutex_;
    std::deque<PictureOnWay> pictures_;
};

/// The buffer to pass on in place of an encoded picture, which came to `pad`: its bytes, damaged by faults and with a
/// frame times SEI unless it is JPEG, in memory that owns its PendingPicture. Null: pass `encoded` on unchanged, for no
/// picture in `on_way` has its PTS.
GstBufferHandle sent_in_place_of(GstBuffer* encoded, GstPad* pad, NalCodec codec, PicturesOnWay& on_way);

}  // namespace camrig::rtsp
