#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/image_size.h"
#include "core/base/rate.h"
#include "core/base/result.h"
#include "core/world/camera_spec.h"

/// What both media services say of streams: a profile is a camera's source, one of its streams and its head.
namespace camrig::onvif {

/// One of a camera's RTSP streams as it is now, with nothing left open. `codec` and `profile` are named as in outputs
/// of kind "rtsp".
struct VideoStream {
    std::string ending = {};  ///< after "NAME-" in tokens and "NAME/" in paths; empty: the main stream
    std::string codec = "h264";
    ImageSize size = {};
    Rate rate = {};
    int bitrate_kbps = 0;
    double key_interval_s = 2.0;
    std::string profile = "main";  ///< of h264
    int quality = 90;              ///< of mjpeg
};

inline constexpr std::string_view stream_endings[] = {"", "sub", "mjpeg"};
std::string token_of(const world::CameraSpec& camera, const VideoStream& stream);
/// The ending of a token's stream; the token may be a camera's name alone.
std::string_view stream_of_token(std::string_view token);
std::string_view camera_of_token(std::string_view token);

/// Pictures between two key frames.
int gov_length(const VideoStream& stream);

/// The codecs that a stream can have, and the sizes that it can have with one: that which it has among them.
std::vector<std::string> codecs_for(const world::CameraSpec& camera, const VideoStream& stream, bool has_h265);
std::vector<ImageSize> sizes_for(const world::CameraSpec& camera, const VideoStream& stream, const std::string& codec);
/// From the camera's rate downwards: every frame, every second, ..
std::vector<Rate> rates_for(const world::CameraSpec& camera);
struct IntRange {
    int low = 0, high = 0;
};
inline constexpr IntRange bitrate_range_kbps{16, 200'000};
inline constexpr IntRange quality_range{1, 100};
IntRange gov_range(const Rate& rate);

/// What a client wants a stream to be; what is not given stays.
struct StreamWish {
    std::optional<std::string> codec = {};
    std::optional<ImageSize> size = {};
    std::optional<double> frame_rate = {};  ///< one that is told for the present rate leaves it
    std::optional<double> bitrate_kbps = {};
    std::optional<double> gov_length = {};
    std::optional<std::string> profile = {};
    std::optional<double> quality = {};
    double told_rate = 0.0;  ///< how the answer to the client shows the present rate
};
/// The camera's output of kind "rtsp" that fulfils the wish: the one that it has, changed, or one with what is unlike
/// the defaults. A bit rate out of range is taken as the nearest one, as ONVIF Media2 wants it ("SetVideoEncoder
/// Configuration"), and quality is left out where the codec has none; anything else that cannot be is invalid_argument.
/// Pure.
Result<OutputSpec> output_for(const world::CameraSpec& camera, const VideoStream& stream, const StreamWish& wish,
                              bool has_h265);

}  // namespace camrig::onvif
