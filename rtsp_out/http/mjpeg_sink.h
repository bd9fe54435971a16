#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "core/stream/sink.h"
#include "rtsp_out/http/async_event.h"

namespace camrig::http {

/// The sink of one MJPEG client: a single slot between the output's worker and the connection.
///
/// A unit that is not sent yet is replaced by the next one and counted as dropped, so a slow client sees the newest
/// picture and costs two JPEGs of memory at most. In lockstep the unit's latch is held until its bytes are in the
/// kernel's send buffer. Sink calls: the output's thread. take() and what follows: the server's thread.
class MjpegSink final : public stream::Sink {
public:
    /// A unit on its way; whoever has it must hand it to sent() or dropped().
    struct InFlight {
        stream::MediaUnit unit;
        stream::DeliveryLatch::Hold hold;
    };

    MjpegSink(AsyncEventRef event, const std::string& camera, const std::string& peer)
        : event_(std::move(event)), who_("MJPEG reader " + peer + " of camera " + camera) {}
    ~MjpegSink() override { abandon(); }

    Result<void> open(const stream::StreamInfo& info) override;
    Result<void> write(const stream::MediaUnit& unit) override;
    /// No more units will come; the one that waits may still be taken.
    void close() noexcept override;
    void hold_back() override;
    void reset() override { is_reset_ = true; }

    /// The unit to send next; nullopt: none has come since.
    std::optional<InFlight> take() { return slot_.take(); }
    /// The subscription is over; what take() still gives is the last.
    bool ended() const { return is_ended_; }
    /// After ended(): a fault wants the TCP connection reset (RST) in place of an orderly end.
    bool is_reset() const { return is_reset_; }
    /// A fault withholds pictures from the client at present.
    bool is_held_back() const { return is_held_back_; }
    /// Counts the unit as delivered, and releases its latch.
    void sent(InFlight&& item, std::size_t bytes);
    /// Counts the unit as dropped, and releases its latch.
    void dropped(InFlight&& item);
    /// The client is gone: drops the waiting unit and all later ones.
    void abandon();

private:
    const AsyncEventRef event_;
    const std::string who_;
    std::shared_ptr<stream::ReaderStats> stats_;  ///< from open() on, so before there is a unit
    LatestSlot<InFlight> slot_{[event = event_] { event->set(); }};
    std::atomic<bool> is_ended_{false}, is_held_back_{false}, is_reset_{false};
};

}  // namespace camrig::http
