#pragma once

#include <compare>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/result.h"
#include "core/codec/encoder.h"
#include "core/frame/frame.h"
#include "core/stream/delivery.h"
#include "core/stream/statistics.h"

namespace camrig::stream {

/// In which form a sink wants a camera's pictures. Equal formats of one camera share one conversion and one encoding.
struct MediaFormat {
    codec::Codec codec = codec::Codec::raw;
    frame::PixelFormat pixels = frame::PixelFormat::rgba8;           ///< raw: the layout. jpeg, png: ignored
    int quality = 0;                                                 ///< jpeg: 1..100. Others: 0
    ImageSize size;                                                  ///< 0x0: the camera's own; else scaled to this
    codec::ChromaSampling sampling = codec::ChromaSampling::yuv420;  ///< jpeg. Others: ignored
    /// Not 0: not the picture but the numbers of its sensor, laid out as `pixels` says, brought to so many bits: 8 in a
    /// byte, more in two. Raw and of the camera's own size only.
    int number_bits = 0;

    friend auto operator<=>(const MediaFormat&, const MediaFormat&) = default;
};

/// What a sink learns when it is opened. The size holds until close(): a camera that changes it closes its sinks.
struct StreamInfo {
    ImageSize size;
    std::shared_ptr<ReaderStats> stats;  ///< the sink counts delivered and dropped units here
};

/// One picture ready to send. Cheap to copy; bytes are shared.
struct MediaUnit {
    frame::FrameInfo info;
    codec::BytesRef bytes;                 ///< encoded (jpeg, png); null for raw
    frame::FrameRef frame;                 ///< raw pixels in the wanted layout and size; null for encoded
    std::shared_ptr<DeliveryLatch> latch;  ///< of a step only: take a hold while the unit is on its way
};

/// Delivers the frames of one camera to the outside.
///
/// Thread: every call but readers() comes from the Output that owns the sink, one at a time.
/// Order: open(), any number of write(), close(); close() may come early and twice, and must not block.
/// write() must not block longer than a copy takes: a sink with a slow peer keeps one unit and counts what it drops.
/// Every unit taken (write() gave no error) is counted once in StreamInfo::stats by the sink, as delivered or as
/// dropped; a unit whose write() failed is counted as dropped by the Output.
class Sink {
public:
    virtual ~Sink() = default;
    /// Prepares the target for frames of exactly this format and size.
    virtual Result<void> open(const StreamInfo& info) = 0;
    /// Delivers one unit. ErrorKind::unavailable asks the Output to reopen later; any other error ends the
    /// subscription.
    virtual Result<void> write(const MediaUnit& unit) = 0;
    virtual void close() noexcept = 0;
    /// A fault keeps a frame from it, and whatever it would send meanwhile in its place. Until the next write().
    virtual void hold_back() {}
    /// A fault breaks the connection: close() is next, and the peer shall hear nothing of it.
    virtual void reset() {}
    /// The books of those to whom the sink hands the units on, where it does. Any thread, at any time.
    virtual std::vector<ReaderReport> readers() const { return {}; }
};

}  // namespace camrig::stream
