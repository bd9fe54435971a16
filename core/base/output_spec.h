#pragma once

#include <optional>
#include <string>

namespace camrig {

/// One wished output of a camera. `kind` names a sink family ("v4l2", "device", "rtsp", "mjpeg"); which of the other
/// fields matter is the family's affair.
struct OutputSpec {
    std::string kind;
    std::optional<int> number;   ///< v4l2, device: N of /dev/videoN
    std::string format;          ///< v4l2: YUYV, YU12, MJPG, BGR3
    std::string codec;           ///< rtsp: h264, mjpeg
    std::optional<int> quality;  ///< mjpeg: 1..100
    friend bool operator==(const OutputSpec&, const OutputSpec&) = default;
};

}  // namespace camrig
