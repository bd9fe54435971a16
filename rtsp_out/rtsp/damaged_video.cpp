#include "rtsp_out/rtsp/damaged_video.h"

namespace camrig::rtsp {
namespace {

/// The NAL unit's header and the begin of the slice's, without which decoders do not try.
constexpr std::size_t kept_bytes = 12;

/// H.264: IDR. H.265: those that a decoder can begin with (table 7-1, IRAP).
bool is_key(const Nal& nal, NalCodec codec) {
    const int type = nal.type(codec);
    return codec == NalCodec::h264 ? type == 5 : type >= 16 && type <= 23;
}

}  // namespace

fault::Damaged damaged_video(const fault::FrameFaults& faults, std::span<const std::byte> access_unit, NalCodec codec) {
    fault::Damaged damaged;
    std::vector<std::byte>& out = damaged.bytes;
    std::uint64_t slices = 0;
    for (auto nal = next_nal(access_unit, 0); nal; nal = next_nal(access_unit, nal->end)) {
        const auto bytes = access_unit.subspan(nal->begin, nal->end - nal->begin);
        const bool is_slice = nal->is_slice(codec);
        const std::uint64_t index = slices;
        slices += is_slice ? 1 : 0;
        if (const fault::Fault* const dropper =
                is_slice ? slice_dropper(faults, index, is_key(*nal, codec)) : nullptr) {
            harm_of(damaged.harms, *dropper, access_unit.size()).add(nal->begin, bytes.size());
            continue;
        }
        const std::size_t kept = nal->header - nal->begin + kept_bytes, at = out.size() + kept;
        out.insert(out.end(), bytes.begin(), bytes.end());
        if (is_slice && at < out.size())
            damage_slice(faults, index, std::span(out).subspan(at), nal->begin + kept, access_unit.size(),
                         damaged.harms);
    }
    return damaged;
}

}  // namespace camrig::rtsp
