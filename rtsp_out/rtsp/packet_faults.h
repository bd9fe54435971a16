#pragma once

#include <cstddef>
#include <deque>
#include <vector>

#include "core/fault/line.h"
#include "core/fault/sending.h"
#include "rtsp_out/rtsp/gst_handle.h"

namespace camrig::rtsp {

/// Network faults on the RTP packets of one stream: loss, reordering, delay, and a line of limited bit rate.
///
/// In lockstep a step waits until no packet refers to the picture's memory. So a reordered packet is sent with the last
/// packet of its picture at the latest, and of a packet that is delayed beyond that a copy is kept, which is sent with
/// a packet of a later picture.
///
/// Thread: the pipeline's streaming thread.
class PacketFaults {
public:
    static constexpr std::size_t max_held = 128;      ///< packets kept back for reordering at a time
    static constexpr std::size_t max_delayed = 4096;  ///< delayed packets at a time; further ones are not delayed

    /// One packet comes in; those to be sent now, in this order, are appended to `sent`: this one, unless it is lost or
    /// kept back, and earlier ones whose time has come. `faults`: of the newest picture; null: none.
    void pass(GstBufferHandle packet, const fault::FrameFaults* faults, std::vector<GstBufferHandle>& sent);
    /// The same for the packet or packet list that a probe of `pad` sees: replaces it by what is to be sent.
    GstPadProbeReturn replace(GstPad* pad, GstPadProbeInfo* info, const fault::FrameFaults* faults);

private:
    struct Held {
        GstBufferHandle packet;
        int overtaken_by = 0;  ///< so many are still to go before it
    };
    struct Delayed {
        GstBufferHandle packet;           ///< a copy
        TimeNs since_ns = 0, due_ns = 0;  ///< world time
    };
    /// Sends what has been on its way for long enough, or all.
    void arrive(const fault::FrameFaults* faults, std::vector<GstBufferHandle>& sent);
    /// Of the next packet: whose picture it is of, and which of that picture's it is. RTP's own numbers begin at random
    /// (RFC 3550, 5.1), and a run that is made again is to lose the same.
    std::uint64_t next_number(const fault::FrameFaults& faults);
    /// Notes what of the picture was lost, when its last packet has come here, lost or not.
    void tell_lost(const fault::FrameFaults* faults);
    void release(bool all, std::vector<GstBufferHandle>& sent);

    /// Nothing fails and nothing waits: packets go on as they are.
    bool is_idle(const fault::FrameFaults* faults) const {
        return faults == nullptr && held_.empty() && delayed_.empty();
    }

    bool is_sending_ = false;  ///< a packet that was here before goes through the probe
    std::deque<Held> held_;
    std::deque<Delayed> delayed_;
    fault::Line line_;
    std::int64_t frame_ = -1;        ///< of the last packet
    std::uint64_t packets_ = 0;      ///< of it, so far
    std::size_t bytes_ = 0;          ///< of all packets of the picture, so far
    std::vector<fault::Harm> lost_;  ///< of them; a run is a packet
};

}  // namespace camrig::rtsp
