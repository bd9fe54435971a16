#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "core/stream/sink.h"
#include "rtsp_out/http/doorbell.h"

namespace camrig {

/// One client's end of a stream: a single slot between the output's worker and the connection.
///
/// A unit that is not sent yet is replaced by the next one and counted as dropped, so a slow client sees the newest
/// picture and costs two JPEGs of memory at most. In lockstep the unit's latch is held until its bytes are with the
/// kernel. Sink side: the output's thread. take() and what follows: the server's thread.
class MjpegSink final : public Sink {
public:
    /// A unit on its way; whoever has it must hand it to sent() or dropped().
    struct InFlight {
        MediaUnit unit;
        DeliveryLatch::Hold hold;
    };

    MjpegSink(std::shared_ptr<Doorbell> bell, const std::string& camera, const std::string& peer)
        : bell_(std::move(bell)), who_("MJPEG reader " + peer + " of camera " + camera) {}
    ~MjpegSink() override { abandon(); }

    Result<void> open(const StreamInfo& info) override;
    Result<void> write(const MediaUnit& unit) override;
    /// No more units will come; the one that waits may still be taken.
    void close() noexcept override;

    std::optional<InFlight> take();
    bool ended() const;
    void sent(InFlight&& item, std::size_t bytes);
    void dropped(InFlight&& item);
    /// The client is gone: drops what waits and whatever still comes.
    void abandon();

private:
    const std::shared_ptr<Doorbell> bell_;
    const std::string who_;

    mutable std::mutex mutex_;  ///< guards what follows; holds are released outside of it
    std::shared_ptr<ReaderStats> stats_;
    std::optional<InFlight> slot_;
    bool ended_ = false;
    bool abandoned_ = false;
};

}  // namespace camrig
