#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/base/unique_fd.h"
#include "core/stream/sink.h"
#include "v4l2_sink/preload/protocol.h"

namespace camrig::device {

/// Shared memory (memfd) of a sealed size, mapped here for writing.
class SharedMemory {
public:
    /// With `readers_only_read` nobody but this mapping can ever write to it (F_SEAL_FUTURE_WRITE).
    static Result<SharedMemory> create(const char* name, std::size_t bytes, bool readers_only_read);
    SharedMemory() = default;
    SharedMemory(SharedMemory&& other) noexcept;
    SharedMemory& operator=(SharedMemory&& other) noexcept;
    ~SharedMemory();

    int fd() const { return fd_.get(); }
    std::byte* data() const { return data_; }
    std::size_t size() const { return size_; }

private:
    UniqueFd fd_;
    std::byte* data_ = nullptr;
    std::size_t size_ = 0;
};

/// The rig's flow control for one reader of a ring, that is for one streaming open of a device: how many pictures it
/// was promised (tokens) and how many gave way to newer ones (displaced); protocol.h defines both. Guarded by the
/// ring's mutex while attached.
class RingReader {
public:
    /// `event_socket` must outlive the reader; tokens are sent there without ever blocking.
    RingReader(int event_socket, camrig_reader_page* page, std::shared_ptr<stream::ReaderStats> stats)
        : event_socket_(event_socket), page_(page), stats_(std::move(stats)) {}
    stream::ReaderReport report() const { return stats_->report(); }

private:
    friend class DeviceRing;
    void start(std::uint32_t slots);
    void stop();
    /// One more picture is in the ring.
    void offer(const std::shared_ptr<stream::DeliveryLatch>& latch, std::size_t bytes, TimeNs latency_ns);
    /// Sends the tokens that may be sent; in lockstep keeps the rest waiting, else gives up the oldest pictures.
    void advance();
    bool may_send() const;
    bool send_token();

    const int event_socket_;
    camrig_reader_page* const page_;
    const std::shared_ptr<stream::ReaderStats> stats_;
    std::uint64_t allowed_ = 0;  ///< most tokens whose pictures are not taken yet
    std::uint64_t tokens_ = 0;
    std::uint64_t displaced_ = 0;
    std::deque<stream::DeliveryLatch::Hold> pending_;  ///< lockstep: one per picture for which no buffer was queued yet
};

/// Pictures of one camera in one format, size and rate, written once for any number of readers in other processes.
///
/// Sink side: the Output's thread. attach, detach, credit, repeat_if_idle: the device server's thread.
class DeviceRing final : public stream::Sink {
public:
    /// `rate`: the rate of the subscription, if it takes fewer pictures than the camera makes.
    static Result<std::shared_ptr<DeviceRing>> create(ImageSize size, std::size_t picture_bytes,
                                                      std::optional<Rate> rate);

    Result<void> open(const stream::StreamInfo& info) override;
    Result<void> write(const stream::MediaUnit& unit) override;
    void close() noexcept override;
    void hold_back() override;
    /// Statistics of each attached reader.
    std::vector<stream::ReaderReport> readers() const override;

    /// The reader gets pictures from the next one on. The result is for its library: where in memory_fd() that is.
    camrig_ring_place attach(const std::shared_ptr<RingReader>& reader);
    /// After it returns no token is sent to this reader. Waiting pictures are dropped.
    void detach(const std::shared_ptr<RingReader>& reader);
    /// Lockstep: a reader that had no queued buffer has queued one, so that pictures that wait for it can be sent.
    void credit(RingReader& reader);
    /// Shows the last picture once more, with a new timestamp (stream::repeat_age_ns), when none came for idle_ns
    /// (programs give up on a silent camera after 5 to 10 s).
    void repeat_if_idle(TimeNs monotonic_ns, TimeNs idle_ns);

    int memory_fd() const { return memory_.fd(); }

private:
    struct Picture {
        std::span<const std::byte> bytes;
        std::uint32_t sequence = 0;
        std::uint32_t flags = 0;  ///< camrig_slot_...
    };

    DeviceRing(SharedMemory memory, ImageSize size, std::optional<Rate> rate);

    camrig_ring_header& header() const { return *reinterpret_cast<camrig_ring_header*>(memory_.data()); }
    /// Writes one picture and tells the readers. stamp_ns: its instant by the camera's own clock, which may be wrong.
    /// Call with mutex_ held.
    void publish(const Picture& picture, TimeNs monotonic_ns, TimeNs stamp_ns,
                 const std::shared_ptr<stream::DeliveryLatch>& latch);
    std::uint32_t next_sequence(const frame::FrameInfo& info);

    const SharedMemory memory_;
    const ImageSize size_;
    const std::optional<Rate> rate_;

    mutable std::mutex mutex_;
    std::shared_ptr<stream::ReaderStats> stats_;
    std::vector<std::shared_ptr<RingReader>> readers_;
    std::uint64_t published_ = 0;
    std::int64_t ticks_ = 0, camera_sequence_ = 0;  ///< of the last picture
    std::int64_t counted_ = 0;
    std::int64_t sequence_offset_ = 0;
    bool is_held_back_ = false;  ///< a fault withholds pictures at present
    std::int64_t last_sequence_ = -1;
    TimeNs last_stamp_ns_ = 0;
    TimeNs clock_error_ns_ = 0;  ///< at the last picture
    TimeNs last_write_ns_ = 0;
    TimeNs late_ns_ = 0;  ///< how long after its instant the last new picture was written
};

}  // namespace camrig::device
