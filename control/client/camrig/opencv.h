#pragma once

#include <cstring>

#include <camrig/error.h>
#include <camrig/frame.h>
#include <opencv2/core.hpp>

/// Link camrig::opencv: find_package(camrig REQUIRED COMPONENTS opencv).
namespace camrig::client {

/// A raw frame as OpenCV likes it, a copy: color is CV_8UC3 in BGR, depth CV_32FC1 in metres, instance and semantic
/// CV_32SC1, normal CV_32FC3, flow CV_32FC2, soiling CV_8UC1, numbers of a sensor CV_16UC1 (not of filter rgb). Error
/// invalid_argument for a frame that travelled as png or jpeg: cv::imdecode takes its data.
inline cv::Mat to_mat(const Frame& frame) {
    const bool is_color = frame.pixels == "rgba8";
    const int type = is_color                                                           ? CV_8UC4
                     : frame.pixels == "flow32f"                                        ? CV_32FC2
                     : frame.pixels == "gray8"                                          ? CV_8UC1
                     : frame.pixels == "depth32f"                                       ? CV_32FC1
                     : frame.pixels == "id32"                                           ? CV_32SC1
                     : frame.pixels == "normal32f"                                      ? CV_32FC3
                     : frame.pixels == "gray16" || frame.pixels.rfind("bayer_", 0) == 0 ? CV_16UC1
                                                                                        : -1;
    if (type < 0) throw Error("invalid_argument", "to_mat: takes frames of format raw, not " + frame.format);
    cv::Mat raw(frame.size.height, frame.size.width, type);
    if (raw.total() * raw.elemSize() != frame.data.size())
        throw Error("internal", "to_mat: " + std::to_string(frame.data.size()) + " bytes are no picture of this size");
    std::memcpy(raw.data, frame.data.data(), frame.data.size());
    if (!is_color) return raw;
    cv::Mat bgr(raw.size(), CV_8UC3);
    const int pairs[] = {0, 2, 1, 1, 2, 0};
    cv::mixChannels(&raw, 1, &bgr, 1, pairs, 3);
    return bgr;
}

}  // namespace camrig::client
