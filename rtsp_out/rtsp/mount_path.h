#pragma once

#include <string>
#include <string_view>

namespace camrig::rtsp {

/// The mount point of a request's URL path, which may name a stream of it (SETUP): "/lobby/mjpeg" for
/// "/lobby/mjpeg/stream=0" and "/lobby/mjpeg/".
inline std::string mount_path_of(std::string_view url_path) {
    if (const auto stream = url_path.find("/stream="); stream != std::string_view::npos)
        url_path = url_path.substr(0, stream);
    while (url_path.size() > 1 && url_path.ends_with('/')) url_path.remove_suffix(1);
    return std::string(url_path);
}

}  // namespace camrig::rtsp
