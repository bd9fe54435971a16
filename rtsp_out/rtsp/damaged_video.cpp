#include "rtsp_out/rtsp/damaged_video.h"

#include "core/fault/sending.h"

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

std::vector<std::byte> damaged_video(const fault::FrameFaults& faults, std::span<const std::byte> access_unit,
                                     NalCodec codec) {
    std::vector<std::byte> out;
    std::uint64_t slices = 0;
    for (auto nal = next_nal(access_unit, 0); nal; nal = next_nal(access_unit, nal->end)) {
        const auto bytes = access_unit.subspan(nal->begin, nal->end - nal->begin);
        const bool is_slice = nal->is_slice(codec);
        const std::uint64_t index = slices;
        slices += is_slice ? 1 : 0;
        if (is_slice && is_slice_dropped(faults, index, is_key(*nal, codec))) continue;
        const std::size_t at = out.size() + (nal->header - nal->begin) + kept_bytes;
        out.insert(out.end(), bytes.begin(), bytes.end());
        if (is_slice && at < out.size()) damage_slice(faults, index, std::span(out).subspan(at));
    }
    return out;
}

}  // namespace camrig::rtsp
