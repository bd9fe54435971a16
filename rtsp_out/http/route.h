#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/stream/frame_bus.h"
#include "rtsp_out/http/target.h"

namespace camrig::http {

/// What a path stands for. `file` is everything else: the web page and its parts.
enum class RouteKind : std::uint8_t {
    file,
    cameras,
    stream,
    live,
    picture,
    floats,  ///< a picture of float32 as a NumPy file
    truth,
    rpc,
    healthz,
    metrics,
    device
};

/// A row of the table of paths that the server answers.
struct HttpPath {
    std::string_view path = "/";  ///< of a camera, what follows /cameras/NAME/
    RouteKind kind = RouteKind::file;
    bool takes_post = false;                           ///< POST only; else GET and HEAD only
    bool is_guarded = false;                           ///< refused to pages of other origins (check_page)
    frame::FrameKind frame = frame::FrameKind::color;  ///< of a camera
    codec::Codec codec = codec::Codec::raw;            ///< of a picture: jpeg or png
    std::string_view url = {};                         ///< of a camera: its name among the `urls` of /cameras
};
std::span<const HttpPath> rig_paths();
std::span<const HttpPath> camera_paths();

struct HttpRoute : HttpPath {
    std::string camera;  ///< of camera_paths()
};

/// The route of a path. Pure. not_found: a path below /cameras/ that does not exist; the message lists those that do.
Result<HttpRoute> route_of(std::string_view path);

/// The same for ports of network cameras, which have /onvif/... (POST) and /cameras/NAME/snapshot.jpg.
Result<HttpRoute> device_route_of(std::string_view path);

/// `?fps=` and `?quality=` of a stream.
struct StreamParams {
    std::optional<Rate> rate;
    std::optional<int> quality;  ///< default: the camera's (MjpegOutput)
};
Result<StreamParams> stream_params(const Target& target);

inline constexpr std::size_t max_live_cameras = 64;
/// Widths that /live scales to: few, so that its readers share encodings.
inline constexpr int live_widths[] = {160, 320, 640, 1280};

/// `?cameras=`, `?width=`, `?fps=` and `?quality=` of /live.
struct LiveParams {
    std::vector<std::string> cameras;  ///< each once, 1 to max_live_cameras
    int width = 0;                     ///< one of live_widths; 0: each camera's own
    std::optional<Rate> rate;
    int quality = codec::default_jpeg_quality;
};
Result<LiveParams> live_params(const Target& target);

/// What to fetch for a picture, depth or truth route: `?quality=` (JPEG only) and `?min_ns=`.
Result<stream::FetchRequest> fetch_request(const HttpRoute& route, const Target& target);

/// Fails when the target has a parameter (other than `token` and `t`, which are never refused) that this route does not
/// know.
Result<void> no_params(const Target& target);

}  // namespace camrig::http
