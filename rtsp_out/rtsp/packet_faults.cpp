#include "rtsp_out/rtsp/packet_faults.h"

#include <utility>

#include "core/fault/sending.h"
#include "rtsp_out/rtsp/rtp_packet.h"

namespace camrig::rtsp {
namespace {

/// A packet each, also where they are neighbours.
void lose(fault::Harm& harm, const fault::Harm::Run& packet) {
    harm.bytes += packet.bytes;
    ++harm.runs;
    if (harm.first.size() < fault::Harm::max_runs) harm.first.push_back(packet);
}

}  // namespace

std::uint64_t PacketFaults::next_number(const fault::FrameFaults& faults) {
    if (std::exchange(frame_, faults.frame.sequence) != faults.frame.sequence) packets_ = 0;
    return static_cast<std::uint64_t>(faults.frame.sequence) << 16 | (packets_++ & 0xFFFF);
}

void PacketFaults::pass(GstBufferHandle packet, const fault::FrameFaults* faults, std::vector<GstBufferHandle>& sent) {
    arrive(faults, sent);
    const bool is_last = ends_picture(packet.get());
    if (faults && rtp_sequence(packet.get())) {
        const std::uint64_t number = next_number(*faults);
        const std::size_t size = gst_buffer_get_size(packet.get());
        const fault::Fault* loser = packet_loser(*faults, number);
        const auto rate = line_rate(*faults, "rtsp");
        if (!loser && !line_.takes(rate, faults->frame.world_ns, size)) loser = rate->by.get();
        const bool is_lost = loser != nullptr;
        if (is_lost) lose(harm_of(lost_, *loser, 0), {bytes_, size});
        bytes_ += size;
        const int distance = is_lost || is_last ? 0 : packet_distance(*faults, number);
        if (distance > 0 && held_.size() < max_held) {
            held_.push_back({std::move(packet), distance});
            return;
        }
        const TimeNs delay_ns = is_lost || delayed_.size() == max_delayed ? 0 : packet_delay_ns(*faults, number);
        if (delay_ns > 0)
            delayed_.push_back({GstBufferHandle(gst_buffer_copy_deep(packet.get())), faults->frame.world_ns,
                                faults->frame.world_ns + delay_ns});
        if (is_lost || delay_ns > 0) packet.reset();
    }
    if (packet) {
        sent.push_back(std::move(packet));
        for (Held& one : held_) --one.overtaken_by;
    }
    if (is_last) tell_lost(faults);
    release(is_last, sent);
}

void PacketFaults::tell_lost(const fault::FrameFaults* faults) {
    for (fault::Harm& harm : lost_) {
        harm.size = bytes_;
        if (faults) note(*faults, "rtsp", harm);
    }
    lost_.clear();
    bytes_ = 0;
}

void PacketFaults::arrive(const fault::FrameFaults* faults, std::vector<GstBufferHandle>& sent) {
    const auto is_due = [faults](const Delayed& one) {
        if (faults == nullptr) return true;
        const TimeNs now_ns = faults->frame.world_ns;
        return one.due_ns <= now_ns || now_ns < one.since_ns;  // time goes back: another world was loaded
    };
    for (Delayed& one : delayed_)
        if (is_due(one)) sent.push_back(std::move(one.packet));
    std::erase_if(delayed_, [](const Delayed& one) { return one.packet == nullptr; });
}

void PacketFaults::release(bool all, std::vector<GstBufferHandle>& sent) {
    for (Held& one : held_)
        if (all || one.overtaken_by <= 0) sent.push_back(std::move(one.packet));
    std::erase_if(held_, [](const Held& one) { return one.packet == nullptr; });
}

GstPadProbeReturn PacketFaults::replace(GstPad* pad, GstPadProbeInfo* info, const fault::FrameFaults* faults) {
    if (is_sending_ || is_idle(faults)) return GST_PAD_PROBE_OK;
    std::vector<GstBufferHandle> sent;
    const bool is_single = (GST_PAD_PROBE_INFO_TYPE(info) & GST_PAD_PROBE_TYPE_BUFFER) != 0;
    if (is_single) {
        pass(GstBufferHandle(gst_buffer_ref(GST_PAD_PROBE_INFO_BUFFER(info))), faults, sent);
    } else {
        GstBufferList* const list = GST_PAD_PROBE_INFO_BUFFER_LIST(info);
        for (guint i = 0; i < gst_buffer_list_length(list); ++i)
            pass(GstBufferHandle(gst_buffer_ref(gst_buffer_list_get(list, i))), faults, sent);
    }
    if (sent.empty()) return GST_PAD_PROBE_DROP;
    if (!is_single) {
        GstBufferList* const list = gst_buffer_list_new_sized(static_cast<guint>(sent.size()));
        for (GstBufferHandle& packet : sent) gst_buffer_list_add(list, packet.release());
        gst_buffer_list_unref(GST_PAD_PROBE_INFO_BUFFER_LIST(info));
        GST_PAD_PROBE_INFO_DATA(info) = list;
        return GST_PAD_PROBE_OK;
    }
    // A probe passes one packet on: the last. Those before it go by themselves.
    is_sending_ = true;
    for (std::size_t i = 0; i + 1 < sent.size(); ++i) gst_pad_push(pad, sent[i].release());
    is_sending_ = false;
    gst_buffer_unref(GST_PAD_PROBE_INFO_BUFFER(info));
    GST_PAD_PROBE_INFO_DATA(info) = sent.back().release();
    return GST_PAD_PROBE_OK;
}

}  // namespace camrig::rtsp
