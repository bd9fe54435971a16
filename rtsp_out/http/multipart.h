#pragma once

#include <string>
#include <string_view>

#include "core/base/wall_offset.h"
#include "core/stream/sink.h"

namespace camrig::http {

/// The text around the JPEG parts of a stream's body, in the form that stock readers take: ffmpeg and OpenCV want the
/// body to begin with a boundary line and a Content-Type of exactly "image/jpeg"; Chrome shows a picture only when the
/// next boundary line has come (crbug 527446), so that line follows each picture at once.
inline constexpr std::string_view boundary_line = "--frame\r\n";
inline constexpr std::string_view after_picture = "\r\n--frame\r\n";
/// In place of it, where a fault leaves the boundary out.
inline constexpr std::string_view without_boundary = "\r\n";
/// The boundary line of a next part is out already: an empty part, then the end.
inline constexpr std::string_view closing = "\r\n--frame--\r\n";

/// The header fields of a part with Content-Length `bytes` (which a fault may make wrong), with the empty line after
/// them. `camera`: named in X-Camera unless empty.
std::string part_head(const stream::MediaUnit& unit, std::size_t bytes, WallOffset& wall, std::string_view camera = {});

}  // namespace camrig::http
