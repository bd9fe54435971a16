#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/base/output_family.h"
#include "core/codec/encoder.h"

namespace camrig::rtsp {

enum class RtspCodec : std::uint8_t { h264, mjpeg };
std::span<const Named<RtspCodec>> names_of(std::type_identity<RtspCodec>);

/// The options of an output {kind: "rtsp"}: how one of a camera's two RTSP streams, which every camera has, is encoded.
struct RtspOutput {
    RtspCodec codec = RtspCodec::h264;
    int quality = codec::default_jpeg_quality;  ///< of mjpeg
    // Of h264:
    std::optional<int> bitrate_kbps = {};  ///< default: from size and rate, see default_bitrate_kbps()
    double key_interval_s = 2.0;           ///< a key frame at least so often
    std::string preset = "superfast";      ///< x264's names, ultrafast .. slow; other encoders take what is nearest
    std::string profile = "main";          ///< baseline, main or high
};
FieldTable<RtspOutput> fields_of(std::type_identity<RtspOutput>);

OutputFamily rtsp_family();

}  // namespace camrig::rtsp
