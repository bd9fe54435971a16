#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/image_size.h"
#include "core/base/output_family.h"
#include "core/base/rate.h"
#include "core/codec/encoder.h"

namespace camrig::rtsp {

enum class RtspCodec : std::uint8_t { h264, h265, mjpeg };
std::span<const Named<RtspCodec>> names_of(std::type_identity<RtspCodec>);
enum class RtspStream : std::uint8_t { main, sub };
std::span<const Named<RtspStream>> names_of(std::type_identity<RtspStream>);

/// The options of an output {kind: "rtsp"}: how one of a camera's three RTSP streams is encoded. Every camera has them:
/// the main stream, the sub stream, and the main stream's pictures as JPEG.
struct RtspOutput {
    RtspCodec codec = RtspCodec::h264;
    RtspStream stream = RtspStream::main;
    std::optional<ImageSize> size = {};         ///< of sub; default: half the camera's
    std::optional<Rate> fps = {};               ///< default: the camera's; of sub, half of it
    int quality = codec::default_jpeg_quality;  ///< of mjpeg
    // Of h264 and h265:
    std::optional<int> bitrate_kbps = {};  ///< default: from size and rate, see default_bitrate_kbps()
    double key_interval_s = 2.0;           ///< a key frame at least so often
    std::string preset = "superfast";      ///< x264's and x265's names, ultrafast .. slow; others take what is nearest
    std::string profile = "main";          ///< of h264: baseline, main or high
};
FieldTable<RtspOutput> fields_of(std::type_identity<RtspOutput>);

OutputFamily rtsp_family();

/// What follows a camera's name in the URL of that stream: "", "/sub" or "/mjpeg".
std::string_view path_ending(const RtspOutput& output);

/// One stream of a camera, with all defaults filled in.
struct StreamSettings {
    RtspOutput options = {};
    ImageSize size = {};
    Rate rate = {};
    int bitrate_kbps = 0;  ///< of h264 and h265
};
/// The three streams of a camera of this size and rate that has these outputs: main, sub, mjpeg. Pure.
std::vector<StreamSettings> streams_of(const std::vector<OutputSpec>& outputs, ImageSize size, const Rate& rate);

/// Whether RTP can carry the stream. JPEG only in sizes of multiples of 8 up to 2040 (RFC 2435).
bool can_be_carried(const StreamSettings& stream);

/// 0.15 bits per pixel, at least 200 kbit/s: 1.2 Mbit/s for 640x480 at 25, 7.8 Mbit/s for 1920x1080 at 25.
int default_bitrate_kbps(ImageSize size, const Rate& rate);

}  // namespace camrig::rtsp
