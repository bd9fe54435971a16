// The bitstream step of RTSP: access units of any encoder go in, and what is put in is found again.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "tests/unit/rtsp_out/rtsp/find_frame_times.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace camrig;
    const std::span bytes(reinterpret_cast<const std::byte*>(data), size);
    for (const rtsp::NalCodec codec : {rtsp::NalCodec::h264, rtsp::NalCodec::h265}) {
        const auto there = rtsp::find_frame_times(bytes, codec);
        const rtsp::FrameTimes times{static_cast<std::int64_t>(size), 2, 3, 4};
        const auto unit = with_frame_times(bytes, times, codec);
        if (unit.size() == size) continue;  // no slice
        const auto found = rtsp::find_frame_times(unit, codec);
        if (!found || *found != (there ? *there : times)) std::abort();
    }
    return 0;
}
