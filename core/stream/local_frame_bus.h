#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "core/stream/frame_bus.h"
#include "core/stream/output.h"
#include "core/stream/reader_log.h"

namespace camrig::stream {

/// The frame bus of one rig. Consumer side: any thread (FrameBus). Producer side: the engine's thread.
class LocalFrameBus final : public FrameBus {
public:
    struct Options {
        int workers = 2;  ///< threads that convert and encode
        std::shared_ptr<frame::FramePool> pool;
        /// Beyond so many jobs that wait for a worker no picture on request is taken. Outputs have one each, always.
        std::size_t max_jobs = 1'000'000;
    };
    static constexpr std::size_t max_outputs_per_camera = 16;
    static constexpr std::size_t max_readers_per_camera = 1024;

    explicit LocalFrameBus(Options options);
    ~LocalFrameBus() override;

    Result<Subscription> subscribe(std::string_view camera, const MediaFormat& format, SubscribeOptions options,
                                   std::shared_ptr<Sink> sink, std::function<void(Error)> on_end) override;
    std::vector<CameraStream> cameras() const override;
    Result<CameraStream> find(std::string_view camera) const override;
    void add_observer(CameraObserver* observer) override;
    void remove_observer(CameraObserver* observer) override;
    void note_refused(std::string_view camera, std::string_view output, std::string_view peer) override;

    void add_camera(const CameraStream& camera);
    /// A new size ends the camera's outputs (their format cannot change), another sensor those of its numbers; a new
    /// rate does not.
    void change_camera(const CameraStream& camera);
    /// Tells observers.
    void adjust_camera(const CameraStream& camera);
    void remove_camera(CameraId id);
    /// The pixel formats that those want who would take a frame of this camera at this world time (Output::source);
    /// none: nobody would.
    frame::PixelFormats wanted(CameraId id, TimeNs world_ns) const;
    std::size_t reader_count(CameraId id) const;
    /// For the books: these frames do not come. How many of them the reader would have taken that takes most.
    std::uint64_t miss(CameraId id, const MissedFrames& frames, DropReason reason);
    /// Never blocks. With a latch, everything on its way holds it. Each output gets a camera's frame in the pixel
    /// format that it wants, else the one in rgba8.
    void publish(const frame::FrameSet& set, const std::shared_ptr<DeliveryLatch>& latch);

    /// Brings one frame into a format, on the worker pool; `done` is called there, or at once with an error:
    /// resource_exhausted where too many jobs wait.
    void transcode_once(frame::FrameRef frame, const MediaFormat& format, std::function<void(Result<MediaUnit>)> done);

    /// What faults let readers meet.
    ReaderLog& reader_log() { return log_; }

    /// Fills in each camera's outputs (by name) and the stages of this side.
    void fill_report(RigReport& report) const;

private:
    struct Camera {
        CameraStream stream;
        std::map<MediaFormat, std::shared_ptr<Output>> outputs;
    };
    using Cameras = std::map<CameraId, Camera>;

    void detach(CameraId id, const MediaFormat& format, const std::shared_ptr<Output>& output,
                const std::shared_ptr<Reader>& reader);
    /// For the log: which outputs refuse from now on who comes, and which do not any more.
    void note_doors(const CameraStream& before, const CameraStream& now);
    void end_outputs(Camera& camera, const Error& why);
    void end_numbers(Camera& camera, const Error& why);
    static const frame::FrameRef* frame_for(const Output& output, std::span<const frame::FrameRef> frames);
    Cameras::iterator find_locked(std::string_view name);

    const Options options_;
    ReaderLog log_;
    std::shared_ptr<TranscodeTimers> timers_ = std::make_shared<TranscodeTimers>();
    mutable std::mutex mutex_;  ///< guards cameras_; held for look-ups only
    Cameras cameras_;
    std::mutex observers_mutex_;  ///< also keeps observer calls in order
    std::vector<CameraObserver*> observers_;
    std::unique_ptr<WorkerPool> pool_;  ///< last member: its threads go first
};

}  // namespace camrig::stream
