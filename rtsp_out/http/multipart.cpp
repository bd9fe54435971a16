#include "rtsp_out/http/multipart.h"

#include "rtsp_out/http/reply.h"

namespace camrig::http {

std::string part_head(const stream::MediaUnit& unit, std::size_t bytes, WallOffset& wall, std::string_view camera) {
    // Header lines stay below 128 bytes and Content-Type has no parameters: limits of ffmpeg's mpjpeg reader.
    std::string head = "Content-Type: image/jpeg\r\nContent-Length: " + std::to_string(bytes) + "\r\n";
    if (!camera.empty()) head.append("X-Camera: ").append(camera).append("\r\n");
    for (const auto& [name, value] : frame_fields(unit.info, wall))
        head.append(name).append(": ").append(value).append("\r\n");
    return head + "\r\n";
}

}  // namespace camrig::http
