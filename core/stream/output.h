#pragma once

#include <atomic>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "core/base/latest_slot.h"
#include "core/fault/line.h"
#include "core/stream/frame_bus.h"
#include "core/stream/reader_log.h"
#include "core/stream/transcoder.h"
#include "core/stream/worker_pool.h"

namespace camrig::stream {

/// One sink with its books. The mutex makes sink calls come one at a time, also against detaching.
struct Reader {
    SubscribeOptions options;
    std::shared_ptr<Sink> sink;
    std::function<void(Error)> on_end;
    std::shared_ptr<ReaderStats> stats;
    std::int64_t ticks_taken = -1;      ///< engine thread: ticks of options.rate up to the last frame taken
    std::atomic<bool> is_well = false;  ///< what it was given last had no faults, and no fault kept one back since

    std::mutex mutex;  ///< guards what follows and every call of the sink
    enum class State : std::uint8_t { fresh, open, waiting, closed } state = State::fresh;
    TimeNs retry_at_ns = 0;
    std::deque<MediaUnit> late;  ///< what a fault lets come later; without latches
    fault::Line line;            ///< what carries pictures to it
};

/// All readers of one camera in one MediaFormat: latest frame -> transcode once -> every reader's sink.
///
/// offer() is the engine's and never blocks; the rest runs as one job at a time on the worker pool. When the pool is
/// behind, the newest frame wins and the readers' books say so.
class Output : public std::enable_shared_from_this<Output> {
public:
    Output(CameraStream camera, std::unique_ptr<Transcoder> transcoder, WorkerPool& pool, ReaderLog& log);

    const CameraStream& camera() const { return camera_; }
    const MediaFormat& format() const { return transcoder_->format(); }
    /// The pixel format that frames had best be offered in; rgba8 will do.
    frame::PixelFormat source() const { return source_format(format(), camera_.size); }

    void attach(std::shared_ptr<Reader> reader);
    /// Closes the sink (waits for a write in progress, never from inside one). True if no reader is left.
    bool detach(const std::shared_ptr<Reader>& reader);
    /// Ends every reader: sinks are closed and on_end is called, on the worker pool.
    void end(Error why);
    std::size_t reader_count() const;

    /// Engine thread: would a frame of this world time be taken by anybody?
    bool wants(TimeNs world_ns) const;
    /// Engine thread: these frames do not come. How many of them the reader would have taken that takes most.
    std::uint64_t miss(const MissedFrames& frames, DropReason reason);
    /// Engine thread.
    void offer(const frame::FrameRef& frame, const std::shared_ptr<DeliveryLatch>& latch);

    OutputReport report() const;

private:
    struct Item {
        frame::FrameRef frame;
        std::shared_ptr<DeliveryLatch> latch;
        DeliveryLatch::Hold hold;
        std::vector<std::shared_ptr<Reader>> takers;
    };

    void post_run();
    void run();
    void deliver(Item item);
    /// Readers whose output fails at this frame do without it, or are thrown out.
    void leave_out_failing(Item& item);
    /// As this reader gets it.
    MediaUnit unit_for(const Reader& reader, const frame::FrameRef& frame, const MediaUnit& unit);
    /// What of it and of earlier ones comes now. With the reader's mutex held.
    Result<void> write_in_time(Reader& reader, MediaUnit unit);
    Result<void> write(Reader& reader, const MediaUnit& unit);
    /// For the log.
    void note(ReaderEventKind kind, const Reader& reader, TimeNs world_ns);
    void end_reader(const std::shared_ptr<Reader>& reader, Error why);

    const CameraStream camera_;
    const std::unique_ptr<Transcoder> transcoder_;
    WorkerPool& pool_;
    ReaderLog& log_;

    LatestSlot<Item> slot_{[this] { post_run(); }};

    mutable std::mutex mutex_;  ///< guards readers_
    std::vector<std::shared_ptr<Reader>> readers_;

    std::atomic<std::uint64_t> missed_by_fault_{0};
    std::atomic<std::uint64_t> not_drawn_{0};
    std::atomic<std::uint64_t> received_{0};
    std::atomic<std::uint64_t> encoded_{0};
    std::atomic<std::uint64_t> dropped_{0};
    std::atomic<std::uint64_t> failed_{0};
    std::atomic<std::uint64_t> kept_back_{0};
};

}  // namespace camrig::stream
