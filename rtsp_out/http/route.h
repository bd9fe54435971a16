#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/stream/frame_bus.h"
#include "rtsp_out/http/target.h"

namespace camrig {

/// What a path stands for. `file` is everything else: the web page and its parts.
enum class RouteKind : std::uint8_t { file, cameras, stream, picture, depth_npy, truth, rpc, healthz, metrics };

struct HttpRoute {
    RouteKind kind = RouteKind::file;
    std::string camera;  ///< stream, picture, depth_npy, truth
    FrameKind frame = FrameKind::color;
    Codec codec = Codec::raw;  ///< picture: jpeg or png
};

/// Pure. Not found: a path below /cameras/ that names nothing; the error lists what a camera has.
Result<HttpRoute> route_of(std::string_view path);

/// `?fps=` and `?quality=` of a stream.
struct StreamParams {
    std::optional<Rate> rate;
    int quality = default_jpeg_quality;
};
Result<StreamParams> stream_params(const Target& target);

/// What to fetch for a picture, depth or truth route: `?quality=` (JPEG only) and `?min_ns=`.
Result<FetchRequest> fetch_request(const HttpRoute& route, const Target& target);

/// Fails when the target has a parameter (other than `token` and `t`, which are never refused) that this route does not
/// know.
Result<void> no_params(const Target& target);

}  // namespace camrig
