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
    std::string subsampling;     ///< device, and v4l2 with format MJPG: 4:2:2, 4:2:0
    std::string codec;           ///< rtsp: h264, mjpeg
    std::optional<int> quality;  ///< mjpeg, and rtsp with codec mjpeg: 1..100
    // rtsp with codec h264:
    std::optional<int> bitrate_kbps;       ///< 16..200000
    std::optional<double> key_interval_s;  ///< a key frame at least so often; 0.01..60
    std::string preset;                    ///< ultrafast .. slow, as x264 names them
    std::string profile;                   ///< baseline, main, high
    friend bool operator==(const OutputSpec&, const OutputSpec&) = default;
};

}  // namespace camrig
